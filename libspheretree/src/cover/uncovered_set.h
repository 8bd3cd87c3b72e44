// SPDX-License-Identifier: GPL-3.0-or-later
// The uncovered samples of a cover: a set of small integers with O(1) insertion, removal and random choice.
#pragma once

#include <cstdint>
#include <vector>

namespace spheretree::builder {

class UncoveredSet {
 public:
  /// Empties the set; members must be below `range`.
  void reset(std::size_t range) {
    place_.assign(range, 0);
    members_.clear();
  }
  /// Increases the range by one.
  void grow() { place_.push_back(0); }
  /// `s` must not be in the set.
  void insert(std::uint32_t s) {
    place_[s] = static_cast<std::uint32_t>(members_.size());
    members_.push_back(s);
  }
  /// `s` must be in the set. Changes the order of the other members.
  void erase(std::uint32_t s) {
    members_[place_[s]] = members_.back();
    place_[members_.back()] = place_[s];
    members_.pop_back();
  }
  bool empty() const { return members_.empty(); }
  /// A member chosen by a random number; the set must not be empty.
  std::uint32_t anyOf(std::uint64_t random) const { return members_[static_cast<std::size_t>(random % members_.size())]; }
  auto begin() const { return members_.begin(); }
  auto end() const { return members_.end(); }

 private:
  std::vector<std::uint32_t> members_, place_;  // place_: index in members_
};

}  // namespace spheretree::builder
