// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>

#include "comparison/comparison.h"
#include "page/chart.h"
#include "page/page.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::player {
namespace {

using tool::escaped;
using tool::shortNumber;

constexpr double kFloor = 1e-5;  // smallest value on a logarithmic axis [mm, N]

std::string title(Mode mode) { return std::string(name(mode)) + (mode == Mode::Constrained ? " (this project)" : ""); }

/// Geometric means over the bodies, for each renderer and size.
std::string rendererChart(std::span<const ComparisonRow> rows, const std::string& heading, const std::string& label,
                          double ComparisonRow::*figure) {
  struct Sum {
    double time = 0, value = 0;
    int count = 0;
  };
  std::map<std::pair<Mode, std::size_t>, Sum> sums;
  for (const ComparisonRow& row : rows) {
    if (row.on_leaves || row.leaves < 64) continue;
    Sum& sum = sums[{row.mode, row.leaves}];
    sum.time += std::log(std::max(row.step_p99, 1e-3));
    sum.value += std::log(std::max(row.*figure, kFloor));
    ++sum.count;
  }
  tool::ScatterChart scatter{heading, "processor time of a step, 99th percentile [us]", label, {}, {}, true};
  for (const auto& [key, sum] : sums) {
    const double time = std::exp(sum.time / sum.count), value = std::exp(sum.value / sum.count);
    scatter.points.push_back(
        {time, value, std::string(name(key.first)),
         title(key.first) + ", memory of " + std::to_string(key.second) + " leaves: " + shortNumber(time) + " us, " + shortNumber(value),
         key.second < 500    ? 0
         : key.second < 4000 ? 1
                             : 2,
         key.first == Mode::Constrained && key.second == 512});
  }
  return tool::scatterSvg(scatter);
}

/// The constrained mode on the skin and on leaves: a dot for each body and size.
std::string surfaceChart(std::span<const ComparisonRow> rows, const std::string& heading, const std::string& label,
                         double ComparisonRow::*figure) {
  tool::ScatterChart scatter{heading, "processor time of a step, 99th percentile [us]", label, {}, {}, false};
  for (const bool on_leaves : {false, true})
    for (const ComparisonRow& first : rows) {
      if (first.mode != Mode::Constrained || first.leaves != 8 || first.on_leaves != on_leaves) continue;
      const std::string series = first.body + (on_leaves ? ", leaves" : ", skin");
      for (const ComparisonRow& row : rows) {
        if (row.mode != Mode::Constrained || row.on_leaves != on_leaves || row.body != first.body) continue;
        const double value = std::max(row.*figure, kFloor);
        scatter.points.push_back(
            {row.step_p99, value, series,
             series + ", tree of " + std::to_string(row.leaves) + " leaves: " + shortNumber(row.step_p99) + " us, " + shortNumber(value),
             row.leaves < 500    ? 0
             : row.leaves < 4000 ? 1
                                 : 2,
             false});
      }
    }
  return tool::scatterSvg(scatter);
}

std::string rowsTable(std::span<const ComparisonRow> rows) {
  tool::HtmlTable table{
      "Force error: against the exact answer for a ball. Penetration: of the ball into the mesh.",
      {"Renderer", "Body", "Leaves", "Memory [KB]", "Step, median [us]", "Step, p99 [us]", "Force error, median [N]",
       "Force error, p99 [N]", "Angle, median [degree]", "Angle, p99 [degree]", "Penetration, p99 [mm]", "Stand-off, p99 [mm]"},
      {}};
  for (const ComparisonRow& r : rows)
    table.rows.push_back({escaped(title(r.mode)) + (r.on_leaves ? ", on leaves" : ""), r.body, std::to_string(r.leaves),
                          shortNumber(static_cast<double>(r.bytes) / 1000), shortNumber(r.step_median), shortNumber(r.step_p99),
                          shortNumber(r.force_error), shortNumber(r.force_error_p99), shortNumber(r.angle), shortNumber(r.angle_p99),
                          shortNumber(r.penetration), shortNumber(r.stand_off_p99)});
  return table.html();
}

std::string scenarioTable(std::span<const ScenarioResult> scenarios, std::span<const Mode> modes) {
  tool::HtmlTable table{
      "\u2713 every figure is reached; \u2717 with the number of figures that are missed; \u2013 asks our own runtime or builder.",
      {"Scenario"},
      {}};
  for (const Mode mode : modes) table.heads.emplace_back(name(mode));
  for (const ScenarioResult& r : scenarios) {
    std::vector<std::string> cells{escaped(r.scenario->id + " " + r.scenario->title)};
    for (const Mode mode : modes) {
      const auto found = r.outcomes.find(mode);
      if (found == r.outcomes.end()) {
        cells.emplace_back("\u2013");
        continue;
      }
      const auto& figures = found->second.figures;
      const auto missed = std::count_if(figures.begin(), figures.end(), [](const Figure& f) { return !holds(f); });
      cells.push_back(missed == 0 ? "<span class=\"good\">\u2713</span>"
                                  : "<span class=\"bad\">\u2717 " + std::to_string(missed) + "</span>");
    }
    table.rows.push_back(std::move(cells));
  }
  return table.html();
}

std::string verdict(std::span<const ScenarioResult> scenarios, std::span<const Mode> modes) {
  std::string text = "<p>";
  for (const Mode mode : modes) {
    std::size_t asked = 0, held = 0;
    for (const ScenarioResult& r : scenarios)
      if (const auto found = r.outcomes.find(mode); found != r.outcomes.end()) ++asked, held += holds(found->second);
    text += (mode == modes.front() ? "" : " \u00b7 ") + escaped(title(mode)) + ": <b>" + std::to_string(held) + " of " +
            std::to_string(asked) + "</b> scenarios hold";
  }
  return text + "</p>";
}

constexpr const char* kVoxels =
    "<li><b>voxels</b>: a burr that spins empties voxels that it touches, 1 to 10 in a step by its size, whatever the force and the "
    "material; the balls of the tool are god-objects, the force is that of the one that is held back farthest, without torque (the rule of "
    "AMBF's volumetric_drilling, Munawar et al. 2022).</li>";

constexpr const char* kMethods =
    "<li><b>points</b>: point shell of the tool against a distance field with tricubic interpolation, penalty of 10 times the "
    "coupling's stiffness "
    "at each point, static virtual coupling (McNeely et al. 1999; Barbi\u010d and James 2008).</li>"
    "<li><b>volume</b>: inner spheres, penalty of 300 times the coupling's stiffness for each mm\u00b3 of common volume, static virtual "
    "coupling "
    "(Weller and Zachmann 2009).</li><li><b>continuous</b>: the same points and field, time of impact and constraints (Xu and Barbi\u010d "
    "2017).</li>";

constexpr const char* kConditions =
    "<p>All but voxels have the memory of our compiled scene: of it a quarter in points and the rest in the field, or inner spheres in "
    "equal numbers. "
    "The hand follows "
    "the same path at 20 mm/s, 0.5 mm below where a ball of 1 mm would rest.</p>";

}  // namespace

