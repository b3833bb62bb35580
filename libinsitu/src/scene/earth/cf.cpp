#include "scene/earth/cf.h"

#include <limits>

#include "advect/particles.h"

namespace insitu::scene {

namespace {

using output::NetcdfAttribute;
using output::NetcdfType;
using output::NetcdfVariable;

using Attributes = std::vector<NetcdfAttribute>;

NetcdfVariable variable(const char* name, NetcdfType type, Attributes attributes) {
  NetcdfVariable v;
  v.name = name;
  v.type = type;
  v.attributes = std::move(attributes);
  return v;
}

NetcdfAttribute text(const char* name, const std::string& value) {
  return {name, value};
}

NetcdfAttribute no_number() {
  return {"_FillValue", std::numeric_limits<double>::quiet_NaN()};
}

/// WGS84: defining parameters (NIMA TR8350.2).
Attributes ellipsoid(const char* mapping) {
  return {text("grid_mapping_name", mapping),
          {"semi_major_axis", 6378137.0},
          {"inverse_flattening", 298.257223563}};
}

} // namespace

std::array<NetcdfVariable, 3> cf_position(const insitu_frame& frame) {
  const auto axes = [&](Attributes x, Attributes y, Attributes z) {
    // Z is vertical there (CF 4.3), X and Y are level (4.4): geocentric coordinates are neither.
    if (frame.kind != INSITU_FRAME_GEOCENTRIC) {
      x.push_back(text("axis", "X"));
      y.push_back(text("axis", "Y"));
      z.push_back(text("axis", "Z"));
    }
    return std::array{variable("x", NetcdfType::float64, std::move(x)),
                      variable("y", NetcdfType::float64, std::move(y)),
                      variable("z", NetcdfType::float64, std::move(z))};
  };
  const bool down = frame.vertical == INSITU_DOWN;
  const Attributes height{
      text("standard_name", down ? "depth" : "height_above_reference_ellipsoid"),
      text("units", frame.length == INSITU_KILOMETRES ? "km" : "m"),
      text("positive", down ? "down" : "up")};
  switch (frame.kind) {
  case INSITU_FRAME_CARTESIAN:
    break;
  case INSITU_FRAME_GEOCENTRIC:
    return axes(
        {text("long_name", "from the Earth's centre towards longitude 0 on the equator"),
         text("units", "m")},
        {text("long_name", "from the Earth's centre towards 90 degrees east on the equator"),
         text("units", "m")},
        {text("long_name", "from the Earth's centre towards the north pole"), text("units", "m")});
  case INSITU_FRAME_ENU:
    return axes(
        {text("long_name", "east of the origin"), text("units", "m")},
        {text("long_name", "north of the origin"), text("units", "m")},
        {text("long_name", "above the origin"), text("units", "m"), text("positive", "up")});
  case INSITU_FRAME_UTM:
    return axes({text("standard_name", "projection_x_coordinate"), text("units", "m")},
                {text("standard_name", "projection_y_coordinate"), text("units", "m")}, height);
  case INSITU_FRAME_GEODETIC: {
    const bool radians = frame.angle == INSITU_RADIANS;
    auto out = axes(
        {text("standard_name", "longitude"), text("units", radians ? "radian" : "degrees_east")},
        {text("standard_name", "latitude"), text("units", radians ? "radian" : "degrees_north")},
        height);
    out[0].name = "lon";
    out[1].name = "lat";
    out[2].name = down ? "depth" : "height";
    return out;
  }
  }
  const Attributes own{text("long_name", "coordinate in the solver's own units")};
  return axes(own, own, own);
}

std::optional<NetcdfVariable> cf_grid_mapping(const insitu_frame& frame) {
  Attributes attributes;
  if (frame.kind == INSITU_FRAME_GEODETIC) {
    attributes = ellipsoid("latitude_longitude");
  } else if (frame.kind == INSITU_FRAME_UTM) {
    attributes = ellipsoid("transverse_mercator");
    attributes.push_back({"longitude_of_central_meridian", 6.0 * frame.utm_zone - 183.0});
    attributes.push_back({"latitude_of_projection_origin", 0.0});
    attributes.push_back({"scale_factor_at_central_meridian", 0.9996});
    attributes.push_back({"false_easting", 500000.0});
    attributes.push_back({"false_northing", frame.utm_north ? 0.0 : 1e7});
  } else {
    return std::nullopt;
  }
  NetcdfVariable v = variable("crs", NetcdfType::int32, std::move(attributes));
  v.per_record = false;
  v.integers = {0};
  return v;
}

NetcdfVariable cf_time() {
  return variable("time", NetcdfType::float64,
                  {text("long_name", "time of the solver"), text("units", "s"), text("axis", "T")});
}

NetcdfVariable cf_cycle() {
  return variable("cycle", NetcdfType::int64, {text("long_name", "cycle of the solver")});
}

NetcdfVariable cf_cell() {
  return variable(
      "cell", NetcdfType::int64,
      {text("long_name", "cell, as the solver counts them"), {"_FillValue", std::int64_t(-1)}});
}

NetcdfVariable cf_piece() {
  return variable("piece", NetcdfType::int32,
                  {text("long_name", "piece of the mesh"), {"_FillValue", std::int32_t(-1)}});
}

NetcdfVariable cf_process() {
  return variable(
      "process", NetcdfType::int32,
      {text("long_name", "process that has the cell"), {"_FillValue", std::int32_t(-1)}});
}

NetcdfVariable cf_ending() {
  std::vector<std::int8_t> values;
  std::string meanings;
  for (int e = 0; e < INSITU_END_COUNT; ++e) {
    values.push_back(std::int8_t(e));
    meanings += (e > 0 ? " " : "") + std::string(advect::ending_name(insitu_ending(e)));
  }
  return variable("ending", NetcdfType::int8,
                  {text("long_name", "what became of the particle"),
                   {"flag_values", values},
                   text("flag_meanings", meanings)});
}

NetcdfVariable cf_values(const output::NetcdfLayout& layout, const std::string& column,
                         const std::string& coordinates,
                         const std::optional<NetcdfVariable>& grid_mapping) {
  NetcdfVariable v = variable("", NetcdfType::float64, {text("long_name", column), no_number()});
  v.name = layout.free_name(column);
  if (!coordinates.empty())
    v.attributes.push_back(text("coordinates", coordinates));
  if (grid_mapping)
    v.attributes.push_back(text("grid_mapping", grid_mapping->name));
  return v;
}

void cf_geodesic(TrackGeodesic column, NetcdfVariable& variable) {
  const char* what = "direction from the point of release, clockwise from north";
  const char* units = "degree";
  if (column != TrackGeodesic::release_bearing) {
    what = column == TrackGeodesic::path_length ? "distance along the track since the release"
                                                : "distance from the point of release";
    units = "m";
  }
  for (NetcdfAttribute& attribute : variable.attributes)
    if (attribute.name == "long_name")
      attribute.value = std::string(what);
  variable.attributes.push_back(text("units", units));
}

std::vector<NetcdfAttribute> cf_attributes(const std::string& feature, const std::string& title,
                                           const std::string& positions) {
  return {text("Conventions", "CF-1.10"), text("featureType", feature), text("title", title),
          text("source", "libinsitu"),
          text("comment", "time is that of the solver in seconds and has no calendar; positions "
                          "are in " +
                              positions + " frame")};
}

} // namespace insitu::scene
