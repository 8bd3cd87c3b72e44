// SPDX-License-Identifier: Apache-2.0
#include "cut/cutter.h"

#include <algorithm>
#include <cmath>

#include "cut/compile_surface.h"
#include "piece/force_rate_limit.h"
#include "rows/row_set.h"
#include "scene/cut_model.h"
#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

// The lattice, in shares of the radius of the smallest ball of the burr, and what follows from its spacing: the reach
// of its fields is the largest motion of a burr in a step, twice the largest depth of its cut in a step.
constexpr double kSpacingShare = 1.0 / 8, kFinest = 0.03, kCoarsest = 0.1;  // [mm]
constexpr double kReachSpacings = 4;
constexpr double kBiteSpacings = 2;
constexpr double kAhead = 1;                // blocks are made this far ahead of need [mm]
constexpr int kAheadBlocks = 2;             // as many a step
constexpr std::size_t kMaxBlocks = 8192;    // of all objects: 49 MB
constexpr int kFacets = 192;                // of a burr ball: each turns by 8 degrees
constexpr double kEdge = 0.25;              // the rim of what was removed is this wide, in spacings
constexpr double kRoundingSlack = 1e-5;     // of distances in floats [mm]
constexpr std::size_t kMaxWalls = 1 << 16;  // slots of a pair
constexpr std::uint32_t kDropWork = 10;     // of a row whose touched point is near what was removed [StepLimits::max_work]
constexpr double kNoRow = 1e6;              // a larger gap is that of a row that holds always [mm]
constexpr int kMaxTraces = 12;              // of the way to the material

// Points evenly on the unit sphere: the spiral of equal areas whose turns are apart by the golden angle.
std::vector<Vector3d> spiral(int count) {
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, around = M_PI * (3 - std::sqrt(5.0)) * i, r = std::sqrt(1 - z * z);
    out.push_back({r * std::cos(around), r * std::sin(around), z});
  }
  return out;
}

Vector3d placeOf(const Configuration& pose, const Sphere& ball) { return pose.position + pose.orientation * centreOf(ball); }

// The way of a facet at `from` along its normal to the material, at most the lattice's reach; and the share of the
// facet that meets it.
double gapAlong(const CutLattice& lattice, const Vector3d& from, const Vector3d& direction, float& share) {
  const auto inverse_h = static_cast<float>(1 / lattice.spacing());
  Material here = lattice.at(from);
  share = std::clamp(0.5f + here.depth * inverse_h, 0.0f, 1.0f) *
          std::clamp(1 + here.clearance * inverse_h / static_cast<float>(kEdge), 0.0f, 1.0f);
  if (share > 0) return -static_cast<double>(std::min(here.clearance, 0.0f));
  double way = 0;
  for (int trace = 0; trace < kMaxTraces; ++trace) {
    const double further = -static_cast<double>(std::min(here.depth, here.clearance));
    if (further <= 0) {
      share = 1;
      return way;
    }
    way += std::max(further, 0.1 * lattice.spacing());
    if (way > lattice.reach()) break;
    here = lattice.at(from + way * direction);
  }
  return lattice.reach();
}

}  // namespace

Cutter::Cutter(StepMemory& memory) : memory_(memory), scene_(memory.scene), storage_(kMaxBlocks), directions_(spiral(kFacets)) {
  for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
    if (scene_.shapeOf(i).cut) {
      works_.push_back(makeWork(i));
      rubs_ = rubs_ || works_.back().model.material.tangential > 0;
    }
  const std::size_t facets = works_.size() * scene_.burr.size() * kFacets;
  facets_.reserve(facets);
  facet_of_.reserve(facets);
  ahead_.reserve(kAheadBlocks);
  near_parts_.reserve(scene_.wall_slots.size());
  walls_.resize(kMaxWalls);
  pairs_.reserve(scene_.step_limits.max_pairs + 16);
  runs_.reserve(2 * scene_.objects.size());
}

