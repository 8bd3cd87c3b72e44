// SPDX-License-Identifier: GPL-3.0-or-later
// What is under the pointer, and how far the tool is from it. Units: mm; world frame.
#pragma once

#include <optional>

#include "draw/camera.h"
#include "draw/look.h"

namespace spheretree::view {

/// Index of the shown object that `ray` meets first, on the geometry that `look` draws. The tool hides nothing.
/// Cost: O(triangles or balls of the objects whose box the ray meets), about 5 ns each.
std::optional<std::size_t> pickObject(const Stage& stage, const Look& look, const ShownState& state, const Ray& ray);

/// Smallest gap between a leaf of the graphic tool and a leaf of the object; negative where leaves overlap, as leaves
/// within a skin do. Empty without leaves. Cost: O(leaves of both), 1 ms for 512 times 512.
std::optional<double> gapToObject(const Stage& stage, const ShownState& state, std::size_t object);

}  // namespace spheretree::view
