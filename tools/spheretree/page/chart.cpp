// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <sstream>

namespace spheretree::tool {
namespace {

constexpr double kWidth = 400, kHeight = 340;  // size of a chart [px]
constexpr double kLeft = 62, kRight = 18, kTop = 34, kBottom = 46;
constexpr double kStrip = 26;  // height above the axis of a chart for dots beyond its end [px]
constexpr double kTraceWidth = 860, kNarrowTraceWidth = 400, kTraceHeight = 220, kTraceRight = 84;
constexpr double kLetter = 6.7, kBoldLetter = 7.6;  // mean width of a letter of the labels in a wide font [px]
constexpr std::array<double, 3> kRadius{3, 4.2, 5.6};

struct Box {
  double x0, y0, x1, y1;
  double overlap(const Box& other) const {
    const double w = std::min(x1, other.x1) - std::max(x0, other.x0), h = std::min(y1, other.y1) - std::max(y0, other.y0);
    return w > 0 && h > 0 ? w * h : 0;
  }
};

std::string px(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  std::string out = text;
  if (out.ends_with(".0")) out.resize(out.size() - 2);
  return out == "-0" ? "0" : out;
}

std::string line(const char* css, double x0, double y0, double x1, double y1) {
  return std::string("<line class=\"") + css + "\" x1=\"" + px(x0) + "\" y1=\"" + px(y0) + "\" x2=\"" + px(x1) + "\" y2=\"" + px(y1) +
         "\"/>\n";
}

std::string text(const char* css, double x, double y, std::string_view anchor, std::string_view words) {
  return std::string("<text class=\"") + css + "\" x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + std::string(anchor) + "\">" +
         escaped(words) + "</text>\n";
}

/// One axis: the position of a value, and the ticks.
struct Axis {
  double from = 0, to = 1, place0 = 0, place1 = 1;
  bool log = false;
  std::vector<double> ticks;