Cutter::Work Cutter::makeWork(std::uint32_t object) {
  const CompiledShape& shape = scene_.shapeOf(object);
  float smallest = scene_.burr[0].radius;
  for (const Sphere& ball : scene_.burr) smallest = std::min(smallest, ball.radius);
  const double spacing = std::clamp(kSpacingShare * static_cast<double>(smallest), kFinest, kCoarsest);
  Work work{object,
            shape,
            *shape.cut,
            CutLayers(shape.skin),
            CutLattice(spacing, kReachSpacings * spacing, object, storage_,
                       memory_.kernel == &scalarKernel() ? scalarCutKernel() : avx2CutKernel()),
            {},
            CutState::kNone,
            {}};
  for (const CutLayer& layer : shape.cut->material.inner) work.layers.add(compileSurface(*layer.surface, -shape.centre));
  work.removed = std::vector<double>(work.layers.count());
  work.burr = std::vector<Near>(scene_.burr.size());
  return work;
}

Cutter::Work* Cutter::workOf(std::size_t object) {
  for (Work& work : works_)
    if (work.object == object) return &work;
  return nullptr;
}

const Cutter::Work* Cutter::workOf(std::size_t object) const { return const_cast<Cutter*>(this)->workOf(object); }

void Cutter::mend() {
  last_ = {};
  storage_.clear();
  for (Work& work : works_) {
    work.lattice.mend();
    std::fill(work.removed.begin(), work.removed.end(), 0.0);
    std::fill(work.burr.begin(), work.burr.end(), Near{});
    work.layer = CutState::kNone;
  }
}

CutState Cutter::stateOf(std::size_t object) const {
  CutState state;
  if (const Work* work = workOf(object)) {
    std::copy(work->removed.begin(), work->removed.end(), state.removed.begin());
    state.layer = work->layer;
  }
  return state;
}

Vector3d Cutter::localOf(const Work& work, const Vector3d& world) const {
  const CompiledObject& object = memory_.objects[work.object];
  return object.rotation.transpose() * (world - object.anchor);
}

bool Cutter::isRemoved(std::size_t object, const Vector3d& point) const {
  const Work* const work = workOf(object);
  return work && work->lattice.isRemoved(point);
}

// Makes the blocks within `needed` of the ball, and some of those within `ahead` of that. No surface is within `free`
// of it. Returns whether all that are needed are there.
bool Cutter::makeBlocks(Work& work, Near& near, double needed, double ahead, double free, std::uint32_t max_work, StepResult& result) {
  const double since = (near.at - near.known_about).norm();
  if (since + needed <= near.known_within && since < 0.5 * ahead) return true;
  CutLattice& lattice = work.lattice;
  const double all = needed + ahead;
  const BlockPlace low = lattice.placeOf(near.at - Vector3d::Constant(all)), high = lattice.placeOf(near.at + Vector3d::Constant(all));
  bool is_complete = true, is_ahead = true;
  ahead_.clear();
  BlockPlace place;
  for (place[2] = low[2]; place[2] <= high[2]; ++place[2])
    for (place[1] = low[1]; place[1] <= high[1]; ++place[1])
      for (place[0] = low[0]; place[0] <= high[0]; ++place[0]) {
        const double middle = (lattice.middleOf(place) - near.at).norm(), nearest = middle - lattice.blockRadius() - lattice.spacing();
        if (nearest > all || lattice.find(place) != CutStorage::kUnknown) continue;
        if (middle + lattice.blockRadius() + lattice.reach() < free) {
          lattice.addOutside(place);
        } else if (nearest <= needed) {
          if (result.work >= max_work || !work.layers.make(place, lattice, result.work)) is_complete = false;
        } else if (ahead_.size() < ahead_.capacity()) {
          ahead_.push_back(place);
        } else {
          is_ahead = false;
        }
      }
  for (const BlockPlace& next : ahead_) is_ahead = result.work < max_work && work.layers.make(next, lattice, result.work) && is_ahead;
  if (is_complete && is_ahead) near.known_about = near.at, near.known_within = all;
  return is_complete;
}

