#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "insitu/insitu.h"

#include "math/vec.h"
#include "mesh/registered/external_array.h"
#include "mesh/registered/mesh.h"

namespace insitu::api {

/// The points of a query.
class QueryPoints {
public:
  /// Checks the arguments; throws core::Error.
  explicit QueryPoints(const insitu_locate_args& args);

  std::int64_t count() const { return arrays_.front().layout.count; }
  /// The points where they are, or null if they lie otherwise than Vec3d's.
  const math::Vec3d* in_place() const;
  /// Points [first, first + out.size()) as doubles.
  void gather(std::int64_t first, std::span<math::Vec3d> out, const core::Threads& threads) const;
  const std::vector<mesh::ExternalArray>& arrays() const { return arrays_; }

private:
  std::vector<mesh::ExternalArray> arrays_;
};

/// Throws core::Error for a number below 0, or none.
void require_distance(double greatest_distance);
/// The distance that a caller's number stands for: 0 is any.
double farthest_of(double greatest_distance);

/// Throws core::Error unless there are as many fields as said.
void require_field_lists(const insitu_sample_args& args);

/// Where a query writes.
class QueryOutputs {
public:
  /// The outputs of a locate.
  QueryOutputs(const insitu_locate_args& args, std::int64_t count);
  void add(const void* data, std::int64_t bytes, std::string name);

  /// Throws INSITU_ERROR_ARGUMENT, naming both, if an output shares memory with another, with the
  /// points, or with an array without gaps between its items of what the query reads of the mesh:
  /// coordinates, cells, ghosts and these fields.
  void refuse_overlaps(const QueryPoints& points, const mesh::Mesh& mesh,
                       std::span<const char* const> fields) const;

private:
  struct Output {
    mesh::ExternalArray::Range range;
    std::string name;
  };
  std::vector<Output> outputs_;
};

} // namespace insitu::api
