// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a robot: its spheres in 3D, beside the figures of each link.
#include <algorithm>
#include <array>

#include "page/chart.h"
#include "page/embedded.h"
#include "page/report_page.h"
#include "page/scene_view.h"
#include "pipeline/evaluation_json.h"
#include "robot/files/robot_files.h"
#include "robot/files/sphere_file.h"
#include "robot/robot_input.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/repair_mesh.h"

namespace spheretree::tool {
namespace {

/// A link with its spheres, measured against its shapes.
struct MeasuredLink {
  std::string name;
  bool is_clipped = false;
  double bound_mm = 0;  // proven overhang
  Eigen::Isometry3d pose;
  ShownMesh mesh;
  SphereTree spheres;
  builder::LevelEvaluation level;
};

std::vector<MeasuredLink> measuredLinks(const robot::RobotManifest& manifest, builder::Progress& progress) {
  const auto [robot, shapes] = robot::readRobot(manifest.input, progress);
  const robot::SphereFile file = robot::readSphereFile(manifest.spheres);
  const std::vector<Eigen::Isometry3d> pose = robot::zeroPose(robot);
  std::vector<MeasuredLink> out;
  for (const auto elements : robot::linksOf(shapes)) {
    const std::size_t l = elements.front().link;
    MeasuredLink& link = out.emplace_back();
    link.name = robot.links[l].name;
    progress.stage(link.name);
    for (const Json& figures : manifest.figures.at("links"))
      if (figures.at("link") == link.name) {
        link.is_clipped = figures.at("clipped").get<bool>();
        link.bound_mm = figures.at("overhang_bound_mm").get<double>();
      }
    link.pose = pose[l];
    builder::RepairedMesh repaired = builder::repairMesh(robot::meshOf(elements), builder::RepairKind::Auto, progress);
    link.spheres = robot::levelOf(robot::setOf(file, manifest.spheres, link.name));
    link.level = builder::evaluateTree(repaired.mesh, link.spheres, {}, progress, repaired.to_cover).levels.back();
    link.mesh = {std::move(repaired.mesh), std::move(repaired.to_cover)};
  }
  return out;
}

Json sceneOf(const std::vector<MeasuredLink>& links, const std::string& name, ModelStore& models) {
  Json scene{{"name", name}, {"objects", Json::array()}, {"replays", Json::array()}};
  for (const MeasuredLink& link : links) {
    models.add(link.name, link.spheres, &link.mesh);
    const Eigen::Vector3d p = link.pose.translation();
    const Eigen::Quaterniond q(link.pose.linear());
    scene["objects"].push_back({{"name", link.name},
                                {"model", link.name},
                                {"position_mm", {p.x(), p.y(), p.z()}},
                                {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                                {"levels", Json::array({pipeline::levelJson(link.level)})}});
  }
  return scene;
}

std::string linkTable(const std::vector<MeasuredLink>& links) {
  HtmlTable table{
      "Links; overhang: how far the spheres reach out of the link",
      {"Link", "Overhang, proven [mm]", "Spheres", "Overhang, measured [mm]", "99th percentile [mm]", "Uncovered [%]", "Excess volume [%]"},
      {}};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const MeasuredLink& link = links[i];
    const std::string uncovered = shortNumber(100 * link.level.coverage.uncovered_fraction);
    table.rows.push_back({objectButtons(link.name, i) + (link.is_clipped ? " clipped" : ""), shortNumber(link.bound_mm),
                          std::to_string(link.level.spheres), shortNumber(link.level.overhang.max), shortNumber(link.level.overhang.p99),
                          link.level.coverage.uncovered_fraction > 0 ? "<span class=\"bad\">" + uncovered + "</span>" : uncovered,
                          shortNumber(100 * link.level.excess_volume_fraction)});
  }
  return table.html();
}

}  // namespace

Report robotReport(const std::filesystem::path& folder, std::size_t max_bytes, builder::Progress& progress) {
  const std::filesystem::path file = folder / robot::kManifestName;
  const robot::RobotManifest manifest = robot::readManifest(file);
  const std::vector<MeasuredLink> links = measuredLinks(manifest, progress);
  const std::string name = manifest.figures.at("robot").get<std::string>();
  Report out;
  out.figures = {{"schema", "spheretree.robot_report/1"}, {"robot", name}, {"links", Json::array()}};
  std::size_t spheres = 0, bare = 0;
  double bound = 0;
  for (const MeasuredLink& link : links) {
    spheres += link.level.spheres, bare += link.level.coverage.uncovered_fraction > 0;
    bound = std::max(bound, link.bound_mm);
    out.figures["links"].push_back({{"link", link.name},
                                    {"overhang_bound_mm", link.bound_mm},
                                    {"clipped", link.is_clipped},
                                    {"level", pipeline::levelJson(link.level)}});
  }
  const Json& pairs = manifest.figures.at("ignored_pairs");
  out.figures["ignored_pairs"] = pairs;
  const std::size_t ignored =
      pairs.at("adjacent").get<std::size_t>() + pairs.at("always").get<std::size_t>() + pairs.at("never").get<std::size_t>();
  const std::string covered = "<b>" + std::to_string(spheres) + " spheres</b> on " + std::to_string(links.size()) + " links";
  const std::string verdict = bare == 0 ? "<span class=\"good\">Every surface is covered</span> by " + covered
                                        : "<span class=\"bad\">" + std::to_string(bare) + " of " + std::to_string(links.size()) +
                                              (bare == 1 ? " links has" : " links have") + " uncovered surface</span>: " + covered;
  for (const std::size_t triangles : {1500, 600, 200}) {
    progress.check();
    progress.stage("page");
    Page page("Robot " + name, "<p>" + verdict + "; none reaches farther than <b>" + shortNumber(bound) + " mm</b> out of its link.</p>");
    page.data.root["scenes"] = Json::array();
    ModelStore models(page.data, triangles);
    page.data.root["scenes"].push_back(sceneOf(links, name, models));
    page.addSection(
        "view", "In 3D",
        viewSection(false,
                    "All joints are at 0. A name in the table below shows the worst spot of a link; a double click hides what is "
                    "in front."));
    page.addSection("links", "Links",
                    figureBoxes({{"Links", std::to_string(links.size())},
                                 {"Spheres", std::to_string(spheres)},
                                 {"Largest overhang, proven", shortNumber(bound) + " mm"},
                                 {"Pairs of links that need no check", std::to_string(ignored)}}) +
                        linkTable(links));
    out.html = page.html(std::array{embedded::viewScript(), embedded::reportScript()});
    if (out.html.size() <= max_bytes) break;
  }
  return out;
}

}  // namespace spheretree::tool
