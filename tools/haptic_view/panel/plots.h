// SPDX-License-Identifier: GPL-3.0-or-later
// Curves over time (force, its components, torque, depth and step time) for one or two runs. Drawn by Dear ImGui's draw
// lists.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "draw/look.h"
#include "panel/history.h"

namespace spheretree::view {

/// One curve.
struct Curve {
  std::span<const PlotSample> samples;
  std::function<float(const PlotSample&)> value;
  Colour colour;
  std::string name;  // in the legend; empty: none
};

struct Plot {
  std::string title, unit;
  std::vector<Curve> curves;
  bool from_zero = true;        // the axis begins at 0 and has no negative part
  double min_span = 1;          // smallest length of the axis [unit]
  std::optional<double> limit;  // a line that a run should stay below
};

/// Largest and smallest value of a curve, and its first and last value, in each of `columns` columns of time.
struct Column {
  float low = 0, high = 0;
  bool is_empty = true;
};
std::vector<Column> columnsOf(const Curve& curve, double begin, double end, int columns);

/// An end of an axis: the smallest round number that is at least `value`: 1, 2 or 5 times a power of ten.
double roundEnd(double value);

/// The five plots of a run; `other` may be empty. Times from `begin` to `end`.
std::vector<Plot> plotsOf(std::span<const PlotSample> run, std::span<const PlotSample> other, const Theme& theme,
                          const std::vector<std::optional<double>>& limits);

/// Draws in the current window of Dear ImGui, from its cursor. `mark`: a time to mark.
void drawPlot(const Plot& plot, double begin, double end, std::optional<double> mark, float width, float height, const Theme& theme);

}  // namespace spheretree::view
