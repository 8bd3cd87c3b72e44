// SPDX-License-Identifier: GPL-3.0-or-later
#include "level_search.h"

#include <algorithm>
#include <array>
#include <utility>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

namespace {

// Share by which certification may increase an overhang after a search, at qualities quick, standard and best. What it
// adds to a published method, which covers points, is known only afterwards.
constexpr std::array<double, 3> kSearchAllowance{0.018, 0.013, 0.008};
constexpr int kMaxAttempts = 8;          // builds for a smaller tolerance, if certification makes the overhang exceed it
constexpr double kUndershoot = 0.997;    // further factor on these tolerances; applied once more in each attempt
constexpr std::size_t kSmallTree = 21;   // nodes: 1 + 4 + 16; trees this small are searched exhaustively
constexpr std::size_t kNearlySmall = 2;  // times this number: if the search needs more nodes, no full tree is tried

// Levels are built for the tolerance divided by this factor, since certification increases radii to close the gaps that
// a search leaves.
double certificationAllowance(const BuildSettings& settings) {
  return settings.searches() ? 1 + kSearchAllowance[static_cast<std::size_t>(settings.quality)] : 1;
}

class LevelSearch {
 public:
  LevelSearch(const BuildSettings& settings, double search_tolerance, const BuildCertified& build)
      : settings_(settings), search_tolerance_(search_tolerance), build_(build) {}

  CertifiedLevels run() {
    double aim = search_tolerance_ / certificationAllowance(settings_);
    best_ = forTolerance(aim);
    // If the levels kept the tolerance only before certification, reduces the target by the overshoot.
    double undershoot = 1;
    for (int attempt = 0; attempt < kMaxAttempts && best_.uncertified_overhang <= settings_.tolerance_mm && !isKept(best_); ++attempt) {
      undershoot *= kUndershoot;
      aim *= undershoot * settings_.tolerance_mm / best_.overhang_bound;
      best_ = forTolerance(aim);
    }
    const bool tries_full = settings_.tolerance_mm > 0 && settings_.searches();  // a published method makes the tree that it makes
    if (!tries_full || best_.count() > kNearlySmall * kSmallTree) return std::move(best_);
    // Certification may also add less than the allowance, and in a small tree one additional leaf is a large share.
    if (aim < search_tolerance_ && isKept(best_) && best_.count() <= kSmallTree) offer(forTolerance(search_tolerance_));
    tryFull(2);
    if (settings_.levels > 2) tryFull(3);
    if (isKept(best_)) offer(full(1, kMinBranching));
    return std::move(best_);
  }

 private:
  bool isKept(const CertifiedLevels& levels) const { return levels.overhang_bound <= settings_.tolerance_mm; }
  void offer(CertifiedLevels other) {
    if (isKept(other) && (!isKept(best_) || other.count() < best_.count())) best_ = std::move(other);
  }

  // Builds every small full tree of `depth` levels, the largest branching first, until one does not keep the tolerance.
  void tryFull(int depth) {
    for (int branching = settings_.branching; branching >= kMinBranching; --branching) {
      std::size_t nodes = 1;
      for (int level = 1, width = 1; level < depth; ++level) nodes += static_cast<std::size_t>(width *= branching);
      if (nodes > kSmallTree || (isKept(best_) && nodes >= best_.count())) continue;
      CertifiedLevels tree = full(depth, branching);
      if (!isKept(tree)) return;
      offer(std::move(tree));
    }
  }

  CertifiedLevels full(int depth, int branching) const {
    BuildSettings settings = settings_;
    settings.levels = std::max(depth, kMinLevels);
    settings.branching = branching;
    settings.tolerance_mm = 0;
    return build_(settings, static_cast<std::size_t>(depth));
  }
  CertifiedLevels forTolerance(double tolerance) const {
    BuildSettings settings = settings_;
    settings.tolerance_mm = tolerance;
    return build_(settings, kMaxLevels);
  }

  const BuildSettings& settings_;
  double search_tolerance_;
  const BuildCertified& build_;
  CertifiedLevels best_;  // best levels found so far
};

}  // namespace

CertifiedLevels searchLevels(const BuildSettings& settings, double search_tolerance_mm, const BuildCertified& build) {
  return LevelSearch(settings, search_tolerance_mm, build).run();
}

}  // namespace spheretree::builder