// What a ball that may go `way` in this step has to know of the object.
Cutter::Reach Cutter::prepare(Work& work, std::size_t ball, double way, std::uint32_t max_work, StepResult& result) {
  const CutLattice& lattice = work.lattice;
  Near& near = work.burr[ball];
  near.is_near = false;
  near.at = localOf(work, placeOf(memory_.graphic, scene_.burr[ball]));
  const auto radius = static_cast<double>(scene_.burr[ball].radius);
  const double needed = radius + 2 * lattice.reach();
  if (near.at.norm() > work.shape.radius + needed + std::max(way, kAhead)) return Reach::Far;
  double free = 0;
  if (lattice.find(lattice.placeOf(near.at)) < 0) {
    const double distance = work.layers.distanceFrom(near.at, needed + std::max(way, kAhead), result.work);
    if (distance <= radius || !work.layers.isInside(near.at, result.work)) free = distance;
    if (free - radius > std::max(way, lattice.reach())) {
      if (free < needed + kAhead) (void)makeBlocks(work, near, 0, needed + kAhead, free, max_work, result);
      return Reach::Far;
    }
  }
  if (!makeBlocks(work, near, needed, kAhead, free, max_work, result)) return Reach::Unknown;
  near.is_near = true;
  return Reach::Near;
}

void Cutter::addFacets(Work& work, std::size_t ball) {
  const CompiledObject& object = memory_.objects[work.object];
  const MovingBody& body = memory_.bodies[object.body];
  const auto radius = static_cast<double>(scene_.burr[ball].radius);
  const Vector3d arm = memory_.graphic.orientation * centreOf(scene_.burr[ball]), at = memory_.graphic.position + arm;
  Vector3d carried = Vector3d::Zero();  // way of the object there in this step
  if (body.moves) carried = motionAt(body, 1, at).translation;
  for (const Vector3d& direction : directions_) {
    float share = 0;
    const Vector3d from = work.burr[ball].at + radius * direction;
    const double gap = gapAlong(work.lattice, from, direction, share);
    if (share == 0) continue;
    const std::uint8_t layer = work.lattice.layerAt(from + (gap + 0.5 * work.lattice.spacing()) * direction);
    const CutMaterial& material = work.model.material;
    CutFacet& facet = facets_.emplace_back();
    facet.direction = object.rotation * direction;
    facet.along << facet.direction, arm.cross(facet.direction) / scene_.angle_length;
    facet.gap = gap + facet.direction.dot(carried);
    facet.area = 4 * M_PI / kFacets * radius * radius * static_cast<double>(share);
    facet.rate = (layer == 0 ? material.removal : material.inner[layer - 1u].removal) * M_PI * radius * radius;
    facet_of_.push_back({&work, layer, arm});
  }
}

// The share of the step after which no facet is too deep, and no ball has come to where blocks may be missing.
double Cutter::shareWithin(const Vector6& y) const {
  double share = 1;
  for (const Work& work : works_) {
    const CutLattice& lattice = work.lattice;
    for (std::size_t ball = 0; ball < work.burr.size(); ++ball) {
      if (!work.burr[ball].is_near) continue;
      const Vector3d arm = memory_.graphic.orientation * centreOf(scene_.burr[ball]);
      const double way = (y.head<3>() + y.tail<3>().cross(arm) / scene_.angle_length).norm();
      if (share * way > lattice.reach()) share = lattice.reach() / way;
    }
  }
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    const double towards = facets_[i].along.dot(y), most = facets_[i].gap + kBiteSpacings * facet_of_[i].work->lattice.spacing();
    if (share * towards > most) share = std::max(0.0, most / towards);
  }
  return share;
}

// The target of the spring with the force that rubs on the turning burr: against its motion at each facet, a share of
// the facet's force. The burr turns by the right hand about the axis of the spindle.
Vector6 Cutter::rubbedTarget(const CutStep& step, const Vector6& target) const {
  Vector6 out = target;
  const Vector3d axis = memory_.graphic.orientation * scene_.spindle_axis;
  double sum = 0;
  for (const CutFacet& facet : facets_) sum += std::max(0.0, facet.along.dot(step.y) - facet.gap) * facet.area / facet.rate;
  if (!(sum > 0)) return out;
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    const CutFacet& facet = facets_[i];
    const double depth = facet.along.dot(step.y) - facet.gap;
    const Vector3d motion = axis.cross(facet.direction);
    const double length = motion.norm();
    if (!(depth > 0 && length > 1e-6)) continue;
    const double tangential = facet_of_[i].work->model.material.tangential;
    const Vector3d pull =
        -tangential * step.force.norm() * (depth * facet.area / facet.rate / sum) / (scene_.pull.translation * length) * motion;
    out.head<3>() += pull;
    out.tail<3>() += facet_of_[i].arm.cross(pull) / scene_.angle_length;
  }
  return out;
}

