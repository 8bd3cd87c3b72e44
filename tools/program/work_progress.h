// SPDX-License-Identifier: GPL-3.0-or-later
// Progress of work on many objects, some of them in parallel.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// The base class does nothing, like builder::Progress.
class WorkProgress : public builder::Progress {
 public:
  struct Objects {
    std::size_t done = 0, count = 0;
    std::vector<std::string> running;  // names of the objects in work, the longest-running first
  };
  struct Finished {
    std::string name;
    bool is_built = true;  // false: it failed
    std::size_t leaves = 0;
    double overhang_bound_mm = 0;  // of the leaves
    double seconds = 0;
  };
  /// The following stages fill the part from `begin` to `end` of the whole, 0..1.
  virtual void share(double /*begin*/, double /*end*/) {}
  /// The fraction of a stage that is done, and the objects in work.
  virtual void advance(double fraction, const Objects& /*objects*/) { advance(fraction); }
  virtual void finished(const Finished& /*object*/) {}
  using builder::Progress::advance;
};

}  // namespace spheretree::tool
