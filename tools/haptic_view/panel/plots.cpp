// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/plots.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "panel/interface.h"

namespace spheretree::view {
namespace {

struct Axis {
  double low, high;
};

Axis axisOf(const Plot& plot, double begin, double end) {
  double low = 0, high = 0;
  for (const Curve& curve : plot.curves)
    for (const PlotSample& s : curve.samples) {
      if (s.time < begin || s.time > end) continue;
      const auto value = static_cast<double>(curve.value(s));
      low = std::min(low, value);
      high = std::max(high, value);
    }
  // A limit appears when the curve comes near it; values far beyond it are cut off, so that one bad step does not
  // flatten the others.
  if (plot.limit && high > 0.6 * *plot.limit) high = std::clamp(high, *plot.limit * 1.05, *plot.limit * 2);
  if (plot.from_zero) return {0, roundEnd(std::max(high, plot.min_span))};
  const double half = roundEnd(std::max({high, -low, plot.min_span}));
  return {-half, half};
}

std::string shortNumber(double value) {
  char text[24];
  std::snprintf(text, sizeof text, value >= 1000 ? "%.0f" : "%.3g", value);
  return text;
}

void drawCurve(ImDrawList& list, const Curve& curve, const Axis& axis, double begin, double end, ImVec2 low_left, float width,
               float height) {
  const int columns = std::max(1, static_cast<int>(width));
  const std::vector<Column> found = columnsOf(curve, begin, end, columns);
  const auto y = [&](float value) {
    const double share = (static_cast<double>(value) - axis.low) / (axis.high - axis.low);
    return low_left.y - height * static_cast<float>(std::clamp(share, 0.0, 1.0));
  };
  const unsigned colour = packed(curve.colour);
  std::vector<ImVec2> points;
  for (int x = 0; x < columns; ++x) {
    const Column& c = found[static_cast<std::size_t>(x)];
    if (c.is_empty) continue;
    const float at = low_left.x + static_cast<float>(x) + 0.5f;
    points.push_back({at, y(c.low)});
    if (c.high > c.low) points.push_back({at, y(c.high)});
  }
  if (points.size() > 1)
    list.AddPolyline(points.data(), static_cast<int>(points.size()), colour, 0, std::max(1.2f, ImGui::GetFontSize() / 11));
}

}  // namespace

std::vector<Column> columnsOf(const Curve& curve, double begin, double end, int columns) {
  std::vector<Column> out(static_cast<std::size_t>(columns));
  if (!(end > begin)) return out;
  for (const PlotSample& s : curve.samples) {
    if (s.time < begin || s.time > end) continue;
    const auto at = std::min(static_cast<std::size_t>((s.time - begin) / (end - begin) * columns), out.size() - 1);
    const float value = curve.value(s);
    Column& c = out[at];
    c.low = c.is_empty ? value : std::min(c.low, value);
    c.high = c.is_empty ? value : std::max(c.high, value);
    c.is_empty = false;
  }
  return out;
}

double roundEnd(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0})
    if (value <= step * power * 1.0000001) return step * power;
  return 10 * power;
}

std::vector<Plot> plotsOf(std::span<const PlotSample> run, std::span<const PlotSample> other, const Theme& theme,
                          const std::vector<std::optional<double>>& limits) {
  const auto norm = [](const float* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); };
  const auto both = [&](std::function<float(const PlotSample&)> value, Colour colour) {
    std::vector<Curve> curves;
    if (!other.empty()) curves.push_back({other, value, theme.faint, "B"});
    curves.push_back({run, value, colour, other.empty() ? "" : "A"});
    return curves;
  };
  std::vector<Plot> plots{{"Force", "N", both([norm](const PlotSample& s) { return norm(s.force); }, theme.force), true, 0.5, {}},
                          {"Components", "N", {}, false, 0.5, {}},
                          {"Torque", "N mm", both([norm](const PlotSample& s) { return norm(s.torque); }, theme.torque), true, 5, {}},
                          {"Pressed in", "mm", both([](const PlotSample& s) { return s.depth; }, theme.spring), true, 0.1, {}},
                          {"Step time", "us", both([](const PlotSample& s) { return s.step_us; }, theme.good), true, 20, {}}};
  const Colour axes[3] = {theme.bad, theme.good, theme.spring};
  const char* names[3] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) plots[1].curves.push_back({run, [k](const PlotSample& s) { return s.force[k]; }, axes[k], names[k]});
  for (std::size_t k = 0; k < std::min(limits.size(), plots.size()); ++k) plots[k].limit = limits[k];
  return plots;
}

void drawPlot(const Plot& plot, double begin, double end, std::optional<double> mark, float width, float height, const Theme& theme) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float text = ImGui::GetFontSize(), margin = 0.35f * text;
  const Axis axis = axisOf(plot, begin, end);
  const ImVec2 low_left{corner.x + margin, corner.y + height - margin};
  const float wide = width - 2 * margin, high = height - text - 2.5f * margin;
  const auto y = [&](double v) { return low_left.y - high * static_cast<float>((v - axis.low) / (axis.high - axis.low)); };
  list.AddRectFilled(corner, {corner.x + width, corner.y + height}, packed(theme.line, 0.22), margin);
  list.PushClipRect(corner, {corner.x + width, corner.y + height}, true);
  for (const double v : {axis.low, (axis.low + axis.high) / 2, axis.high})
    list.AddLine({low_left.x, y(v)}, {low_left.x + wide, y(v)}, packed(theme.line, v == 0 ? 1.0 : 0.6));
  if (plot.limit && *plot.limit <= axis.high)
    for (float x = 0; x < wide; x += 2 * margin)
      list.AddLine({low_left.x + x, y(*plot.limit)}, {low_left.x + std::min(wide, x + margin), y(*plot.limit)}, packed(theme.warning),
                   1.5f);
  for (const Curve& curve : plot.curves) drawCurve(list, curve, axis, begin, end, low_left, wide, high);
  if (mark && *mark >= begin && *mark <= end) {
    const float x = low_left.x + wide * static_cast<float>((*mark - begin) / std::max(1e-9, end - begin));
    list.AddLine({x, low_left.y - high}, {x, low_left.y}, packed(theme.text, 0.8), 1.5f);
  }
  // The title comes first; unit, number and legend are shown if there is space.
  const auto wide_of = [](const std::string& words) { return ImGui::CalcTextSize(words.c_str()).x; };
  const std::string top = shortNumber(axis.high), title = plot.title + " [" + plot.unit + "]";
  const float inside = width - 2 * margin, number_width = wide_of(top) + 2 * margin;
  const bool has_unit = wide_of(title) + number_width < inside, has_number = has_unit || wide_of(plot.title) + number_width < inside;
  const float end_at = corner.x + width - margin - (has_number ? wide_of(top) : 0);
  if (has_number) list.AddText({end_at, corner.y + margin}, packed(theme.faint), top.c_str());
  float at = corner.x + margin;
  const auto write = [&](const std::string& words, Colour colour) {
    if (at + wide_of(words) + margin > end_at && at > corner.x + margin) return;  // no space
    list.AddText({at, corner.y + margin}, packed(colour), words.c_str());
    at += wide_of(words) + margin;
  };
  write(has_unit ? title : plot.title, theme.text);
  at += margin;
  for (const Curve& curve : plot.curves) write(curve.name, curve.colour);
  list.PopClipRect();
  ImGui::Dummy({width, height});
}

}  // namespace spheretree::view