void writeCuttingPage(const std::filesystem::path& out, std::span<const CuttingRow> cutting, double edge) {
  tool::Page page("Cutting side by side", "<p>Our constrained mode and voxels of " + shortNumber(edge) + " mm follow the same hand.</p>");
  page.addSection("cutting", "Cutting", cuttingSection(cutting));
  page.addSection("methods", "Methods and settings", std::string("<ul>") + kVoxels + "</ul>");
  formats::writeWhole(out, page.html({}));
}

void writeToolPage(const std::filesystem::path& out, std::span<const ToolRow> rows, double depth) {
  tool::Page page(
      "How much model a tool needs",
      "<p>Tools of 8 to 4,096 leaves and of hulls follow the same hand, " + shortNumber(depth) +
          " mm below where the tool would touch, at 10 mm/s with a tremor of 0.05 mm at 9 Hz; the tool is tilted by 35 degrees.</p>");
  page.addSection("tools", "Speed against accuracy", toolSection(rows));
  page.addSection(
      "exact", "The exact answer",
      "<p>For the meshes of tool and body: the pose of least energy that is reached without penetration, from exact distances of "
      "points 0.1 and 0.2 mm apart. The objects are felt as the smooth surface through their mesh, so that a coarse mesh adds "
      "to the angle.</p>");
  formats::writeWhole(out, page.html({}));
}

void writeComparison(const std::filesystem::path& out, std::span<const ComparisonRow> rows, std::span<const CuttingRow> cutting,
                     std::span<const ScenarioResult> scenarios, std::span<const Mode> modes) {
  tool::Page page("Renderers side by side", verdict(scenarios, modes));
  page.addSection("charts", "Speed against accuracy",
                  "<p>Lower left is better. Geometric means over an edge, a groove, a bowl and a molar. Small, medium and large dots: the "
                  "memory of our "
                  "trees of 64, 512 and 4,096 leaves.</p><div class=\"charts\">" +
                      rendererChart(rows, "What is felt", "force error, 99th percentile [N]", &ComparisonRow::force_error_p99) +
                      rendererChart(rows, "How deep the tool goes in", "penetration, 99th percentile [mm]", &ComparisonRow::penetration) +
                      "</div>");
  const bool has_surfaces = std::any_of(rows.begin(), rows.end(), [](const ComparisonRow& r) { return r.on_leaves; });
  if (has_surfaces)
    page.addSection(
        "skin", "On the skin and on leaves",
        "<p>The constrained mode, with trees of 8, 64, 512 and 4,096 leaves (dots that grow). On the skin the leaves only find; "
        "without it they are what is felt.</p><div class=\"charts\">" +
            surfaceChart(rows, "Where the force points", "angle off the exact force, 99th percentile [degree]", &ComparisonRow::angle_p99) +
            surfaceChart(rows, "Where the ball rests", "stand-off from the mesh, 99th percentile [mm]", &ComparisonRow::stand_off_p99) +
            "</div>");
  page.addSection("cutting", "Cutting",
                  "<p>A burr of 1 mm is led into a block at a constant feed; voxels of " + shortNumber(kVoxelEdge) + " mm.</p>" +
                      cuttingSection(cutting));
  page.addSection("scenarios", "Stability scenarios", scenarioTable(scenarios, modes));
  page.addSection("methods", "Methods and settings", std::string("<ul>") + kMethods + kVoxels + "</ul>" + kConditions);
  page.addSection("figures", "All figures", rowsTable(rows));
  formats::writeWhole(out, page.html({}));
}

}  // namespace spheretree::player