  double at(double value) const {
    const double share = log ? (std::log10(value) - std::log10(from)) / (std::log10(to) - std::log10(from)) : (value - from) / (to - from);
    return place0 + share * (place1 - place0);
  }
};

/// With about so many parts, but at least three ticks: beside fewer, no value can be read.
Axis linearAxis(double smallest, double largest, double place0, double place1, int about) {
  if (!(largest > smallest)) largest = smallest + std::max(1.0, std::abs(smallest));
  const double raw = (largest - smallest) / about, power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = power;
  for (const double digit : {1.0, 2.0, 5.0, 10.0})
    if (digit * power >= raw * 0.999) {
      step = digit * power;
      break;
    }
  Axis axis{smallest, largest, place0, place1, false, {}};
  for (double k = std::ceil(smallest / step - 1e-9); k * step <= largest + 1e-9 * step; ++k) axis.ticks.push_back(k == 0 ? 0 : k * step);
  return axis.ticks.size() < 3 ? linearAxis(smallest, largest, place0, place1, about + 1) : axis;
}

Axis logAxis(double smallest, double largest, double place0, double place1) {
  Axis axis{smallest / 1.25, largest * 1.25, place0, place1, true, {}};
  if (axis.to / axis.from < 2) {  // a smaller range would magnify noise
    const double middle = std::sqrt(axis.from * axis.to);
    axis.from = middle / std::numbers::sqrt2, axis.to = middle * std::numbers::sqrt2;
  }
  const double decades = std::log10(axis.to / axis.from);
  const int step = std::max(1, static_cast<int>(std::ceil(decades / 5)));
  for (int power = static_cast<int>(std::floor(std::log10(axis.from))); power <= std::ceil(std::log10(axis.to)); ++power)
    for (const double digit : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
      if (digit > 1 && decades > 3.2) continue;
      if (digit != 2 && digit != 5 && digit > 1 && decades > 0.8) continue;
      if (decades > 5 && power % step != 0) continue;
      const double value = digit * std::pow(10.0, power);
      if (value >= axis.from && value <= axis.to) axis.ticks.push_back(value);
    }
  if (axis.ticks.size() < 3) axis.ticks = linearAxis(axis.from, axis.to, place0, place1, 4).ticks;
  return axis;
}

/// The largest y within the axis. A few dots are left out if their distance from the others exceeds the range of those,
/// since they would compress the others into a corner.
double axisEnd(std::span<const ChartPoint> points) {
  std::vector<double> y(points.size());
  std::transform(points.begin(), points.end(), y.begin(), [](const ChartPoint& p) { return p.y; });
  std::sort(y.begin(), y.end());
  for (std::size_t i = y.size() - y.size() / 4; i < y.size(); ++i)
    if (y[i] / y[i - 1] > std::max(3.0, y[i - 1] / y[0])) return y[i - 1];
  return y.back();
}

/// Where the plot begins at the left, so that the labels of the ticks do not reach the name of the axis.
double leftOf(const Axis& y) {
  std::size_t longest = 0;
  for (const double value : y.ticks) longest = std::max(longest, shortNumber(value).size());
  return std::max(kLeft, 26 + kLetter * static_cast<double>(longest));
}

/// The lines of a title in a chart of this width.
std::vector<std::string> titleLines(const std::string& title, double width) {
  std::vector<std::string> lines{""};
  std::istringstream words(title);
  for (std::string word; words >> word;) {
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (kBoldLetter * static_cast<double>(longer.size()) > width && !lines.back().empty())
      lines.push_back(word);
    else
      lines.back() = longer;
  }
  return lines;
}

constexpr double kTitleLine = 15;  // height of a further line of a title [px]

/// The frame of a chart: title, grid, tick labels, names of the axes.
std::string frame(const std::vector<std::string>& title, const std::string& x_label, const std::string& y_label, const Axis& x,
                  const Axis& y) {
  std::string out;
  for (std::size_t i = 0; i < title.size(); ++i)
    out += text("ct", title.size() == 1 ? x.place0 : 8, 18 + kTitleLine * static_cast<double>(i), "start", title[i]);
  for (const double value : y.ticks) {
    out += line("cg", x.place0, y.at(value), x.place1, y.at(value));
    out += text("ck", x.place0 - 6, y.at(value) + 4, "end", shortNumber(value));
  }
  for (const double value : x.ticks) {
    out += line("cg", x.at(value), y.place0, x.at(value), y.place1);
    out += text("ck", x.at(value), y.place0 + 16, "middle", shortNumber(value));
  }
  out += line("ca", x.place0, y.place0, x.place1, y.place0);
  out += text("cl", (x.place0 + x.place1) / 2, y.place0 + 36, "middle", x_label);
  const double middle = (y.place0 + y.place1) / 2;
  out += "<text class=\"cl\" transform=\"translate(13 " + px(middle) + ") rotate(-90)\" text-anchor=\"middle\">" + escaped(y_label) +
         "</text>\n";
  return out;
}

std::string wrapped(double width, double height, const std::string& title, const std::string& body, const std::string& css = "chart") {
  return "<svg class=\"" + css + "\" xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(width) + "\" height=\"" + px(height) +
         "\" viewBox=\"0 0 " + px(width) + " " + px(height) + "\" role=\"img\" aria-label=\"" + escaped(title) + "\">\n" + body +
         "</svg>\n";
}

/// Places names beside their dots where they hide least: tries positions around the dot, near ones first.
class Labels {
 public:
  Labels(Box area, std::vector<Box> taken) : area_(area), taken_(std::move(taken)) {}

