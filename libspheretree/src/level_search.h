// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the shape of a tree: certified levels as the settings ask for them or, with a tolerance, with the fewest
// nodes found.
#pragma once

#include <functional>

#include "certify/certify_levels.h"
#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {

/// Builds and certifies the levels for some settings; `max_levels`: deeper ones are left out. The tolerance of the
/// settings is that of the search and counts before certification [mm]; 0: full levels.
using BuildCertified = std::function<CertifiedLevels(const BuildSettings&, std::size_t max_levels)>;

/// The levels for `settings`. With a tolerance, those with the fewest nodes found whose proven overhang keeps it; if
/// none keeps it, the best that was found. `search_tolerance_mm`: the most that balls may reach out before
/// certification, as the search works on a surface that may differ from the mesh (simplified_input.h).
/// Trees of at most 21 nodes are searched exhaustively: each full tree of one and of two levels below the root is built
/// as tight as it comes. This is a search of small trees, by construction as good as the best of them; it proves
/// nothing about larger ones.
CertifiedLevels searchLevels(const BuildSettings& settings, double search_tolerance_mm, const BuildCertified& build);

}  // namespace spheretree::builder
