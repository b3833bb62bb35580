/** @file vtk.hpp
 *  VTK data sets as meshes of a session, without copying their arrays; and answers as VTK files.
 *  Link insitu::vtk. Errors are insitu::Error. */
#ifndef INSITU_VTK_HPP
#define INSITU_VTK_HPP

#include <vtkSmartPointer.h>

#include "insitu/insitu.hpp"

class vtkDataObject;
class vtkDataSet;
class vtkPolyData;

#if defined(INSITU_STATIC)
#define INSITU_VTK_API
#else
#define INSITU_VTK_API __attribute__((visibility("default")))
#endif

namespace insitu::vtk {

/** An array that is not read in place, and why. */
struct Note {
  std::string array;
  std::string reason;
};

struct AttachOptions {
  int piece = 0;
  /** Names of point and cell arrays; empty: all. */
  std::vector<std::string> arrays = {};
  /** Whether arrays that cannot be read in place (integers, implicit arrays) are converted to
   *  float64; if not, they are left out. A strict session refuses what was converted. */
  bool convert = true;
};

/** What keeps an attached data set's arrays alive, and the copies that had to be made. Keep it as
 *  long as the mesh uses the data set. */
class INSITU_VTK_API Attachment {
public:
  Attachment(Attachment&&) noexcept;
  Attachment& operator=(Attachment&&) noexcept;
  ~Attachment();

  /** The next state of the same piece: of the same data set, or of another one. What is equal is
   *  not given again, so a moving mesh is refitted and not rebuilt. An array that is the same
   * object as before counts as changed if its modification time is newer, another object if its
   * values differ. Returns what changed; on an error the earlier state stays attached as far as it
   * was not replaced. */
  Change update(vtkDataSet* data);

  /** Arrays that were converted (also marked so in Mesh::audit), and arrays left out. */
  const std::vector<Note>& converted() const;
  const std::vector<Note>& skipped() const;

private:
  friend INSITU_VTK_API Attachment attach(Mesh&, vtkDataSet*, const AttachOptions&);
  struct State;
  explicit Attachment(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/** Gives a data set to a mesh; nothing is committed.
 *  - vtkUnstructuredGrid of tetrahedra, voxels, hexahedra, wedges and pyramids (32 or 64 bit
 *    storage), vtkStructuredGrid, vtkRectilinearGrid, vtkImageData; with at least 2 points along
 *    each axis of the structured ones. Cells of fewer dimensions (boundary faces, edges) beside
 *    cells of volume are left out, and keep their numbers; skipped() counts them. Other cells:
 *    INSITU_ERROR_UNSUPPORTED names the first. A data set without cells adds nothing, and the
 *    fields of other pieces stay.
 *  - Points, point data and cell data of float and double are read in place, interleaved
 *    (vtkAOSDataArrayTemplate) or with one array a component (vtkSOADataArrayTemplate).
 *  - The cell array vtkGhostType becomes the ghosts, converted if it is of another type than
 *    unsigned char. Of a point array and a cell array of one name
 *    the point array is taken. */
[[nodiscard]] INSITU_VTK_API Attachment attach(Mesh& mesh, vtkDataSet* data,
                                               const AttachOptions& options = {});

/** The same for an adaptive mesh: it is the whole mesh, whose pieces are patches or leaves. */
class INSITU_VTK_API AdaptiveAttachment {
public:
  AdaptiveAttachment(AdaptiveAttachment&&) noexcept;
  AdaptiveAttachment& operator=(AdaptiveAttachment&&) noexcept;
  ~AdaptiveAttachment();

  /** The next state, of the same data object or another one. Equal cells are not given again, so
   *  that nothing is rebuilt; equal arrays neither (see Attachment::update). Returns what changed.
   */
  Change update(vtkDataObject* data);

  const std::vector<Note>& converted() const;
  const std::vector<Note>& skipped() const;

private:
  friend INSITU_VTK_API AdaptiveAttachment attach_adaptive(Mesh&, vtkDataObject*,
                                                           const AttachOptions&);
  struct State;
  explicit AdaptiveAttachment(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/** Gives an adaptive data object to an empty mesh; nothing is committed. Cell arrays of float and
 *  double are read in place; those that some grid lacks are left out.
 *  - vtkOverlappingAMR: a patch a grid that is here, of levels whose spacing halves or quarters.
 *    Cells under finer grids (blanked, REFINEDCELL) are masked by the library; layers of
 *    DUPLICATECELL around a grid are left out, and must leave a box; HIDDENCELL:
 *    INSITU_ERROR_UNSUPPORTED.
 *  - vtkHyperTreeGrid of three dimensions and branch factor 2, with equal trees: a list of leaves,
 *    whose levels and corners are copies. Masked leaves and those that are ghosts are left out:
 * they are holes. */
[[nodiscard]] INSITU_VTK_API AdaptiveAttachment attach_adaptive(Mesh& mesh, vtkDataObject* data,
                                                                const AttachOptions& options = {});

/** Points as vertices of a vtkPolyData, with their samples as point data, and found, cell and piece
 *  of each. points: interleaved, one a sample. Everything is copied. */
INSITU_VTK_API vtkSmartPointer<vtkPolyData> sampled_points(View<const double> points,
                                                           const FieldSamples& samples);
INSITU_VTK_API vtkSmartPointer<vtkPolyData>
sampled_points(View<const double> points, const std::string& field, const Samples& samples);

/** Lines over points: line l takes the points from ends[l - 1] (0 for the first) to ends[l] - 1.
 * values: one item a point. */
INSITU_VTK_API vtkSmartPointer<vtkPolyData> tracks(View<const double> points,
                                                   View<const std::int64_t> ends,
                                                   const std::vector<FieldValues>& values = {});

/** Writes .vtp, .vtu, .vts, .vtr or .vti; the extension must fit the data. The file appears whole
 * or not at all (it is renamed once it is complete). Throws INSITU_ERROR_FILE. */
INSITU_VTK_API void write(const std::string& path, vtkDataSet* data);

/** A .pvd file: the index of a series in time, which ParaView opens. Rewritten at each add, whole
 * or not at all. */
class INSITU_VTK_API Series {
public:
  explicit Series(std::string path) : path_(std::move(path)) {}
  /** file: relative to the folder of the index. part: of a step with several files. */
  void add(double time, const std::string& file, int part = 0);

private:
  struct Entry {
    double time;
    int part;
    std::string file;
  };
  std::string path_;
  std::vector<Entry> entries_;
};

} // namespace insitu::vtk

#endif // INSITU_VTK_HPP
