// SPDX-License-Identifier: GPL-3.0-or-later
// Charts and the page of a comparison, from its JSON (comparison.h) and the folder that holds its trees.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "page/page.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// For each builder and quality with a tree for every mesh: geometric means over the meshes, lengths in per cent of the diagonal.
Json geometricMeans(const Json& comparison);

/// comparison.svg (geometric means) and MESH.svg for each mesh, into `folder`.
void writeComparisonCharts(const Json& comparison, const std::filesystem::path& folder);

/// The page. Trees come from `folder`, meshes from where they were; what of either cannot be read is left out and named. Its size stays
/// below `most_bytes`: meshes get fewer triangles, then only trees on a Pareto front are shown in 3D, and the page says so.
std::string comparisonPage(const Json& comparison, const std::filesystem::path& folder, std::size_t most_bytes,
                           builder::Progress& progress);

}  // namespace spheretree::tool
