// SPDX-License-Identifier: GPL-3.0-or-later
// Charts as SVG text: speed against accuracy, and traces over time. They are readable in print and on light and dark
// screens: colours come from chartStyle() and follow the reader's setting. Every curve and dot has its name beside it,
// so that none depends on colour.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::tool {

/// CSS rules for the classes in the charts; a page with charts includes them once.
std::string_view chartStyle();

/// At most 3 significant digits, without an exponent where that is short: "0.0123", "12.3", "1230", "4.1e-06".
std::string shortNumber(double value);

struct ChartPoint {
  double x = 0, y = 0;  // points with x or y not above 0 are left out, since the axes are logarithmic
  std::string series;   // points of one series are connected in their order; its name is beside its last point; "": no series
  std::string title;    // tooltip of the dot
  int size = 1;         // 0 small, 1 medium, 2 large
  bool chosen = false;  // drawn with a ring
  bool square = false;  // a square instead of a disc, for a second family of points
};

struct ScatterChart {
  std::string title, x_label, y_label;
  std::vector<ChartPoint> points;
  struct Line {
    double y;
    std::string label;
  };
  std::optional<Line> limit;  // dashed, horizontal
  bool front = true;          // mark the Pareto front
};

/// Whether no other point is better in both x and y (less is better). Of equal points the first counts.
std::vector<bool> paretoFront(std::span<const ChartPoint> points);

/// Both axes are logarithmic, and less is better on both. The Pareto front, if marked, is a stepped line with filled
/// dots. A few dots far above all others are shown as arrows at the top, with their values, so that the axis suits the
/// other dots.
std::string scatterSvg(const ScatterChart& chart);

struct Trace {
  std::string name;
  std::vector<float> y;  // as many as x; a value that is not finite leaves a gap
};

struct TraceChart {
  std::string title, x_label, y_label;
  std::vector<float> x;  // ascending
  std::vector<Trace> traces;
  bool log_y = false;
  std::optional<ScatterChart::Line> limit;
};

/// For a screen, and for a phone, where a broad chart would be cut or too small to read.
enum class TraceSize { Broad, Narrow };

/// Each pixel column shows the smallest and the largest value in it, so that every peak is visible in a trace of any
/// length.
/// Cost: O(values).
std::string traceSvg(const TraceChart& chart, TraceSize size = TraceSize::Broad);

/// Both sizes, of which a page shows the one that fits.
std::string traceCharts(const TraceChart& chart);

/// One SVG file: a heading, and the charts (from the two functions above) in a row.
std::string svgFile(const std::string& heading, std::span<const std::string> charts);

/// `&`, `<`, `>` and `"` as entities.
std::string escaped(std::string_view text);

}  // namespace spheretree::tool
