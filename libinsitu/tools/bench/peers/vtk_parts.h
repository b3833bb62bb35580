#pragma once

#include <string>
#include <vector>

#include "peers/peers.h"
#include "workload/mesh.h"

/// What needs VTK; vtk_absent.cpp stands in where it is not there.
namespace insitu::bench {

/// Throws UsageError if the file cannot be read or holds other cells than the five linear shapes.
workload::Mesh read_vtu(const std::string& file);

/// VTK's locators and probe filter; none without VTK.
Peers make_vtk_peers(const workload::Mesh& mesh, const std::vector<double>& field);

} // namespace insitu::bench
