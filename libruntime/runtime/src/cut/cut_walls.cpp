// SPDX-License-Identifier: Apache-2.0
#include "cut/cut_walls.h"

#include <algorithm>
#include <limits>

#include "cut/lattice_wall.h"
#include "rows/row_set.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kRoundingSlack = 1e-5;     // of distances in floats [mm]
constexpr std::size_t kMaxWalls = 1 << 16;  // slots of a pair
constexpr std::uint32_t kDropWork = 10;     // of a row whose touched point is near what was removed [StepLimits::max_work]
constexpr double kNoRow = 1e6;              // a larger gap is that of a row that holds always [mm]

}  // namespace

const CutWork* workOf(const std::vector<CutWork>& works, std::size_t object) {
  const auto found = std::ranges::find(works, object, &CutWork::object);
  return found == works.end() ? nullptr : &*found;
}

CutWalls::CutWalls(StepMemory& memory, std::vector<CutWork>& works, CutStorage& storage)
    : memory_(memory), scene_(memory.scene), works_(works), storage_(storage), walls_(kMaxWalls) {
  near_parts_.reserve(scene_.wall_slots.size());
  pairs_.reserve(scene_.step_limits.max_pairs + 16);
  runs_.reserve(2 * scene_.objects.size());
}

// Copies the pairs of a run, with the burr's balls for the leaves that cover them; without those while it turns.
void CutWalls::addPairs(const PairSet& set, const PairRun& run, bool spins) {
  const std::size_t begin = pairs_.size();
  const bool is_cut = workOf(works_, run.object) != nullptr;
  for (std::uint32_t pair : set.pairs.subspan(run.begin, run.count)) {
    if (is_cut)
      if (const std::uint32_t ball = scene_.burr_of[pair >> 16]; ball != kNoItem) {
        if (spins) continue;
        pair = (scene_.burr_slot + ball) << 16 | (pair & 0xffff);
      }
    pairs_.push_back(pair);
  }
  const auto first = pairs_.begin() + static_cast<std::ptrdiff_t>(begin);
  if (is_cut && !spins) {  // several leaves of the burr may have met one triangle
    std::sort(first, pairs_.end());
    pairs_.erase(std::unique(first, pairs_.end()), pairs_.end());
  }
  if (pairs_.size() > begin)
    runs_.push_back({run.object, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(pairs_.size() - begin)});
}

// The parts of the tool, at `pose`, that come within `margin` of the box around what was cut.
void CutWalls::findNearParts(const CutWork& work, const Configuration& pose, double margin, bool spins) {
  const Eigen::Matrix3d turn = memory_.objects[work.object].rotation.transpose() * pose.orientation.toRotationMatrix();
  const Vector3d offset = work.localOf(pose.position, memory_), root = offset + turn * scene_.tool_root;
  near_parts_.clear();
  if (work.lattice.distanceFromCut(root) > scene_.tool_root_radius + margin) return;
  for (const std::uint32_t slot : scene_.wall_slots) {
    if (spins && slot >= scene_.burr_slot) break;  // they come last
    const Sphere& ball = scene_.tool.spheres[slot];
    const NearPart part{slot, offset + turn * centreOf(ball), static_cast<double>(ball.radius) + margin};
    if (work.lattice.distanceFromCut(part.at) <= part.reach) near_parts_.push_back(part);
  }
}

