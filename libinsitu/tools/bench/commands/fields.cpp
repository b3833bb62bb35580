#include "commands.h"
#include "commands/c_session.h"

namespace insitu::bench {

FieldTimes time_fields(const Options& o, const workload::Mesh& mesh,
                       const std::vector<double>& field, std::span<const math::Vec3d> points) {
  const auto n = std::size_t(o.fields);
  const Session session(o.threads);
  insitu_mesh handle = {};
  check(insitu_session_mesh(session.handle, "bench", &handle));
  const insitu_array xyz =
      insitu_array_of(mesh.points.data(), INSITU_FLOAT64, mesh.vertex_count(), 3);
  check(insitu_mesh_points(handle, 0, &xyz, 1));
  const insitu_cells cells = cells_of(mesh);
  check(insitu_mesh_cells(handle, 0, &cells));
  std::vector<std::vector<double>> fields(n, field), values(n);
  std::vector<std::string> names;
  std::vector<const char*> name_of;
  std::vector<double*> values_of;
  for (std::size_t f = 0; f < n; ++f) {
    for (double& value : fields[f])
      value *= double(f + 1);
    names.push_back("f" + std::to_string(f));
    values[f].resize(points.size());
    values_of.push_back(values[f].data());
    const insitu_array array =
        insitu_array_of(fields[f].data(), INSITU_FLOAT64, mesh.vertex_count(), 1);
    check(insitu_mesh_field(handle, 0, names[f].c_str(), INSITU_VERTEX, &array, 1));
  }
  for (const std::string& name : names)
    name_of.push_back(name.c_str());
  check(insitu_mesh_commit(handle, nullptr));

  const insitu_array at =
      insitu_array_of(&points.data()->x, INSITU_FLOAT64, std::int64_t(points.size()), 3);
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &at;
  args.locate.accuracy = o.accuracy;
  args.fields = name_of.data();
  args.values = values_of.data();
  args.field_count = o.fields;
  check(insitu_mesh_sample(handle, &args)); // touches pages
  FieldTimes out;
  for (int i = 0; i < o.repetitions; ++i) {
    args.field_count = 1;
    out.one.time([&] { check(insitu_mesh_sample(handle, &args)); });
    args.field_count = o.fields;
    out.all.time([&] { check(insitu_mesh_sample(handle, &args)); });
  }
  return out;
}

} // namespace insitu::bench