  /// The name beside its dot; nothing if it is not strong and has no room.
  std::string place(double x, double y, double radius, const std::string& name, bool strong) {
    const double width = (strong ? kBoldLetter : kLetter) * static_cast<double>(name.size()), height = 12;
    constexpr double kRoundedAway = 1e-6;  // [px^2]
    double best_cost = std::numeric_limits<double>::infinity();
    Box best{};
    double best_reach = 0;
    for (const double reach : {4.0, 10.0, 18.0, 28.0, 40.0, 54.0, 70.0, 90.0})
      for (int turn = 0; turn < 16; ++turn) {
        const double angle = turn * std::numbers::pi / 8, dx = std::cos(angle), dy = -std::sin(angle);
        const double cx = x + dx * (radius + reach + width / 2), cy = y + dy * (radius + reach + height / 2);
        const Box box{cx - width / 2, cy - height / 2, cx + width / 2, cy + height / 2};
        double cost = reach * 2 + turn * 0.2, hidden = 10 * (width * height - box.overlap(area_));
        for (const Box& other : taken_) cost += 3 * box.overlap(other);
        for (const Box& other : names_) hidden += 20 * box.overlap(other);
        if (hidden > kRoundedAway && !strong) continue;
        cost += hidden;
        if (cost < best_cost) best_cost = cost, best = box, best_reach = reach;
      }
    if (best_cost == std::numeric_limits<double>::infinity()) return {};
    names_.push_back(best);
    std::string out;
    if (best_reach > 5) {  // a line from the dot to the nearest point of the name
      const double to_x = std::clamp(x, best.x0, best.x1), to_y = std::clamp(y, best.y0, best.y1);
      out += line("cd", x, y, to_x, to_y);
    }
    return out + text(strong ? "cn cs" : "cn", (best.x0 + best.x1) / 2, best.y1 - 2, "middle", name);
  }

 private:
  Box area_;
  std::vector<Box> taken_, names_;
};

std::string stepLine(std::vector<const ChartPoint*> front, const Axis& x, const Axis& y) {
  std::erase_if(front, [&](const ChartPoint* p) { return p->y > y.to; });
  std::sort(front.begin(), front.end(), [](const ChartPoint* a, const ChartPoint* b) { return a->x < b->x; });
  std::string path;
  for (std::size_t i = 0; i < front.size(); ++i) {
    path += i == 0 ? "M" + px(x.at(front[i]->x)) + " " + px(y.place1) + "V" : "H" + px(x.at(front[i]->x)) + "V";
    path += px(y.at(front[i]->y));
  }
  path += "H" + px(x.place1);
  return "<path class=\"cf\" d=\"" + path + "\"/>\n";
}

/// The points of a scatter chart that can be shown, and where they lie. A dot above the end of the axis lies in the
/// strip.
struct ScatterLayout {
  std::vector<ChartPoint> points;
  std::vector<bool> on_front;                              // of each point
  std::map<std::string, std::vector<std::size_t>> series;  // indices of points
  bool has_limit = false;
  Axis x, y;