// Adds the pairs of the near parts and the walls of an object. Returns false if there is no space for them.
bool CutWalls::addWallsOf(CutWork& work, std::uint32_t& tests) {
  tests += static_cast<std::uint32_t>(scene_.wall_slots.size());
  if (near_parts_.empty()) return true;
  const LatticeWall wall(work.lattice);
  const double largest = wall.largestBall(), side = 7 * work.lattice.spacing();
  const std::size_t begin = pairs_.size(), capacity = scene_.step_limits.max_pairs;
  for (CutBlock& block : storage_.blocks()) {
    if (!work.lattice.hasWall(block)) continue;
    const Vector3d corner = work.lattice.cornerOf(block.place), opposite = corner.array() + side;
    std::span<const Sphere> rim;
    bool is_first = true, fits = true;
    for (const NearPart& part : near_parts_) {
      ++tests;
      const double reach = part.reach + largest;
      if ((part.at - part.at.cwiseMax(corner).cwiseMin(opposite)).squaredNorm() > reach * reach) continue;
      if (is_first) {
        wall_of_.fill(kNoItem);
        rim = wall.rimOf(block);
        tests += kBlockPoints / 8;
      }
      is_first = false;
      tests += static_cast<std::uint32_t>(kBlockPoints / 8 + rim.size());
      const auto add = [&](std::size_t number, const Sphere& ball) {
        const double sum = part.reach + static_cast<double>(ball.radius);
        if (!fits || (part.at - centreOf(ball)).squaredNorm() > sum * sum) return;
        std::uint32_t& slot = wall_of_[number];
        fits = pairs_.size() < capacity && (slot != kNoItem || wall_count_ < walls_.size());
        if (!fits) return;
        if (slot == kNoItem) {
          slot = static_cast<std::uint32_t>(wall_count_);
          walls_[wall_count_++] = ball;
        }
        pairs_.push_back(part.slot << 16 | slot);
      };
      wall.visit(block, part.at, part.reach, [&](std::size_t point) { add(point, wall.ball(block, point)); });
      for (std::size_t k = 0; k < rim.size(); ++k) add(kBlockPoints + k, rim[k]);
      if (!fits) return false;
    }
  }
  if (pairs_.size() > begin)
    runs_.push_back({work.object, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(pairs_.size() - begin), true});
  return true;
}

void CutWalls::add(const Configuration& pose, double margin, bool spins, PairSet& set) {
  if (set.coarse) return;
  pairs_.clear(), runs_.clear(), wall_count_ = 0;
  bool fits = true;
  std::uint32_t tests = 0;
  const PairRun* run = set.runs.data();
  const PairRun* const end = run + set.runs.size();
  for (CutWork& work : works_) {  // by object, as the runs are
    for (; run != end && run->object <= work.object; ++run) addPairs(set, *run, spins);
    if (!fits || !memory_.feelsSkin(work.object) || !memory_.isActive(work.object)) continue;
    findNearParts(work, pose, margin + kRoundingSlack, spins);
    fits = addWallsOf(work, tests);
  }
  for (; run != end; ++run) addPairs(set, *run, spins);
  set.work += (tests + 7) / 8;
  set.coarse = !fits || pairs_.size() > scene_.step_limits.max_pairs;
  if (set.coarse) return;
  std::copy(pairs_.begin(), pairs_.end(), memory_.pairs.begin());
  memory_.runs.assign(runs_.begin(), runs_.end());
  set.pairs = {memory_.pairs.data(), pairs_.size()};
  set.runs = memory_.runs;
}

std::uint32_t CutWalls::dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const {
  bool is_changed = false;
  std::uint32_t work_done = 0;
  for (const PairRun& run : set.runs) {
    const CutWork* const work = run.of_wall ? nullptr : workOf(works_, run.object);
    if (!work || !work->lattice.isCut()) continue;
    work_done += run.count;
    const Eigen::Matrix3d back = memory_.objects[run.object].rotation.transpose(), turn = back * pose.orientation.toRotationMatrix();
    const Vector3d origin = work->localOf(pose.position, memory_);
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
      const std::uint32_t row = first + i;
      const auto weight = static_cast<double>(rows.weight[row]);
      const double gap = -static_cast<double>(rows.b[row]) / weight;
      if (gap > kNoRow) continue;
      const Sphere& ball = scene_.tool.spheres[set.pairs[i] >> 16];
      Vector3d normal;
      for (std::size_t k = 0; k < 3; ++k) normal[static_cast<Eigen::Index>(k)] = static_cast<double>(rows.rows.a[k][row]) / weight;
      const Vector3d touched = origin + turn * centreOf(ball) - (static_cast<double>(ball.radius) + gap) * (back * normal);
      if (!work->lattice.isNearCut(touched)) continue;
      work_done += kDropWork;
      if (!work->lattice.isRemoved(touched)) continue;
      for (std::size_t k = 0; k < 6; ++k) memory_.rowArray(k)[row] = 0;
      rows.b[row] = std::min(rows.b[row], 0.0f);  // keeps its gap, since the tool may come to where the surface is left
      is_changed = true;
    }
  }
  if (!is_changed) return work_done;
  float smallest = std::numeric_limits<float>::infinity();
  for (std::uint32_t row = first; row < first + set.pairs.size(); ++row) {
    float size = 0;
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, std::abs(rows.rows.a[k][row]));
    if (size > 0) smallest = std::min(smallest, -rows.b[row] / rows.weight[row]);
  }
  (first == 0 ? rows.smallest_gap : rows.smallest_felt_gap) = smallest;
  return work_done;
}

}  // namespace spheretree::runtime