// Finds the facets that the burr's balls have near material. Returns false if blocks are missing.
bool Cutter::findFacets(const Displacement& to_aim, StepResult& result) {
  const std::uint32_t max_work = scene_.step_limits.max_work / 4;
  bool is_known = true;
  for (Work& work : works_) {
    if (!memory_.isActive(work.object)) continue;
    follow(work.object, memory_);
    const double way =
        to_aim.translation.norm() + scene_.tool.reach * to_aim.rotation.norm() + memory_.bodies[memory_.objects[work.object].body].length;
    for (std::size_t ball = 0; ball < work.burr.size(); ++ball) {
      const Reach reach = prepare(work, ball, way, max_work, result);
      is_known = is_known && reach != Reach::Unknown;
      if (reach != Reach::Near) continue;
      addFacets(work, ball);
      result.work += 4 * kFacets;
    }
  }
  return is_known;
}

void Cutter::noteLayers(const Vector6& y) {
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    if (!(facets_[i].along.dot(y) > facets_[i].gap)) continue;
    std::uint32_t& layer = facet_of_[i].work->layer;
    layer = layer == CutState::kNone ? facet_of_[i].layer : std::max(layer, std::uint32_t{facet_of_[i].layer});
  }
}

Configuration Cutter::resisted(const Configuration& aim, StepResult& result) {
  facets_.clear(), facet_of_.clear();
  for (Work& work : works_) {
    work.layer = CutState::kNone;
    for (Near& near : work.burr) near.is_near = false;
  }
  const Displacement to_aim = displacementBetween(memory_.graphic, aim);
  if (spins_ && !findFacets(to_aim, result)) {
    result.faults |= kWorkLimit;
    return memory_.graphic;
  }
  const auto scaled = [&](const Displacement& d) {
    Vector6 out;
    out << d.translation, scene_.angle_length * d.rotation;
    return out;
  };
  const Vector6 target = scaled(to_aim);
  CutStep step;
  step.y = target;
  if (facets_.empty()) {
    last_ = {};
  } else {
    last_ = step = cutStep(facets_, target, last_, scene_.pull.translation, scene_.step_time);
    if (rubs_) step = cutStep(facets_, rubbedTarget(step, target), step, scene_.pull.translation, scene_.step_time);
    result.work += static_cast<std::uint32_t>(facets_.size());
    noteLayers(step.y);
  }
  // The force of cutting is what the tool lags behind the hand beyond its contacts. It changes as forces may elsewhere:
  // a burr that slips off, comes out or stops springs back over several steps.
  const Vector6 lag = scaled(displacementBetween(memory_.haptic, memory_.aim)), hand = scaled(displacementBetween(memory_.aim, aim));
  const ForceRateLimit limit(scene_.pull, scene_.angle_length, lag, hand, lag + hand);
  const double share = limit.shareWithin(target, step.y, shareWithin(step.y));
  if (share == 1 && facets_.empty()) return aim;
  const Vector6 y = share * step.y;
  return moved(memory_.graphic, {y.head<3>(), y.tail<3>() / scene_.angle_length});
}

void Cutter::remove(StepResult& result) {
  if (!spins_) return;
  for (Work& work : works_) {
    if (std::ranges::none_of(work.burr, &Near::is_near)) continue;
    follow(work.object, memory_);
    for (std::size_t ball = 0; ball < work.burr.size(); ++ball)
      if (work.burr[ball].is_near)
        result.work += work.lattice.remove(work.burr[ball].at, localOf(work, placeOf(memory_.graphic, scene_.burr[ball])),
                                           static_cast<double>(scene_.burr[ball].radius), work.removed);
  }
}

