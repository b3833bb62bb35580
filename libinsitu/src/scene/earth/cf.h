#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "insitu/insitu.h"

#include "output/netcdf/netcdf_layout.h"
#include "scene/parse/description.h"

/// Names and attributes of the CF conventions (1.10) for what tracers and probes write.
namespace insitu::scene {

/// The three coordinates of a mesh's frame, without dimensions: lon, lat, height with their
/// standard names where it is geodetic; x, y, z otherwise, without units where only the solver
/// knows them.
std::array<output::NetcdfVariable, 3> cf_position(const insitu_frame& frame);

/// A variable without values that describes the ellipsoid or the projection, for the attribute
/// grid_mapping; nothing for frames that have no place on Earth, or none that CF can say.
std::optional<output::NetcdfVariable> cf_grid_mapping(const insitu_frame& frame);

/// The time of the solver, in seconds, of no calendar: so it has no "since" and no standard name.
output::NetcdfVariable cf_time();
output::NetcdfVariable cf_cycle();
output::NetcdfVariable cf_cell();
output::NetcdfVariable cf_piece();
output::NetcdfVariable cf_process();
/// insitu_ending as a flag, with all meanings.
output::NetcdfVariable cf_ending();
/// A column of values, NaN where there is none; coordinates: names, for the attribute.
output::NetcdfVariable cf_values(const output::NetcdfLayout& layout, const std::string& column,
                                 const std::string& coordinates,
                                 const std::optional<output::NetcdfVariable>& grid_mapping);
/// Says what a column of geodesics is, in place of its name.
void cf_geodesic(TrackGeodesic column, output::NetcdfVariable& variable);
/// Those of the file; feature: "trajectory", "timeSeries" or "timeSeriesProfile".
std::vector<output::NetcdfAttribute> cf_attributes(const std::string& feature,
                                                   const std::string& title,
                                                   const std::string& positions = "the mesh's");

} // namespace insitu::scene
