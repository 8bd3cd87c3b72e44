// SPDX-License-Identifier: GPL-3.0-or-later
// Charts and the page of a comparison, from its figures and the folder with its trees.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/comparison/comparison_figures.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// Writes comparison.svg (geometric means), and MESH.svg for each mesh, into `folder`, and the same as .pdf, which the
/// program rsvg-convert makes of them. Returns why there is no PDF, or nothing. @throws
/// formats::FileError, builder::Cancelled
std::string writeComparisonCharts(const pipeline::Comparison& comparison, const std::filesystem::path& folder, builder::Progress& progress);

/// The page. Trees come from `folder`, meshes from their original paths; what cannot be read is left out and named. To
/// stay below `max_bytes`, meshes get fewer triangles; if that does not suffice, only trees on a Pareto front are shown
/// in 3D, and the page says so.
std::string comparisonPage(const pipeline::Comparison& comparison, const std::filesystem::path& folder, std::size_t max_bytes,
                           builder::Progress& progress);

}  // namespace spheretree::tool
