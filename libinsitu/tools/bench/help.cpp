#include "options.h"

namespace insitu::bench {

const char* help_text() {
  return R"(insitu-bench commit|locate|torture|scale|methods|amr|effects|render|advect|accuracy|scaling|sections [options]
       insitu-bench paper morrical|rathke|zellmann [options]

Times libinsitu on the standard workload, checks its answers and holds them against VTK's.
  commit   building and refitting the acceleration structure, cold and warm
  locate   point queries, with Newton's parametric coordinates, and sampling of fields
  torture  who loses or misplaces how many points on small meshes of all hard cases
  scale    cost of build and queries by number of cells, and of queries by size of the batch
  amr      an adaptive mesh: the dual mesh with gridlets beside the same as plain hexahedra, and
           the solver's own cells (`nearest`); with --peers Open VKL's AMR volume; frames with and
           without culling by the transfer function; or, with --sizes, by number of leaves
  effects  what each effect of a frame adds to the bare one, in time and memory, alone and together
  render   frames of a volume: seconds, samples a second and error by step, one core and all; with
           --peers vtkUnstructuredGridVolumeRayCastMapper's and Open VKL's; Rathke 2015, tables 1 to 4
  advect   particles through the ABC flow: steps a second, error and lost ones by method, plain and
           with steps that end at faces, one core and all; with --peers vtkStreamTracer's RK4 and RK45
  accuracy what each choice that trades accuracy for time costs: tables, plots and a page to read
  scaling  the same work on several processes (MPI): processor time, messages and bytes beside what a model
           says that they should be; starts itself under mpiexec
  sections the same work on a curvilinear block in packed arrays and in sections of larger ones, in turns
  paper    the tables and figures of a paper that libinsitu is built on, in its own rows and columns, on
           meshes of ours, its figures beside them
  methods  every locator method on every backend that is here: Morrical 2020, tables 1 to 3

The mesh (commit, locate, scale, effects, render, advect)
  --shape hex|tet|wedge|pyramid|mixed|poly|hexfaces   cells of the unit box [hex; methods: tet, hex, wedge, mixed];
                    locate, commit: also truncated octahedra, and hexahedra that are given by their faces
  --kind even|graded|layers|sparse [even]
                    equal steps | edge lengths that grow 1e4-fold along each axis |
                    cells 1e4 to 1e6 times as wide as thick | 24 balls, about 5 % of the box
  --cells N         the box with the number of cells nearest to N [1000000; amr: 4018176; advect: 262144; scaling: of all processes]; scale: N1,N2,...
                    [10000 to 30000000 in half decades]
  --jitter J        interior vertices move by up to J of a cell, 0 to 0.5 [0.2]
  --numbering natural|shuffled   x fastest, or cells and vertices numbered at random [natural]
  --mesh FILE.vtu   a mesh from a file instead (commit, locate; where built with VTK)
The queries (locate)
  --queries uniform|random|sorted|march|vertices|edges|faces [uniform]
                    every cell's centre in cell order | random cells, random points |
                    these in Morton order | along view rays, half a cell apart |
                    on vertices, edges, faces of random cells, as rounding leaves them
  --points Q        how many, but for uniform [as many as cells; torture: 2000 a case; advect: 2000 seeds; scaling: 400000; amr: 1000000
                    random ones, beside a raster of 160^3, or of as many as Q if that is less; methods: random
                    ones; a processor answers a million by bvh, 100000 by rays]
  --accuracy standard|exact [standard]
  --fields N        also samples N vertex fields at once against one, through insitu.h [1]
The adaptive meshes
  --sizes           dual meshes by number of leaves instead: builds, and Zellmann 2023, tables 1 to 3
The methods
  --backend cpu|cuda|optix, --method NAME   these only (may be repeated); NAME as in a scene's locator
  --check           compares answers alone, on all points, of pyramids and of twisted and of folded hexahedra as well
The run
  --threads T       0: all that the process may use [1]
  --repetitions R   medians of R repetitions [5; scale, methods, amr, effects, render, advect, accuracy, paper: 3]
  --peers           render, advect: also VTK's; render, amr: also Open VKL's, where built with it; locate: also
                    peers, on one thread, interleaved with ours
  --peer NAME       the same, this one only (may be repeated): vtkStaticCellLocator,
                    vtkCellTreeLocator, vtkCellLocator, vtkProbeFilter; OpenVKL where
                    built with -DINSITU_BENCH_OPENVKL=ON
  --peer-points Q   peers answer the first Q points only (they can be very slow on graded meshes)
  --json FILE       writes the figures; - for standard output, instead of the table
  --csv FILE, --svg FILE   scale: the table, and a plot of it

Figures of commit and locate
  build_s      rebuild in Morton order into warm buffers
  refit_s      boxes fitted to moved vertices
  mqps         million points a second, located: cell and parametric coordinates
  mqps_sample  the same, located and one vertex field interpolated
  bytes        the tree; bytes_peak: with the builder's scratch
  lost         points that no cell claimed, though one holds them
  wrong        points answered by a cell that does not hold them, by exact arithmetic
  not_lowest   (vertices, edges, faces) points answered by another than the lowest id that holds
               them, by exact arithmetic: a tie the one-owner rule decides
  max_error    largest |sampled - exact| of the field x + 2 y + 3 z
Further figures of locate; ratios are of medians of processor time on one thread, else of wall time
  exact_over_standard   time of exact over time of standard, same points, same run
  sorted_inside         1: the library puts this batch into spatial order before it locates it
  mqps_unsorted         (random, sorted) the same points taken in their own order
  sort_ns               (random, sorted) the library's sort of the random points, a point
  boundary_over_random  (vertices, edges, faces) time over that of as many random points
  fields_over_one       (--fields N) time of sampling N fields at once over one
  single_us, single_exact_us, hinted_us   one point a call; with the answer before as a hint
  nodes_per_query, candidates_per_query   work in the tree
  reason_...            points by why they have their owner (insitu_reason)
  ratio_PEER            the peer's time over ours; ratio_unsorted_PEER: over that of mqps_unsorted

Torture
  Cases: jittered and twisted cells of all shapes, offsets of 1e7, aspect ratios of 1e6, slivers,
  collapsed hexahedra, inverted, folded, flat and doubled cells, reflex angles, tilted planar quads,
  neighbours that do not match, float32 coordinates. Points: inside, on faces, edges and vertices,
  and one unit in the last place beside these. The truth is the lowest id of the cells that hold the
  point by exact arithmetic, all cells asked. Ours answers in standard and exact, each as a batch,
  one by one and with hints; the worst of the three is printed: lost / wrong / not lowest, and
  the largest distance from the point to where the answer maps, over the cell's diameter.
  Where cells overlap without folding, the answer may be the hint's cell, or in standard any that is
  proven to hold the point (it is counted all the same).

Methods
  A table each: memory, with builds all at once and in groups; uniform and random samples a second, in
  fast (the papers' rules; in float but where
  the processor looks into cells), standard and exact, for ids alone, a cell's value and an
  interpolated one; how many points were answered otherwise than by exact bvh on the CPU, of the random ones
  and of a tenth as many on faces, edges and vertices; joules,
  from NVML or RAPL where they can be read. Points and answers of a device stay in its memory.

Render
  The volume of x + 2 y + 3 z. Times on one core are processor time; steps are in units of the default
  step, half a cell. Error: the root of the mean square difference from the frame with an eighth of the
  default step, over linear colours from 0 to 1. Million samples a second located: of one tile in sixteen,
  nothing but answered. VTK draws the cells cut into tetrahedra, on one thread, into 8 bits a colour;
  its window needs a display (xvfb-run gives one); ours held against it is the longest step that is no worse.
  Open VKL marches the standard workload's frame (eye at 1.6, 1.3, 2.2; a sample a cell) on one thread, 16 rays abreast, at
  our samples with our classification, with intervals of its iterator and from bounds to bounds (packets), in turns with
  ours; ratio: its time over ours. Error: from the frame with an eighth of the step.
  --size N          N x N pixels [512]
  --out FOLDER      writes the frames there as PNG

Accuracy
  --quick, --full   small meshes for a look, or large ones [--quick]
  --sweep NAME      only this one (may be repeated): locate, newton, advect, volume, path_tracing, amr, update, effects
  --out FOLDER      report.html, to be read from the top, and NAME.csv and NAME.svg of each sweep [accuracy]
  Errors are against a reference that is exact or far better converged; the default is marked in each plot, and its
  time and counted work over the least of a setting as accurate (the front) are printed.

Paper
  morrical (2020): tables 1 to 5, section 9.4; rathke (2015): tables 1 to 4; zellmann (2023): tables 1 to 4,
  figures 6 to 8. Data, sizes and machines are not the papers': ratios compare, and captions say what was
  normalised. Below a table stands what it leaves out.
  --cells N         of the largest mesh; the others in the paper's proportions, or as large as the paper's [300000]
  --full            as many cells as the memory that is free holds, at most the paper's
  --quick           small meshes and frames, for a test
  --table N         rathke: this table alone, 1 to 4
  --size N          frames of N x N pixels [256]; rates are given for the paper's 1024 x 1024
  --out FOLDER      a .csv of each table there, and plots

Scaling
  --processes N1,N2,...   [1,2,4,8]
  Hexahedra are cut into equal boxes, a process each. Strong: --cells, --points and a quarter as many particles are shared out;
  weak: each process has an eighth of these. Commits with halos, points located here and everywhere, particles through the ABC
  flow, frames of --size pixels. doc/design/scale.md has the model. JSON: a row each, counted and model.

Amr
  The mesh: blocks about a sphere in three levels, 4,018,176 leaves, as patches and as octree leaves. A row each:
  a regrid from the solver's arrays to ready to sample, a commit of new values, million samples a second at
  random points and on a raster, megabytes of the cells with one field and of the tree, points without a
  value, the largest error at the cells' centres and how many it is above 1e-5 at. JSON keys: leaves, build_s, fields_s,
  mqps, mqps_raster, bytes, compression (of cubes, as in Zellmann 2023, table 2), gridlets, cubes, stitching, folded,
  repaired, lost, max_error_at_centres, wrong_at_centres. With --peers Open VKL's AMR volume of the same blocks, a batch in
  one call, in turns with ours: its octant (continuous) with the dual mesh of the patches, its finest with their
  `nearest`; ratio_random and ratio_raster: its time over ours.

Exit code: 0; 1 if the run failed, methods found an `exact` answer that is not bvh's, or torture found that ours lost or misplaced a point, gave a false
reason, or answered differently by another way; 2 if the arguments cannot be used.
)";
}

} // namespace insitu::bench
