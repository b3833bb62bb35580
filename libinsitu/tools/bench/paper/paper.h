#pragma once

#include "options.h"
#include "paper/table.h"

/// The tables and figures of the papers that libinsitu is built on, on meshes of ours. Figures of
/// the papers are quoted with them; sizes, machines and data differ, so ratios compare, not times.
namespace insitu::bench::paper {

/// Morrical et al. 2020, tables 1 to 5 and section 9.4: locator methods.
Tables morrical(const Options& options);
/// Rathke et al. 2015, tables 1 to 4: isosurfaces and volumes on processors.
Tables rathke(const Options& options);
/// Zellmann et al. 2023, tables 1 to 4 and figures 6 to 8: the dual mesh of adaptive meshes.
Tables zellmann(const Options& options);

} // namespace insitu::bench::paper
