// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sph_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <vector>

#include "spheretree/core/rounding.h"
#include "spheretree/formats/errors.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

/// Number of slots of a full tree.
std::size_t slotCount(int levels, int branching) {
  std::size_t total = 0, level = 1;
  for (int i = 0; i < levels; ++i, level *= static_cast<std::size_t>(branching)) total += level;
  return total;
}

class SphReader {
 public:
  SphReader(std::string_view text, const std::string& name) : lines_(std::span<const char>(text.data(), text.size())), name_(name) {}

  /// Moves to the next line that is not blank; false at the end.
  bool next() {
    while (lines_.next(line_))
      if (!trimmed(line_).empty()) return true;
    return false;
  }

  /// The next number of the line.
  double number(const std::string& what) {
    const std::string_view word = takeWord(line_);
    double value = 0;
    if (parseDouble(word, value) != NumberFault::None) fail(what + " is " + inQuotes(word) + ", not a number");
    return value;
  }
  int whole(const std::string& what, int min, int max) {
    const std::string_view word = takeWord(line_);
    std::int64_t value = 0;
    if (!parseInteger(word, value) || value < min || value > max)
      fail(what + " is " + inQuotes(word) + ", not a whole number from " + std::to_string(min) + " to " + std::to_string(max));
    return static_cast<int>(value);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError(name_ + ", line " + std::to_string(lines_.number()) + ": " + what + ". Export the tree again.");
  }

 private:
  Lines lines_;
  std::string_view line_;
  const std::string& name_;
};

struct Slot {
  std::array<double, 3> centre{};
  double radius = 0;
  bool used = false;
};

/// Floats round to 2^-24 of a coordinate: far from the origin of the frame this would be large compared with the
/// spheres. There, the origin is the middle of their bounding box.
std::array<double, 3> originOf(const std::vector<Slot>& slots) {
  constexpr double kFar = 16;  // in diagonals of the box
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity}, middle{};
  double diagonal2 = 0, farthest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const Slot& s : slots) {
      if (!s.used) continue;
      low[axis] = std::min(low[axis], s.centre[axis] - s.radius);
      high[axis] = std::max(high[axis], s.centre[axis] + s.radius);
    }
    middle[axis] = (low[axis] + high[axis]) / 2;
    diagonal2 += (high[axis] - low[axis]) * (high[axis] - low[axis]);
    farthest = std::max({farthest, -low[axis], high[axis]});
  }
  return farthest > kFar * std::sqrt(diagonal2) ? middle : std::array<double, 3>{};
}

}  // namespace

std::string writeSph(const SphereTree& tree, SphereKind kind) {
  const auto branching = static_cast<std::size_t>(tree.branching);
  std::vector<std::uint32_t> node_at(slotCount(tree.levelCount(), tree.branching), kNone);
  node_at[0] = 0;
  std::string text = std::to_string(tree.levelCount()) + " " + std::to_string(tree.branching) + "\n";
  for (std::size_t slot = 0; slot < node_at.size(); ++slot) {
    const std::uint32_t node = node_at[slot];
    if (node == kNone) {
      text += "0 0 0 -1 0\n";
      continue;
    }
    for (std::uint32_t c = 0; c < tree.child_count[node]; ++c) node_at[slot * branching + 1 + c] = tree.first_child[node] + c;
    const Sphere& s = sphereOf(tree, node, kind);
    char line[128];
    std::snprintf(line, sizeof line, "%.9g %.9g %.9g %.9g 1\n", s.x + tree.origin_mm[0], s.y + tree.origin_mm[1], s.z + tree.origin_mm[2],
                  static_cast<double>(s.radius));
    text += line;
  }
  return text;
}

SphereTree parseSph(std::string_view text, const std::string& name) {
  SphReader lines(text, name);
  if (!lines.next()) throw FormatError(name + ": is empty. Export the tree again.");
  const int levels = lines.whole("the number of levels", 1, kMaxLevels);
  const int branching = lines.whole("the branching", kMinBranching, kMaxBranching);

  const std::size_t slot_count = slotCount(levels, branching);
  std::vector<Slot> slots;
  const auto width = static_cast<std::size_t>(branching);
  for (std::size_t i = 0; i < slot_count; ++i) {
    if (!lines.next())
      throw FormatError(name + ": ends after " + std::to_string(i) + " of " + std::to_string(slot_count) +
                        " nodes. Export the tree again.");
    const std::string node = "node " + std::to_string(i);
    Slot slot;
    for (double& x : slot.centre) x = lines.number(node + ": a coordinate");
    slot.radius = lines.number(node + ": the radius");
    slot.used = !std::signbit(slot.radius);  // the toolkit also writes -0.000000 for an unused node
    if (slot.used) {
      for (const double x : slot.centre)
        if (!(std::abs(x) <= std::numeric_limits<float>::max())) lines.fail(node + ": a coordinate is not a finite float");
      const float stored = roundToFloat(slot.radius);
      if (!(slot.radius > 0) || !std::isfinite(stored) || !(stored > 0)) lines.fail(node + ": the radius is not finite and above 0");
      if (i > 0 && !slots[(i - 1) / width].used)
        lines.fail(node + ": is used, but its parent, node " + std::to_string((i - 1) / width) + ", is not");
    } else if (i == 0) {
      lines.fail("the root is unused");
    }
    slots.push_back(slot);
  }

  SphereTree tree;
  tree.branching = static_cast<std::uint8_t>(branching);
  tree.provenance.builder = "imported";
  tree.origin_mm = originOf(slots);

  const auto hasChild = [&](std::size_t slot) {
    for (std::size_t c = slot * width + 1; c <= slot * width + width && c < slot_count; ++c)
      if (slots[c].used) return true;
    return false;
  };
  std::vector<std::size_t> order{0};  // slots in the order of the tree's nodes
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t slot = order[i], first = order.size();
    for (const bool inner : {true, false})
      for (std::size_t c = slot * width + 1; c <= slot * width + width && c < slot_count; ++c)
        if (slots[c].used && hasChild(c) == inner) order.push_back(c);
    tree.child_count.push_back(static_cast<std::uint8_t>(order.size() - first));
    const Slot& s = slots[slot];
    tree.cover.push_back({roundToFloat(s.centre[0] - tree.origin_mm[0]), roundToFloat(s.centre[1] - tree.origin_mm[1]),
                          roundToFloat(s.centre[2] - tree.origin_mm[2]), roundToFloat(s.radius)});
  }
  if (!linkNodes(tree)) throw FormatError(name + ": the nodes do not make a tree. Export the tree again.");
  encloseDescendants(tree);
  countLevels(tree);
  if (const std::string fault = findFault(tree); !fault.empty()) throw FormatError(name + ": " + fault + ". Export the tree again.");
  return tree;
}

}  // namespace spheretree::formats
