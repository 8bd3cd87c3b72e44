// SPDX-License-Identifier: Apache-2.0
#include "cut/burr_facets.h"

#include <algorithm>
#include <cmath>

#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kBiteSpacings = 2;  // largest depth of a cut in a step: half of the reach of the fields
constexpr double kAhead = 1;         // blocks are made this far ahead of need [mm]
constexpr int kAheadBlocks = 2;      // as many a step
constexpr int kFacets = 192;         // of a burr ball: each turns by 8 degrees
constexpr double kEdge = 0.25;       // the rim of what was removed is this wide, in spacings
constexpr int kMaxTraces = 12;       // of the way to the material

// Points evenly on the unit sphere: the spiral of equal areas whose turns are apart by the golden angle.
std::vector<Vector3d> spiral(int count) {
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, around = M_PI * (3 - std::sqrt(5.0)) * i, r = std::sqrt(1 - z * z);
    out.push_back({r * std::cos(around), r * std::sin(around), z});
  }
  return out;
}

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

BurrFacets::BurrFacets(const StepMemory& memory, std::vector<CutWork>& works)
    : memory_(memory), scene_(memory.scene), works_(works), directions_(spiral(kFacets)) {
  for (const CutWork& work : works) rubs_ = rubs_ || work.model.material.tangential > 0;
  const std::size_t facets = works.size() * scene_.burr.size() * kFacets;
  facets_.reserve(facets);
  facet_of_.reserve(facets);
  ahead_.reserve(kAheadBlocks);
}

// Makes the blocks within `needed` of the ball, and some of those within `ahead` of that. No surface is within `free`
// of it. Returns whether all that are needed are there.
bool BurrFacets::makeBlocks(CutWork& work, NearBall& near, double needed, double ahead, double free, std::uint32_t max_work,
                            StepResult& result) {
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
BurrFacets::Reach BurrFacets::prepare(CutWork& work, std::size_t ball, double way, std::uint32_t max_work, StepResult& result) {
  const CutLattice& lattice = work.lattice;
  NearBall& near = work.burr[ball];
  near.is_near = false;
  near.at = work.localOf(placeOf(memory_.graphic, scene_.burr[ball]), memory_);
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

void BurrFacets::add(CutWork& work, std::size_t ball) {
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

double BurrFacets::shareWithin(const Vector6& y) const {
  double share = 1;
  for (const CutWork& work : works_) {
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
Vector6 BurrFacets::rubbedTarget(const CutStep& step, const Vector6& target) const {
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

bool BurrFacets::find(const Displacement& to_aim, bool spins, StepResult& result) {
  facets_.clear(), facet_of_.clear();
  for (CutWork& work : works_) {
    work.layer = CutState::kNone;
    for (NearBall& near : work.burr) near.is_near = false;
  }
  if (!spins) return true;
  const std::uint32_t max_work = scene_.step_limits.max_work / 4;
  bool is_known = true;
  for (CutWork& work : works_) {
    if (!memory_.isActive(work.object)) continue;
    const double way =
        to_aim.translation.norm() + scene_.tool.reach * to_aim.rotation.norm() + memory_.bodies[memory_.objects[work.object].body].length;
    for (std::size_t ball = 0; ball < work.burr.size(); ++ball) {
      const Reach reach = prepare(work, ball, way, max_work, result);
      is_known = is_known && reach != Reach::Unknown;
      if (reach != Reach::Near) continue;
      add(work, ball);
      result.work += 4 * kFacets;
    }
  }
  return is_known;
}

void BurrFacets::noteLayers(const Vector6& y) {
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    if (!(facets_[i].along.dot(y) > facets_[i].gap)) continue;
    std::uint32_t& layer = facet_of_[i].work->layer;
    layer = layer == CutState::kNone ? facet_of_[i].layer : std::max(layer, std::uint32_t{facet_of_[i].layer});
  }
}

Vector6 BurrFacets::step(const Vector6& target, StepResult& result) {
  CutStep step = last_ = cutStep(facets_, target, last_, scene_.pull.translation, scene_.step_time);
  if (rubs_) step = cutStep(facets_, rubbedTarget(step, target), step, scene_.pull.translation, scene_.step_time);
  result.work += static_cast<std::uint32_t>(facets_.size());
  noteLayers(step.y);
  return step.y;
}

}  // namespace spheretree::runtime
