#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "device/buffer.h"
#include "device/kernel_mesh.h"
#include "mesh/registered/mesh.h"

namespace insitu::device {

/// A registered mesh as kernels on the device see it: arrays in device memory are read in place, of
/// host arrays a copy is held. All calls but commit() are const; calls of one object are made one
/// at a time.
class DeviceMesh {
public:
  explicit DeviceMesh(core::Memory& memory);

  /// Brings the copies up to date and makes the views; what: INSITU_CHANGED_*, topology at first.
  /// Arrays that lie elsewhere than before are copied whatever it says. Returns when all is done.
  void commit(const mesh::Mesh& mesh, std::uint32_t what, StreamHandle stream);

  /// To pass to kernels by value: its pointers are of the device, so that mesh::gather and the
  /// accessors work there, and nothing but piece_count and the flags may be read on the host.
  const mesh::MeshView& view() const { return view_; }
  /// The same with its pieces and numbers of cells in host memory (and data pointers of the
  /// device).
  const mesh::MeshView& host_view() const { return host_view_; }
  /// The mesh as kernels take it among their arguments.
  KernelMesh in_kernels() const;
  std::int64_t cell_count() const { return host_view_.cell_count(); }
  std::int64_t vertex_count() const { return host_view_.vertex_count(); }

  /// Of the local frame, in the middle of the cells that own points; kept while the topology is.
  const math::Vec3d& origin() const { return origin_; }

  /// Float x, y, z of every vertex in the local frame, flat ids, rounded to nearest; made at the
  /// first call and kept up to date by commits from then on. For builds of rays' structures.
  const float* vertices(StreamHandle stream);
  void release_vertices();

  /// The fields with device pointers, for kernels on the stream: an array on the device, valid
  /// until the next commit. Throws INSITU_ERROR_FIELD if one is not of this mesh.
  const KernelField* fields(std::span<const mesh::FieldView> fields, StreamHandle stream) const;

  /// A component's pointer as the device sees it: into a copy, or the same. Throws if neither.
  const std::byte* on_device(const std::byte* p, const std::string& name) const;

  std::int64_t bytes() const;        ///< on the device
  std::int64_t bytes_copied() const; ///< of host arrays
  core::Memory& memory() const { return *memory_; }

private:
  /// Host memory that arrays cover, with its copy. Ranges that overlap are one: records hold many.
  struct Range {
    std::uintptr_t begin, end;
    std::uint32_t kinds; ///< INSITU_CHANGED_* that its arrays follow
    Buffer<std::byte> copy;
    std::size_t shift = 0; ///< of the first byte in the copy, so that alignment is the host's
  };
  /// Descriptions of some fields: FieldPieceViews and component pointers.
  struct FieldTable {
    std::vector<std::byte> key; ///< what was asked for, byte by byte
    Buffer<std::byte> data;
    std::vector<std::byte> host; ///< stays until copied
  };

  void copy_ranges(const mesh::Mesh& mesh, std::uint32_t what, StreamHandle stream);
  void translate_pieces(const mesh::MeshView& from);
  void fill_vertices(StreamHandle stream);

  core::Memory* memory_;
  std::vector<Range> ranges_;
  std::vector<mesh::ExternalArray::Range> device_ranges_; ///< arrays read in place
  std::vector<mesh::PieceView> pieces_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  mesh::MeshView view_, host_view_;
  Buffer<std::byte> tables_; ///< pieces, first cells, first vertices
  Buffer<float> vertices_;
  bool wants_vertices_ = false;
  math::Vec3d origin_;
  mutable std::vector<FieldTable> field_tables_;
};

} // namespace insitu::device
