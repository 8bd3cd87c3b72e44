// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/grade_page.h"

#include <algorithm>
#include <cmath>

#include "page/chart.h"
#include "page/page.h"
#include "page/report_page.h"

namespace spheretree::tool {
namespace {

builder::VolumeBounds inPercent(const builder::VolumeBounds& share) { return {100 * share.low, 100 * share.high}; }

std::string distanceText(const std::optional<builder::CutDistance>& distance) {
  if (!distance) return "\u2013";
  if (!distance->high) return "at least " + boundsText({distance->low, distance->low});
  return *distance->high == 0 ? "reached" : boundsText({distance->low, *distance->high});
}

std::string layerTable(const pipeline::GradedObject& object) {
  HtmlTable table{"Layers of " + object.name + ", the outermost first. The true value lies between the two numbers.",
                  {"Layer", "Removed [mm\u00b3]", "Left [%]", "Volume before [mm\u00b3]", "Distance of the cut [mm]"},
                  {}};
  for (const pipeline::GradedLayer& layer : object.layers)
    table.rows.push_back({escaped(layer.name), boundsText(layer.removed), boundsText(inPercent(layer.left())), boundsText(layer.volume),
                          distanceText(layer.distance)});
  return table.html();
}

std::string boxes(const pipeline::GradedObject& object) {
  std::vector<std::pair<std::string, std::string>> all{{"Removed", boundsText(object.removed) + " mm\u00b3"}};
  if (object.lesion) {
    const pipeline::GradedLayer& lesion = object.layers[*object.lesion];
    all.emplace_back("Left of " + lesion.name, boundsText(inPercent(lesion.left())) + " %");
    all.emplace_back("Removed outside of " + lesion.name, boundsText(object.outsideLesion()) + " mm\u00b3");
  }
  if (object.layers.size() > 1)
    all.emplace_back("From the cut to " + object.layers.back().name,
                     distanceText(object.layers.back().distance) + (object.layers.back().distance ? " mm" : ""));
  return figureBoxes(all);
}

}  // namespace

std::string boundsText(const builder::VolumeBounds& bounds) {
  // Two digits of the width; an exact value has four decimals.
  const int digits = bounds.width() > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(bounds.width()))), 0, 6) : 4;
  const double unit = std::pow(10.0, -digits);
  char text[80];
  const double low = std::max(0.0, std::floor(bounds.low / unit) * unit), high = std::ceil(bounds.high / unit) * unit;
  if (bounds.width() == 0)
    std::snprintf(text, sizeof text, "%.*f", digits, bounds.low);
  else
    std::snprintf(text, sizeof text, "%.*f to %.*f", digits, low, digits, high);
  return text;
}

std::string gradePage(const pipeline::CutRun& run, const std::vector<pipeline::GradedObject>& objects, const std::string& recording) {
  Page page("Cut of " + recording,
            "<p>The burr spun in <b>" + std::to_string(run.spinning) + "</b> of " + std::to_string(run.steps) +
                " steps. Every figure is a pair of bounds between which the true value lies: of the space that the burr swept, exactly, " +
                "as the recording has its path. The page states figures and judges nothing.</p>");
  for (std::size_t i = 0; i < objects.size(); ++i)
    page.addSection("object" + std::to_string(i), objects[i].name, boxes(objects[i]) + layerTable(objects[i]));
  if (!run.notes.empty()) {
    std::string list = "<ul>";
    for (const std::string& note : run.notes) list += "<li>" + escaped(note) + "</li>";
    page.addSection("notes", "Repaired meshes", list + "</ul>");
  }
  return page.html({});
}

}  // namespace spheretree::tool
