// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/certify_levels.h"

#include <algorithm>
#include <utility>

#include "certify/certify_cover.h"
#include "certify/overhang_bound.h"
#include "certify/redundant_spheres.h"

namespace spheretree::builder {

namespace {

constexpr double kResolution = 2e-3;     // of certification, as a share of the stand-off
constexpr double kMinResolution = 1e-7;  // ... and of the diagonal

class Certifier {
 public:
  Certifier(const CertificationTarget& target, const LevelBalls& levels, Progress& progress)
      : target_(target), levels_(levels), progress_(progress) {}

  CertifiedLevels run() {
    out_.parents = levels_.parents;
    out_.spheres.resize(levels_.balls.size());
    for (std::size_t level = 0; level < levels_.balls.size(); ++level) {
      progress_.advance(static_cast<double>(level) / static_cast<double>(levels_.balls.size()));
      certifyLevel(level);
    }
    return std::move(out_);
  }

 private:
  struct Ended {  // a ball that is a leaf: one sphere for the covers of all deeper levels
    std::size_t level, index;
  };

  void certifyLevel(std::size_t level) {
    const std::vector<Ball>& own = levels_.balls[level];
    std::vector<Ball> set = own;
    for (const Ended& e : ended_) set.push_back({levels_.balls[e.level][e.index].centre, out_.spheres[e.level][e.index].radius});
    double stand_off = 0;
    for (const Ball& b : set) stand_off = std::max(stand_off, b.radius + target_.field.signedDistance(b.centre));
    const double resolution = std::max(kResolution * stand_off, kMinResolution * target_.field.diagonal());
    CertifiedCover certified = certifyCover(target_.mesh, set, target_.origin, resolution, progress_);
    out_.pieces += certified.pieces;
    out_.largest_growth.push_back(certified.largest_growth);
    const bool is_deepest = level + 1 == levels_.balls.size();
    if (is_deepest) {
      out_.uncertified_overhang = stand_off;
      dropRedundant(certified.spheres, own.size());
      out_.overhang_bound = 0;
      for (const Sphere& s : certified.spheres)
        out_.overhang_bound = std::max(out_.overhang_bound, overhangBound(target_.field, target_.origin, s));
    }
    const std::size_t kept = certified.spheres.size() - ended_.size();
    out_.spheres[level].assign(certified.spheres.begin(), certified.spheres.begin() + static_cast<std::ptrdiff_t>(kept));
    for (std::size_t i = 0; i < ended_.size(); ++i) out_.spheres[ended_[i].level][ended_[i].index] = certified.spheres[kept + i];
    if (!is_deepest) findEnded(level);
  }

  // Finds the spheres of a level without children on the next level.
  void findEnded(std::size_t level) {
    if (levels_.parents.empty()) return;
    std::vector<char> has_child(levels_.balls[level].size(), 0);
    for (const std::uint32_t parent : levels_.parents[level + 1]) has_child.at(parent) = 1;
    for (std::size_t i = 0; i < has_child.size(); ++i)
      if (!has_child[i]) ended_.push_back({level, i});
  }

  // Removes redundant leaves. `set`: first the `own` spheres of the deepest level, then the leaves of earlier levels.
  void dropRedundant(std::vector<Sphere>& set, std::size_t own) {
    if (out_.spheres.size() < 2) return;
    const std::size_t above = out_.spheres[out_.spheres.size() - 2].size();
    std::vector<std::uint32_t> group(set.size(), static_cast<std::uint32_t>(above));  // leaves of earlier levels have no parent here
    if (!out_.parents.empty()) std::copy(out_.parents.back().begin(), out_.parents.back().end(), group.begin());
    std::vector<char> fixed(own, 0);
    fixed.resize(set.size(), 1);
    const std::size_t max_dropped = out_.parents.empty() ? own - std::min(own, above) : own;
    const std::vector<char> redundant =
        findRedundantSpheres(target_.mesh, set, target_.origin, group, fixed, max_dropped, target_.seed, progress_);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (redundant[i]) continue;
      set[kept] = set[i];
      if (!out_.parents.empty() && i < own) out_.parents.back()[kept] = out_.parents.back()[i];
      ++kept;
    }
    if (!out_.parents.empty()) out_.parents.back().resize(kept - (set.size() - own));
    set.resize(kept);
  }

  const CertificationTarget& target_;
  const LevelBalls& levels_;
  Progress& progress_;
  CertifiedLevels out_;
  std::vector<Ended> ended_;
};

}  // namespace

std::size_t CertifiedLevels::count() const {
  std::size_t all = 0;
  for (const std::vector<Sphere>& level : spheres) all += level.size();
  return all;
}

CertifiedLevels certifyLevels(const CertificationTarget& target, const LevelBalls& levels, Progress& progress) {
  return Certifier(target, levels, progress).run();
}

}  // namespace spheretree::builder
