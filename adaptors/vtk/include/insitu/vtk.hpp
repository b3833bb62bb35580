/** @file vtk.hpp
 *  VTK data sets become meshes of a session, without copying their arrays, and answers become VTK
 *  files. Programs link insitu::vtk. Errors are insitu::Error. */
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

/** An array that the library does not read in place, and why. */
struct Note {
  std::string array;
  std::string reason;
};

struct AttachOptions {
  int piece = 0;
  /** Names of the point and cell arrays to attach; empty: all of them. */
  std::vector<std::string> arrays = {};
  /** Whether the adaptor converts arrays that cannot be read in place (integers, implicit arrays)
   *  to float64. Otherwise it leaves them out. A strict session refuses converted arrays. */
  bool convert = true;
};

/** Keeps the arrays of an attached data set alive, and the copies that had to be made. The caller
 *  keeps the Attachment as long as the mesh uses the data set. */
class INSITU_VTK_API Attachment {
public:
  Attachment(Attachment&&) noexcept;
  Attachment& operator=(Attachment&&) noexcept;
  ~Attachment();

  /** Attaches the next state of the same piece, from the same data set or from another one. What is
   *  equal is not given again, so a moving mesh is refitted and not rebuilt. An array that is the
   *  same object as before counts as changed if its modification time is newer; another object
   *  counts as changed if its values differ. Returns what changed. After an error the earlier state
   *  stays attached as far as it was not replaced. */
  Change update(vtkDataSet* data);

  /** Return the arrays that were converted (Mesh::audit marks them too), and the arrays left
   *  out. */
  const std::vector<Note>& converted() const;
  const std::vector<Note>& skipped() const;

private:
  friend INSITU_VTK_API Attachment attach(Mesh&, vtkDataSet*, const AttachOptions&);
  struct State;
  explicit Attachment(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/** Gives a data set to a mesh; nothing is committed.
 *  - The data set is a vtkUnstructuredGrid of tetrahedra, voxels, hexahedra, wedges and pyramids
 *    (32 or 64 bit storage), a vtkStructuredGrid, vtkRectilinearGrid or vtkImageData; the
 *    structured ones have at least 2 points along each axis. Cells of fewer dimensions (boundary
 *    faces, edges) beside cells of volume are left out, and keep their numbers; skipped() counts
 *    them. For other cells INSITU_ERROR_UNSUPPORTED names the first. A data set without cells adds
 *    nothing, and the fields of other pieces stay.
 *  - The library reads points, point data and cell data of float and double in place, interleaved
 *    (vtkAOSDataArrayTemplate) or with one array a component (vtkSOADataArrayTemplate).
 *  - The cell array vtkGhostType becomes the ghosts, the point array of this name the hidden points
 *    (bit 2); the adaptor converts them if they are of another type than unsigned char. Values of
 *    _FillValue and missing_value in the field data are blank (insitu_mesh_field_blank): of one
 *    array if its name and a dot stand before (temperature._FillValue), otherwise of all arrays.
 *    Where a point array and a cell array have one name, the point array is taken. */
[[nodiscard]] INSITU_VTK_API Attachment attach(Mesh& mesh, vtkDataSet* data,
                                               const AttachOptions& options = {});

/** Does as Attachment for an adaptive mesh: the data object is the whole mesh, whose pieces are
 *  patches or leaves. */
class INSITU_VTK_API AdaptiveAttachment {
public:
  AdaptiveAttachment(AdaptiveAttachment&&) noexcept;
  AdaptiveAttachment& operator=(AdaptiveAttachment&&) noexcept;
  ~AdaptiveAttachment();

  /** Attaches the next state, from the same data object or from another one. Equal cells are not
   *  given again, so that nothing is rebuilt, and neither are equal arrays (see
   *  Attachment::update). Returns what changed. */
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

/** Gives an adaptive data object to an empty mesh; nothing is committed. The library reads cell
 *  arrays of float and double in place; the adaptor leaves out those that some grid lacks.
 *  - A vtkOverlappingAMR becomes one patch for each grid that is here, of levels whose spacing
 *    halves or quarters. The library masks cells under finer grids (blanked, REFINEDCELL). The
 *    adaptor leaves out layers of DUPLICATECELL around a grid, which must leave a box.
 *    INSITU_ERROR_UNSUPPORTED: a grid has HIDDENCELL.
 *  - A vtkHyperTreeGrid of three dimensions and branch factor 2, with equal trees, becomes a list
 *    of leaves, whose levels and corners are copies. The adaptor leaves out masked leaves and
 *    ghosts, which are holes. */
[[nodiscard]] INSITU_VTK_API AdaptiveAttachment attach_adaptive(Mesh& mesh, vtkDataObject* data,
                                                                const AttachOptions& options = {});

/** Makes a vtkPolyData whose vertices are the points, with their samples as point data, and found,
 *  cell and piece of each point. points: interleaved, one point a sample. Everything is copied. */
INSITU_VTK_API vtkSmartPointer<vtkPolyData> sampled_points(View<const double> points,
                                                           const FieldSamples& samples);
INSITU_VTK_API vtkSmartPointer<vtkPolyData>
sampled_points(View<const double> points, const std::string& field, const Samples& samples);

/** Makes a vtkPolyData of lines over points: line l takes the points from ends[l - 1] (0 for the
 *  first line) to ends[l] - 1. values: one item a point. */
INSITU_VTK_API vtkSmartPointer<vtkPolyData> tracks(View<const double> points,
                                                   View<const std::int64_t> ends,
                                                   const std::vector<FieldValues>& values = {});

/** Writes .vtp, .vtu, .vts, .vtr or .vti; the extension must fit the data. The file appears whole
 *  or not at all, since it is renamed once it is complete. Throws INSITU_ERROR_FILE. */
INSITU_VTK_API void write(const std::string& path, vtkDataSet* data);

/** A .pvd file is the index of a series in time, which ParaView opens. Each add() rewrites it,
 *  whole or not at all. */
class INSITU_VTK_API Series {
public:
  explicit Series(std::string path) : path_(std::move(path)) {}
  /** Adds a file of a time. file: its path relative to the folder of the index. part: its number in
   *  a step of several files. */
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
