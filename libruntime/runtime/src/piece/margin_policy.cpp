// SPDX-License-Identifier: Apache-2.0
#include "piece/margin_policy.h"

#include <algorithm>

namespace spheretree::runtime {

MarginPolicy::MarginPolicy(double to_hand, double hand_motion, bool is_touching)
    : margin_(std::max(kMinMargin, std::min(to_hand, 1.5 * hand_motion + 0.05))) {
  if (is_touching) margin_ = std::min(margin_, kContactMargin);
}

void MarginPolicy::searched() {
  used_ = 0;
  needs_search_ = false;
}

bool MarginPolicy::shorten(bool is_list_full) {
  const double smallest = is_list_full ? kMinMargin : kContactMargin;
  if (margin_ <= smallest) return false;
  margin_ = std::max(smallest, margin_ / 4);
  if (is_list_full) limit_ = margin_;
  return true;
}

double MarginPolicy::shareOfBodies(double way) const { return std::min(1.0, left() / (kCarriedMargin * way)); }

bool MarginPolicy::widenForBodies(double own, double way) {
  if (!needs_search_ && !(left() < kCarriedMargin * way)) return false;
  margin_ = std::max(kMinMargin, std::min(own + kCarriedMargin * way, limit_));
  return true;
}

void MarginPolicy::growFree(double rest) {
  margin_ = std::min(std::min(4 * margin_, rest), limit_);
  needs_search_ = true;
}

void MarginPolicy::growAlong(double share, double length) {
  if (!(left() < 0.5 * (1 - share) * length)) return;
  const double wish = std::max(margin_, std::min(std::min(4 * margin_, 1.1 * (1 - share) * length + kMinMargin), kContactMargin));
  margin_ = std::max(kMinMargin, std::min(wish, limit_));
  needs_search_ = true;
}

bool MarginPolicy::narrow(double piece) {
  const double next = kPiecesAhead * piece + kMinMargin;
  if (!(next < 0.5 * left())) return false;
  margin_ = next;
  used_ = 0;
  return true;
}

void MarginPolicy::feelWithin(double way) { felt_reach_ = std::min(kFeltReach, way + kMinMargin); }

}  // namespace spheretree::runtime