  double placeOf(const ChartPoint& p) const { return p.y > y.to ? kTop + kStrip / 2 - 2 : y.at(p.y); }
};

double dotRadius(const ChartPoint& p) { return kRadius[static_cast<std::size_t>(std::clamp(p.size, 0, 2))]; }

/// The layout; without points if there is nothing to show.
ScatterLayout scatterLayout(const ScatterChart& chart) {
  ScatterLayout out;
  std::vector<ChartPoint>& points = out.points;
  for (const ChartPoint& p : chart.points)
    if (std::isfinite(p.x) && std::isfinite(p.y) && p.x > 0 && p.y > 0) points.push_back(p);
  if (points.empty()) return out;
  double min_x = points[0].x, max_x = min_x, min_y = points[0].y, max_y = min_y;
  for (const ChartPoint& p : points) {
    min_x = std::min(min_x, p.x), max_x = std::max(max_x, p.x);
    min_y = std::min(min_y, p.y), max_y = std::max(max_y, p.y);
  }
  out.has_limit = chart.limit && std::isfinite(chart.limit->y) && chart.limit->y > 0;
  if (out.has_limit) min_y = std::min(min_y, chart.limit->y), max_y = std::max(max_y, chart.limit->y);
  const double end_y = out.has_limit ? max_y : axisEnd(points);
  out.y = logAxis(min_y, end_y, kHeight - kBottom, end_y < max_y ? kTop + kStrip : kTop);
  out.x = logAxis(min_x, max_x, leftOf(out.y), kWidth - kRight);
  out.on_front = chart.front ? paretoFront(points) : std::vector<bool>(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) out.series[points[i].series].push_back(i);
  return out;
}

/// The Pareto front, and a line through the points of each series.
std::string scatterLines(const ScatterLayout& layout) {
  std::string out;
  std::vector<const ChartPoint*> front;
  for (std::size_t i = 0; i < layout.points.size(); ++i)
    if (layout.on_front[i]) front.push_back(&layout.points[i]);
  if (!front.empty()) out += stepLine(front, layout.x, layout.y);
  for (const auto& [name, members] : layout.series) {
    if (name.empty() || members.size() < 2) continue;
    std::string path;
    for (const std::size_t i : members)
      path += (path.empty() ? "M" : "L") + px(layout.x.at(layout.points[i].x)) + " " + px(layout.placeOf(layout.points[i]));
    out += "<path class=\"cj\" d=\"" + path + "\"/>\n";
  }
  return out;
}

std::string dotSvg(const ScatterLayout& layout, std::size_t i) {
  const ChartPoint& p = layout.points[i];
  const double radius = dotRadius(p), cx = layout.x.at(p.x), cy = layout.placeOf(p);
  const std::string css = layout.on_front[i] ? "co" : "cp";
  if (p.y > layout.y.to)  // an arrow instead of the dot
    return "<path class=\"" + css + "\" d=\"M" + px(cx) + " " + px(cy - 6) + "l5 9h-10z\"><title>" + escaped(p.title) + "</title></path>\n";
  std::string out;
  const std::string dot = " cx=\"" + px(cx) + "\" cy=\"" + px(cy) + "\" r=\"";
  if (p.chosen) out += "<circle class=\"cq\"" + dot + px(radius + 4) + "\"/>\n";
  const std::string title = "<title>" + escaped(p.title) + "</title>";
  if (!p.square) return out + "<circle class=\"" + css + "\"" + dot + px(radius) + "\">" + title + "</circle>\n";
  return out + "<rect class=\"" + css + "\" x=\"" + px(cx - radius) + "\" y=\"" + px(cy - radius) + "\" width=\"" + px(2 * radius) +
         "\" height=\"" + px(2 * radius) + "\">" + title + "</rect>\n";
}

/// The names of the series, each beside its last point, where it hides neither dots nor the name of the limit. Those on
/// the front choose first; others that have no room are left out.
std::string seriesNames(const ScatterLayout& layout, const ScatterChart& chart) {
  std::vector<Box> taken;
  for (const ChartPoint& p : layout.points) {
    const double reach = dotRadius(p) + 1, cx = layout.x.at(p.x), cy = layout.placeOf(p);
    taken.push_back({cx - reach, cy - reach, cx + reach, cy + reach});
  }
  if (layout.has_limit) {
    const double at = layout.y.at(chart.limit->y), wide = kLetter * static_cast<double>(chart.limit->label.size());
    taken.push_back({layout.x.place1 - wide, at - 16, layout.x.place1, at + 2});
  }
  Labels labels({layout.x.place0, kTop, kWidth - 4, layout.y.place0}, std::move(taken));
  std::string out;
  const auto place = [&](const std::string& name, const std::vector<std::size_t>& members, bool strong) {
    const ChartPoint& last = layout.points[members.back()];
    const std::string label = last.y > layout.y.to ? name + " at " + shortNumber(last.y) : name;
    out += labels.place(layout.x.at(last.x), layout.placeOf(last), dotRadius(last), label, strong);
  };
  for (const bool strong : {true, false})
    for (const auto& [name, members] : layout.series)
      if (!name.empty() && std::any_of(members.begin(), members.end(), [&](std::size_t i) { return layout.on_front[i]; }) == strong)
        place(name, members, strong);
  return out;
}

struct TraceAxes {
  Axis x, y;
};

/// Axes that fit the curves and the limit in a chart of this width, below `top`; none if there is nothing to show.
std::optional<TraceAxes> traceAxes(const TraceChart& chart, double width, double top) {
  double smallest = std::numeric_limits<double>::infinity(), largest = -smallest;
  for (const Trace& trace : chart.traces)
    for (const float value : trace.y)
      if (std::isfinite(value) && (!chart.log_y || value > 0))
        smallest = std::min<double>(smallest, value), largest = std::max<double>(largest, value);
  if (chart.x.empty() || !(largest >= smallest)) return std::nullopt;
  if (chart.limit) smallest = std::min(smallest, chart.limit->y), largest = std::max(largest, chart.limit->y);
  if (chart.log_y) smallest = std::max(smallest, largest * 1e-6);
  const double clear = chart.log_y ? 0 : 0.05 * (largest - smallest);  // between the curves and the frame
  if (smallest != 0) smallest -= clear;
  largest += clear;
  const double bottom = top + kTraceHeight - kBottom - kTop;
  constexpr double kTickWidth = 75;  // about, of the x axis [px]
  const Axis y = chart.log_y ? logAxis(smallest, largest, bottom, top)
                             : linearAxis(smallest > 0 && smallest < 0.5 * largest ? 0 : smallest, largest, bottom, top, 5);
  const double left = leftOf(y), right = width - kTraceRight;
  return TraceAxes{linearAxis(chart.x.front(), chart.x.back(), left, right, static_cast<int>((right - left) / kTickWidth)), y};
}

struct TracePath {
  std::string path;
  double last;  // height of the last value [px]
};

/// The curve, with one vertical line from the smallest to the largest value for each column of pixels.
TracePath tracePath(const Trace& trace, const TraceChart& chart, const TraceAxes& axes) {
  const double left = axes.x.place0, right = axes.x.place1, bottom = axes.y.place0, top = axes.y.place1;
  const auto columns = static_cast<std::size_t>(right - left) + 1;
  std::vector<float> low(columns, std::numeric_limits<float>::infinity()), high(columns, -std::numeric_limits<float>::infinity());
  TracePath out{{}, bottom};
  for (std::size_t i = 0; i < trace.y.size() && i < chart.x.size(); ++i) {
    if (!std::isfinite(trace.y[i]) || (chart.log_y && !(trace.y[i] > 0))) continue;
    const auto column = static_cast<std::size_t>(std::clamp(axes.x.at(chart.x[i]) - left, 0.0, right - left));
    low[column] = std::min(low[column], trace.y[i]), high[column] = std::max(high[column], trace.y[i]);
    out.last = axes.y.at(trace.y[i]);
  }
  bool pen_down = false;
  const bool sparse = trace.y.size() < columns;  // then columns without a value are not gaps
  for (std::size_t c = 0; c < columns; ++c) {
    if (!(high[c] >= low[c])) {
      pen_down = pen_down && sparse;
      continue;
    }
    const double at = left + static_cast<double>(c);
    const auto limited = [&](float value) {
      return std::clamp(axes.y.at(std::max<double>(value, chart.log_y ? axes.y.from : value)), top, bottom);
    };
    out.path += (pen_down ? "L" : "M") + px(at) + " " + px(limited(high[c]));
    if (limited(low[c]) - limited(high[c]) > 0.3) out.path += "V" + px(limited(low[c]));
    pen_down = true;
  }
  return out;
}

}  // namespace

std::string_view chartStyle() {
  return ".chart{--cs:#fff;--ci:#1b1f24;--cm:#5b6470;--cg:#e3e6ea;--cc:#0b62c4;--cr:#b4431b;--c0:#0b62c4;--c1:#b4431b;--c2:#2f7d32;"
         "--c3:#7a4fb3;font:11px system-ui,-apple-system,'Segoe UI',sans-serif;max-width:100%;height:auto;background:var(--cs)}"
         "@media screen and (prefers-color-scheme:dark){.chart{--cs:#15181c;--ci:#eceff3;--cm:#a2abb6;--cg:#2b3138;--cc:#6cb0ff;"
         "--cr:#ff9a6b;--c0:#6cb0ff;--c1:#ff9a6b;--c2:#7fcf82;--c3:#c3a1f2}}"
         ".cb{fill:var(--cs)}.ct{fill:var(--ci);font-weight:600;font-size:12.5px}.ch{fill:var(--ci);font-weight:600;font-size:15px}"
         ".ck,.cl{fill:var(--cm)}.cn{fill:var(--ci);stroke:var(--cs);stroke-width:3px;paint-order:stroke;stroke-linejoin:round}"
         ".cs{font-weight:700;fill:var(--cc)}.cg{stroke:var(--cg)}.ca{stroke:var(--cm)}.cd{stroke:var(--cm);stroke-width:.7}"
         ".cf{fill:none;stroke:var(--cc);stroke-width:1.5;stroke-opacity:.55}.cj{fill:none;stroke:var(--cm);stroke-width:1;stroke-opacity:."
         "6}"
         ".cp{fill:var(--cs);stroke:var(--cm);stroke-width:1.4}.co{fill:var(--cc);stroke:var(--cc);stroke-width:1.4}"
         ".cq{fill:none;stroke:var(--cr);stroke-width:2}.cx{stroke:var(--cr);stroke-dasharray:5 4}.cy{fill:var(--cr)}"
         ".t0,.t1,.t2,.t3{fill:none;stroke-width:1.1;stroke:var(--c0)}.t1{stroke:var(--c1)}.t2{stroke:var(--c2)}.t3{stroke:var(--c3)}"
         ".n0,.n1,.n2,.n3{fill:var(--c0);font-weight:600}.n1{fill:var(--c1)}.n2{fill:var(--c2)}.n3{fill:var(--c3)}";
}

std::string shortNumber(double value) {
  char out[32];
  if (value != 0 && (std::abs(value) < 1e-4 || std::abs(value) >= 1e6)) {
    std::snprintf(out, sizeof out, "%.2g", value);
  } else {
    const int digits = value == 0 ? 0 : 2 - static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
    std::snprintf(out, sizeof out, "%.*f", std::clamp(digits, 0, 6), value);
    std::string plain = out;
    if (plain.find('.') != std::string::npos) {
      while (plain.back() == '0') plain.pop_back();
      if (plain.back() == '.') plain.pop_back();
    }
    return plain == "-0" ? "0" : plain;
  }
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::vector<bool> paretoFront(std::span<const ChartPoint> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].x != points[b].x ? points[a].x < points[b].x : points[a].y < points[b].y;
  });
  std::vector<bool> front(points.size(), false);
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order)
    if (points[i].y < best) best = points[i].y, front[i] = true;
  return front;
}

