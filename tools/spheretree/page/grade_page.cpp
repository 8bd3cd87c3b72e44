// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/grade_page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "page/chart.h"
#include "page/embedded.h"
#include "page/model.h"
#include "page/page.h"
#include "page/report_page.h"

namespace spheretree::tool {
namespace {

// Of layers, from the outermost on, as in the window; told apart by the colour-blind, too.
constexpr std::array<const char*, 6> kLayerColours{"#eee2c8", "#e69f00", "#0072b2", "#cc79a7", "#009e73", "#f0e442"};

builder::VolumeBounds inPercent(const builder::VolumeBounds& share) { return {100 * share.low, 100 * share.high}; }

std::string distanceText(const std::optional<builder::CutDistance>& distance) {
  if (!distance) return "\u2013";
  if (!distance->high) return "at least " + boundsText({distance->low, distance->low});
  return *distance->high == 0 ? "reached" : boundsText({distance->low, *distance->high});
}

/// `button`: number of the first layer in the view; those of which nothing is left have none.
std::string layerTable(const pipeline::GradedObject& object, const std::vector<TriangleMesh>& left, std::size_t& button) {
  HtmlTable table{"Layers of " + object.name + ", the outermost first. The true value lies between the two numbers.",
                  {"Layer", "Removed [mm\u00b3]", "Left [%]", "Volume before [mm\u00b3]", "Distance of the cut [mm]"},
                  {}};
  for (std::size_t k = 0; k < object.layers.size(); ++k) {
    const pipeline::GradedLayer& layer = object.layers[k];
    const std::string head = left[k].triangles.empty() ? escaped(layer.name) : objectButtons(layer.name, button++);
    table.rows.push_back(
        {head, boundsText(layer.removed), boundsText(inPercent(layer.left())), boundsText(layer.volume), distanceText(layer.distance)});
  }
  return table.html();
}

/// A view into what the burr swept of the first object that it cut; null if it cut none. From where it lies in the
/// object, a little to the front.
Json lookAtCut(const pipeline::CutRun& run) {
  constexpr double kDistances = 3;  // of the size of the cut
  for (const pipeline::CutRun::Object& object : run.objects) {
    Eigen::AlignedBox3d whole, cut;
    for (const Eigen::Vector3d& p : object.layers[0].mesh.positions) whole.extend(p);
    for (const builder::BurrPath& path : object.paths)
      for (const Eigen::Vector3d& p : path.centres)
        if (whole.contains(p)) cut.extend(Eigen::AlignedBox3d(p.array() - path.radius, p.array() + path.radius));
    if (cut.isEmpty()) continue;
    const Eigen::Vector3d at = object.pose.position + object.pose.orientation * cut.center();
    const Eigen::Vector3d from = (object.pose.orientation * (cut.center() - whole.center())).normalized() - 0.5 * Eigen::Vector3d::UnitY();
    return {
        {"from", {from.x(), from.y(), from.z()}}, {"at_mm", {at.x(), at.y(), at.z()}}, {"distance_mm", kDistances * cut.diagonal().norm()}};
  }
  return nullptr;
}

/// What is left, in the format of report.js: a body for each layer.
void addView(Page& page, const pipeline::CutRun& run, const std::vector<std::vector<TriangleMesh>>& left) {
  Json scene{{"name", "What is left"}, {"objects", Json::array()}, {"replays", Json::array()}, {"look", lookAtCut(run)}};
  Json& models = page.data.root["models"] = Json::object();
  for (std::size_t i = 0; i < run.objects.size(); ++i)
    for (std::size_t k = 0; k < left[i].size(); ++k) {
      const TriangleMesh& mesh = left[i][k];
      if (mesh.triangles.empty()) continue;
      const Configuration& pose = run.objects[i].pose;
      const std::string name = run.objects[i].layers[k].name, model = run.objects[i].name + "." + name;
      models[model]["mesh"] = packMesh(page.data, mesh, {{}, builder::DistanceField(mesh)}, mesh.triangles.size());
      const Eigen::Vector3d& p = pose.position;
      const Eigen::Quaterniond& q = pose.orientation;
      scene["objects"].push_back({{"name", name},
                                  {"model", model},
                                  {"colour", kLayerColours[k % kLayerColours.size()]},
                                  {"position_mm", {p.x(), p.y(), p.z()}},
                                  {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
    }
  page.data.root["scenes"] = {scene};
  page.addSection("view", "What is left",
                  viewSection(false,
                              "A layer is hidden by the button beside its name in the table, or by a double click. The walls are "
                              "within 0.05 mm; the figures below are exact bounds."));
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

std::string gradePage(const pipeline::CutRun& run, const std::vector<pipeline::GradedObject>& objects,
                      const std::vector<std::vector<TriangleMesh>>& left, const std::string& recording) {
  Page page("Cut of " + recording,
            "<p>The burr spun in <b>" + std::to_string(run.spinning) + "</b> of " + std::to_string(run.steps) +
                " steps. Every figure is a pair of bounds between which the true value lies: of the space that the burr swept, exactly, " +
                "as the recording has its path. The page states figures and judges nothing.</p>");
  addView(page, run, left);
  std::size_t button = 0;
  for (std::size_t i = 0; i < objects.size(); ++i)
    page.addSection("object" + std::to_string(i), objects[i].name, boxes(objects[i]) + layerTable(objects[i], left[i], button));
  if (!run.notes.empty()) {
    std::string list = "<ul>";
    for (const std::string& note : run.notes) list += "<li>" + escaped(note) + "</li>";
    page.addSection("notes", "Repaired meshes", list + "</ul>");
  }
  return page.html(std::array{embedded::viewScript(), embedded::reportScript()});
}

}  // namespace spheretree::tool
