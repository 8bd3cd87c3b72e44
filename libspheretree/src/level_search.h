// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the shape of a tree: certified levels as the settings prescribe or, with a tolerance, with the smallest
// number of nodes that was found.
#pragma once

#include <functional>

#include "certify/certify_levels.h"
#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {

/// Builds and certifies the levels for some settings; levels beyond `max_levels` are left out. The tolerance of the
/// settings is the one for the search, before certification [mm]; 0: full levels.
using BuildCertified = std::function<CertifiedLevels(const BuildSettings&, std::size_t max_levels)>;

/// The levels for `settings`. With a tolerance: the levels with the smallest number of nodes found whose proven
/// overhang keeps it; if none keeps it, the best levels that were found. `search_tolerance_mm`: largest overhang of the
/// balls before certification; it differs from the tolerance because the search works on a surface that may differ from
/// the mesh (simplified_input.h).
/// Trees of at most 21 nodes are searched exhaustively: each full tree with one or two levels below the root is built
/// with the smallest overhang that the builder finds. For such small trees the result is the best of them by
/// construction; nothing follows for larger trees.
CertifiedLevels searchLevels(const BuildSettings& settings, double search_tolerance_mm, const BuildCertified& build);

}  // namespace spheretree::builder
