// SPDX-License-Identifier: GPL-3.0-or-later
// Progress of work on many objects, some of them at once.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// The base class is silent, as builder::Progress is.
class WorkProgress : public builder::Progress {
 public:
  struct Objects {
    std::size_t done = 0, count = 0;
    std::vector<std::string> running;  // names, the longest at work first
  };
  struct Finished {
    std::string name;
    bool is_built = true;  // false: it failed
    std::size_t leaves = 0;
    double overhang_bound_mm = 0;  // of the leaves
    double seconds = 0;
  };
  /// What follows is the part from `begin` to `end` of the whole, 0..1: each stage in turn fills it.
  virtual void share(double /*begin*/, double /*end*/) {}
  /// How far a stage is, and what is at work now.
  virtual void advance(double fraction, const Objects& /*objects*/) { advance(fraction); }
  virtual void finished(const Finished& /*object*/) {}
  using builder::Progress::advance;
};

}  // namespace spheretree::tool
