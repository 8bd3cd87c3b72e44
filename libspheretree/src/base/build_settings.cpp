// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/build_settings.h"

#include <cmath>
#include <string>

#include "spheretree/core/search_tree.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

std::string_view name(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::Cover:
      return "cover";
    case BuilderKind::Combined:
      return "combined";
    case BuilderKind::Merge:
      return "merge";
    case BuilderKind::Burst:
      return "burst";
    case BuilderKind::Expand:
      return "expand";
    case BuilderKind::Spawn:
      return "spawn";
    case BuilderKind::Grid:
      return "grid";
    case BuilderKind::Hubbard:
      return "hubbard";
    case BuilderKind::Octree:
      return "octree";
  }
  return "";
}

std::string_view name(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return "quick";
    case Quality::Standard:
      return "standard";
    case Quality::Best:
      return "best";
  }
  return "";
}

std::string_view name(MedialAxis axis) { return axis == MedialAxis::Static ? "static" : "adaptive"; }

void validate(const BuildSettings& settings) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument("build: " + what);
  };
  const BuildSettings& s = settings;
  require(s.levels >= kMinLevels && s.levels <= kMaxLevels, "levels is " + std::to_string(s.levels) + "; it must be 2 to 6");
  require(s.branching >= kMinBranching && s.branching <= kMaxBranching,
          "branching is " + std::to_string(s.branching) + "; it must be 2 to 8");
  require(std::isfinite(s.tolerance_mm) && s.tolerance_mm >= 0, "tolerance must be finite and not negative");
  require(std::isfinite(s.skin_tolerance_mm) && s.skin_tolerance_mm >= 0, "the skin's tolerance must be finite and not negative");
  require(s.crease_angle_deg >= 1 && s.crease_angle_deg <= 180, "the crease angle must be 1 to 180 degrees");
  require(std::isfinite(s.hull_tolerance_mm) && s.hull_tolerance_mm >= 0, "the hulls' tolerance must be finite and not negative");
  require(s.max_hulls >= 1 && s.max_hulls <= 4096, "max_hulls is " + std::to_string(s.max_hulls) + "; it must be 1 to 4096");
  require(s.threads >= 0, "threads must not be negative");
  require(s.max_leaves >= 0 && s.max_leaves <= static_cast<int>(kMaxSearchItems),
          "max_leaves is " + std::to_string(s.max_leaves) + "; it must be 0 to 32768");
  require(!s.search || s.builder != BuilderKind::Cover, "the builder cover is a search; `search` is for published builders");
  require(s.max_leaves == 0 || s.searches(), "a published method makes as many leaves as it makes; with `search`, max_leaves limits them");
  require(s.soft_share >= 0 && s.soft_share <= 0.5, "the share of the radius of soft leaves must be 0 to 0.5");
  require(s.soft_share == 0 || s.builder == BuilderKind::Cover, "only the builder cover takes a share of the radius");
  for (const double t : s.tolerance_of_triangle_mm)
    require(std::isfinite(t) && s.tolerance_mm > 0 && t >= s.tolerance_mm,
            "the tolerance of a triangle must be finite and not below the tolerance");
  require(s.tolerance_of_triangle_mm.empty() || s.searches(), "only builders that search take tolerances of triangles");
}

}  // namespace spheretree::builder
