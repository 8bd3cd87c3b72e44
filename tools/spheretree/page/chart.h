// SPDX-License-Identifier: GPL-3.0-or-later
// Charts as SVG text: speed against accuracy, and traces over time. Readable in print, on light and on dark screens:
// colours come from chartStyle() and follow the reader's setting. Every curve and dot carries its name beside it, so
// that none depends on colour.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::tool {

/// Rules for the classes that the charts use; a page that holds charts includes them once.
std::string_view chartStyle();

/// Up to 3 significant digits, without an exponent where that is short: "0.0123", "12.3", "1230", "4.1e-06".
std::string shortNumber(double value);

struct ChartPoint {
  double x = 0, y = 0;  // a point with x or y not above 0 is left out: the axes are logarithmic
  std::string series;   // points of one series are joined in their order; its name stands beside its last point; "": of none
  std::string title;    // what a pointer that rests on the dot shows
  int size = 1;         // 0 small, 1 medium, 2 large
  bool chosen = false;  // ringed
};

struct ScatterChart {
  std::string title, x_label, y_label;
  std::vector<ChartPoint> points;
  struct Line {
    double y;
    std::string label;
  };
  std::optional<Line> limit;  // dashed, across
  bool front = true;          // mark the Pareto front
};

/// Which points no other point beats in both x and y (less is better). Of equal points the first counts.
std::vector<bool> paretoFront(std::span<const ChartPoint> points);

/// Both axes logarithmic, less is better on both; the Pareto front, if marked, is a stepped line, its dots filled. A
/// few dots far above all others are arrows at the top, with their figure, so that the axis serves the others.
std::string scatterSvg(const ScatterChart& chart);

struct Trace {
  std::string name;
  std::vector<float> y;  // as many as x; what is not finite leaves a gap
};

struct TraceChart {
  std::string title, x_label, y_label;
  std::vector<float> x;  // ascending
  std::vector<Trace> traces;
  bool log_y = false;
  std::optional<ScatterChart::Line> limit;
};

/// Each pixel column shows the least and the greatest value in it, so that no peak is lost however long the trace.
/// Cost: O(values).
std::string traceSvg(const TraceChart& chart);

/// One SVG file: a heading, and the charts (as the two functions above give them) in a row.
std::string svgFile(const std::string& heading, std::span<const std::string> charts);

/// `&`, `<`, `>` and `"` as entities.
std::string escaped(std::string_view text);

}  // namespace spheretree::tool
