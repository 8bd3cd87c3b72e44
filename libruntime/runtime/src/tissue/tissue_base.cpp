// SPDX-License-Identifier: Apache-2.0
#include "tissue/tissue_base.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr double kArrived = 1e-4;  // if the base is nearer than this to its target, it moves there at once [mm]

}  // namespace

void TissueBase::reset() {
  for (std::vector<float>* field : {&place_, &start_, &way_}) std::fill(field->begin(), field->end(), 0.0f);
  aim_ = {};
  left_ = 0;
  moves_ = false;
}

void TissueBase::aim(std::span<const float> surface) {
  aim_ = surface;
  left_ = longestOf(aim_.size(), [&](std::size_t i) { return aim_[i] - place_[i]; });
}

bool TissueBase::follow(double share, double max_motion) {
  moves_ = false;
  start_ = place_;
  if (aim_.size() != place_.size() || left_ == 0 || !std::isfinite(left_)) return false;
  if (left_ <= kArrived) share = 1;
  if (share * left_ > max_motion) share = max_motion / left_;
  if (share == 0) return false;
  for (std::size_t i = 0; i < place_.size(); ++i) {
    way_[i] = static_cast<float>(share) * (aim_[i] - place_[i]);
    place_[i] += way_[i];
  }
  left_ *= 1 - share;
  return moves_ = true;
}

void TissueBase::takeBack() {
  place_ = start_;
  moves_ = false;
  if (aim_.size() == place_.size()) aim(aim_);
}

}  // namespace spheretree::runtime