std::string scatterSvg(const ScatterChart& chart) {
  const ScatterLayout layout = scatterLayout(chart);
  if (layout.points.empty())
    return wrapped(kWidth, kHeight, chart.title, text("ct", kLeft, 18, "start", chart.title + ": nothing to show"));
  const Axis &x = layout.x, &y = layout.y;
  std::string out = frame({chart.title}, chart.x_label, chart.y_label, x, y);
  if (layout.has_limit) {
    out += line("cx", x.place0, y.at(chart.limit->y), x.place1, y.at(chart.limit->y));
    out += text("ck cy", x.place1, y.at(chart.limit->y) - 5, "end", chart.limit->label);
  }
  out += scatterLines(layout);
  for (std::size_t i = 0; i < layout.points.size(); ++i) out += dotSvg(layout, i);
  return wrapped(kWidth, kHeight, chart.title, out + seriesNames(layout, chart));
}

std::string traceSvg(const TraceChart& chart, TraceSize size) {
  const double width = size == TraceSize::Broad ? kTraceWidth : kNarrowTraceWidth;
  const std::string css = size == TraceSize::Broad ? "chart broad" : "chart narrow";
  std::vector<std::string> title = titleLines(chart.title, width - kLeft);
  if (title.size() > 1) title = titleLines(chart.title, width - 16);  // they begin at the edge
  const double top = kTop + kTitleLine * static_cast<double>(title.size() - 1);
  const std::optional<TraceAxes> axes = traceAxes(chart, width, top);
  if (!axes) return wrapped(width, 40, chart.title, text("ct", 8, 18, "start", chart.title + ": nothing to show"), css);
  const Axis &x = axes->x, &y = axes->y;
  const double right = x.place1, bottom = y.place0;

  std::string out = frame(title, chart.x_label, chart.y_label, x, y);
  std::vector<double> name_at;
  for (std::size_t t = 0; t < chart.traces.size(); ++t) {
    auto [path, last] = tracePath(chart.traces[t], chart, *axes);
    const std::string index = std::to_string(t % 4);
    out += "<path class=\"t" + index + "\" d=\"" + path + "\"/>\n";
    for (int round = 0; round < 8; ++round)
      for (const double other : name_at)
        if (std::abs(last - other) < 13) last = other + (last < other || other + 13 > bottom ? -13 : 13);
    name_at.push_back(last);
    out += text(("n" + index).c_str(), right + 6, std::clamp(last, top, bottom) + 4, "start", chart.traces[t].name);
  }
  if (chart.limit && y.from <= chart.limit->y && chart.limit->y <= y.to) {
    out += line("cx", x.place0, y.at(chart.limit->y), x.place1, y.at(chart.limit->y));
    out += text("ck cy", x.place0 + 4, y.at(chart.limit->y) - 4, "start", chart.limit->label);
  }
  return wrapped(width, bottom + kBottom, chart.title, out, css);
}