// Copies the pairs of a run, with the burr's balls for the leaves that cover them; without those while it turns.
void Cutter::addPairs(const PairSet& set, const PairRun& run) {
  const std::size_t begin = pairs_.size();
  const bool is_cut = workOf(run.object) != nullptr;
  for (std::uint32_t pair : set.pairs.subspan(run.begin, run.count)) {
    if (is_cut)
      if (const std::uint32_t ball = scene_.burr_of[pair >> 16]; ball != kNoItem) {
        if (spins_) continue;
        pair = (scene_.burr_slot + ball) << 16 | (pair & 0xffff);
      }
    pairs_.push_back(pair);
  }
  const auto first = pairs_.begin() + static_cast<std::ptrdiff_t>(begin);
  if (is_cut && !spins_) {  // several leaves of the burr may have met one triangle
    std::sort(first, pairs_.end());
    pairs_.erase(std::unique(first, pairs_.end()), pairs_.end());
  }
  if (pairs_.size() > begin)
    runs_.push_back({run.object, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(pairs_.size() - begin)});
}

// The parts of the tool, at `pose`, that come within `margin` of the box around what was cut.
void Cutter::findNearParts(const Work& work, const Configuration& pose, double margin) {
  const Eigen::Matrix3d turn = memory_.objects[work.object].rotation.transpose() * pose.orientation.toRotationMatrix();
  const Vector3d offset = localOf(work, pose.position), root = offset + turn * scene_.tool_root;
  near_parts_.clear();
  if (work.lattice.distanceFromCut(root) > scene_.tool_root_radius + margin) return;
  for (const std::uint32_t slot : scene_.wall_slots) {
    if (spins_ && slot >= scene_.burr_slot) break;  // they come last
    const Sphere& ball = scene_.tool.spheres[slot];
    const NearPart part{slot, offset + turn * centreOf(ball), static_cast<double>(ball.radius) + margin};
    if (work.lattice.distanceFromCut(part.at) <= part.reach) near_parts_.push_back(part);
  }
}

// Adds the pairs of the tool and the walls of an object. Returns false if there is no space for them.
bool Cutter::addWallsOf(Work& work, const Configuration& pose, double margin, std::uint32_t& tests) {
  findNearParts(work, pose, margin + kRoundingSlack);
  tests += static_cast<std::uint32_t>(scene_.wall_slots.size());
  if (near_parts_.empty()) return true;
  const double largest = work.lattice.largestWallBall(), side = 7 * work.lattice.spacing();
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
        rim = work.lattice.rimOf(block);
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
      work.lattice.visitWall(block, part.at, part.reach, [&](std::size_t point) { add(point, work.lattice.wallBall(block, point)); });
      for (std::size_t k = 0; k < rim.size(); ++k) add(kBlockPoints + k, rim[k]);
      if (!fits) return false;
    }
  }
  if (pairs_.size() > begin)
    runs_.push_back({work.object, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(pairs_.size() - begin), true});
  return true;
}

void Cutter::addWalls(const Configuration& pose, double margin, PairSet& set) {
  if (set.coarse) return;
  pairs_.clear(), runs_.clear(), wall_count_ = 0;
  bool fits = true;
  std::uint32_t tests = 0;
  const PairRun* run = set.runs.data();
  const PairRun* const end = run + set.runs.size();
  for (Work& work : works_) {  // by object, as the runs are
    for (; run != end && run->object <= work.object; ++run) addPairs(set, *run);
    if (fits && memory_.feelsSkin(work.object) && memory_.isActive(work.object)) fits = addWallsOf(work, pose, margin, tests);
  }
  for (; run != end; ++run) addPairs(set, *run);
  set.work += (tests + 7) / 8;
  set.coarse = !fits || pairs_.size() > scene_.step_limits.max_pairs;
  if (set.coarse) return;
  std::copy(pairs_.begin(), pairs_.end(), memory_.pairs.begin());
  memory_.runs.assign(runs_.begin(), runs_.end());
  set.pairs = {memory_.pairs.data(), pairs_.size()};
  set.runs = memory_.runs;
}

std::uint32_t Cutter::dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const {
  bool is_changed = false;
  std::uint32_t work_done = 0;
  for (const PairRun& run : set.runs) {
    const Work* const work = run.of_wall ? nullptr : workOf(run.object);
    if (!work || !work->lattice.isCut()) continue;
    work_done += run.count;
    const Eigen::Matrix3d back = memory_.objects[run.object].rotation.transpose(), turn = back * pose.orientation.toRotationMatrix();
    const Vector3d origin = localOf(*work, pose.position);
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