std::string traceCharts(const TraceChart& chart) { return traceSvg(chart, TraceSize::Broad) + traceSvg(chart, TraceSize::Narrow); }

namespace {

// The style of the charts in its light colours, without variables, which many programs for drawings do not know, and
// without the size on a page.
std::string plainStyle() {
  std::string style(chartStyle());
  const std::size_t dark = style.find("@media");
  style.erase(dark, style.find("}}", dark) + 2 - dark);
  constexpr std::string_view kSize = "max-width:100%;height:auto;";
  style.erase(style.find(kSize), kSize.size());
  while (true) {
    const std::size_t name = style.find("--"), colon = style.find(':', name), end = style.find(';', name);
    if (name == std::string::npos || style[name - 1] == '(') return style;
    const std::string use = "var(" + style.substr(name, colon - name) + ")", colour = style.substr(colon + 1, end - colon - 1);
    style.erase(name, end + 1 - name);
    for (std::size_t at = style.find(use); at != std::string::npos; at = style.find(use, at)) style.replace(at, use.size(), colour);
  }
}

}  // namespace

std::string svgFile(const std::string& heading, std::span<const std::string> charts) {
  const double width = kWidth * static_cast<double>(charts.size()), height = kHeight + 34;
  std::string out = "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(width) + "\" height=\"" + px(height) +
                    "\" viewBox=\"0 0 " + px(width) + " " + px(height) + "\">\n<title>" + escaped(heading) + "</title>\n<style>" +
                    plainStyle() + "</style>\n<rect class=\"cb\" width=\"100%\" height=\"100%\"/>\n" + text("ch", 16, 24, "start", heading);
  for (std::size_t i = 0; i < charts.size(); ++i)
    out += "<g transform=\"translate(" + px(kWidth * static_cast<double>(i)) + " 34)\">" + charts[i] + "</g>\n";
  return out + "</svg>\n";
}

}  // namespace spheretree::tool
