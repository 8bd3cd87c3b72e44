// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/tool_models.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <stdexcept>

#include <tbb/parallel_for.h>

#include "cavity.h"
#include "implicit_surface.h"
#include "molar.h"
#include "page/chart.h"
#include "page/page.h"
#include "probe.h"
#include "quantile.h"
#include "run/real_time.h"
#include "run/run_statistics.h"
#include "spheretree/runtime/step.h"
#include "text_table.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
using tool::shortNumber;

constexpr double kTilt = 35 * std::numbers::pi / 180;     // of the tool's axis from the vertical
constexpr double kSpeed = 0.01;                           // of the hand: 10 mm/s [mm in a step]
constexpr double kTremor = 0.05, kTremorHz = 9;           // [mm]
constexpr double kAbove = 0.3;                            // where the hand begins [mm]
constexpr int kStations = 12;                             // where the height is searched
constexpr double kToolSpacing = 0.1, kBodySpacing = 0.2;  // of the points of ExactTool [mm]

struct Part {
  std::string name;
  std::function<TriangleMesh()> mesh;  // made when it is chosen
  Vector3d reference = Vector3d::Zero();
};

/// The mesh with the middle of its top at the origin.
TriangleMesh topAtOrigin(TriangleMesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  for (Vector3d& p : mesh.positions) p -= Vector3d(box.center().x(), box.center().y(), box.max().z());
  return mesh;
}

/// The surface of revolution of half a circle about z.
TriangleMesh sphere(double radius, int rings) {
  std::vector<Eigen::Vector2d> profile{{0, -radius}};
  for (int i = 1; i < rings; ++i)
    profile.emplace_back(radius * std::sin(std::numbers::pi * i / rings), -radius * std::cos(std::numbers::pi * i / rings));
  profile.emplace_back(0, radius);
  return lathe(profile, static_cast<std::uint32_t>(2 * rings));
}

TriangleMesh turned(TriangleMesh mesh, const Quaternion& turn) {
  for (Vector3d& p : mesh.positions) p = turn * p;
  return mesh;
}

std::vector<Part> benchTools() {
  constexpr double kRim = 0.2;
  std::vector<Eigen::Vector2d> mirror{{0, -0.5}};  // a disc of 4 mm with a round rim
  for (const double z : {-0.5 + kRim, 0.5 - kRim})
    for (int i = 0; i <= 6; ++i) {
      const double a = (z < 0 ? -std::numbers::pi / 2 : 0) + std::numbers::pi / 12 * i;
      mirror.emplace_back(2 - kRim + kRim * std::cos(a), z + kRim * std::sin(a));
    }
  mirror.emplace_back(0, 0.5);
  return {{"ball", [] { return sphere(1, 48); }},
          {"probe", [] { return samples::makeProbe(); }, {0, 0, 15}},
          {"mirror", [mirror] { return lathe(mirror, 128); }},
          {"bur", [] { return samples::makeHandpiece(); }, {0, 0, 15}}};
}

/// Finely meshed, so that the exact answer for the mesh is that for the smooth surface.
std::vector<Part> benchBodies() {
  const Quaternion aside(std::sqrt(0.5), std::sqrt(0.5), 0, 0);  // the poles of the sphere have slivers
  const auto edge = [] {
    TriangleMesh cube = BodyLibrary::mesh("cube");
    for (Vector3d& p : cube.positions) p -= Vector3d(10, 0, 10);
    return cube;
  };
  const auto molar = [] { return samples::polygonise(samples::molarField, {-7, -7, -15}, {7, 7, 10}, 0.22); };
  return {{"sphere", [aside] { return topAtOrigin(turned(sphere(10, 192), aside)); }},
          {"edge", edge},
          {"groove", [] { return BodyLibrary::mesh("groove"); }},
          {"molar", [molar] { return topAtOrigin(molar()); }},
          {"side", [molar, aside] { return topAtOrigin(turned(molar(), aside)); }}};
}

/// Where the hand goes above the body, without its height: from left to right, at an angle to the axes.
Vector3d stationAt(double s, const std::string& body) {
  if (body == "groove") return {0.3 * std::sin(4 * std::numbers::pi * s), 4 * s - 2, 0};
  if (body == "edge") return {s - 1, 4 * s - 2, 0};
  return {4 * s - 2, 1.2 * s - 0.6, 0};
}

std::vector<Configuration> handOver(const SampledSolid& tool, const SampledSolid& body, const Part& held, const std::string& name,
                                    double depth) {
  const Quaternion turn(Eigen::AngleAxisd(kTilt, Vector3d(0.8, 0.6, 0)));
  ToolGaps gaps(tool, body, held.reference);
  double height = gaps.reach() + 1;  // where the tool is surely above the body
  std::vector<Vector3d> path;
  for (int k = 0; k <= kStations; ++k) {
    // The tip of the tool, its lowest point where it stands upright, is above the station.
    Vector3d p = stationAt(static_cast<double>(k) / kStations, name) + turn * held.reference;
    p.z() = height;
    while (gaps.smallest({p, turn}, 0.1) < 0.01) p.z() += 0.5;
    for (double gap = 1; gap > 2e-3; p.z() -= gap > 2e-3 ? gap - 1e-3 : 0) {
      gap = gaps.smallest({p, turn}, 0.1);
      if (p.z() < -2 * gaps.reach() - 10) throw std::logic_error("the tool does not reach the body");
    }
    height = p.z() + 0.2;
    path.push_back(p - Vector3d(0, 0, depth));
  }
  std::vector<Configuration> hand;
  const auto add = [&](const Vector3d& p) {
    const double t = static_cast<double>(hand.size()) / 1000;
    hand.push_back({p + kTremor * std::sin(2 * std::numbers::pi * kTremorHz * t) * Vector3d(0.36, -0.48, 0.8), turn});
  };
  const Vector3d start = path.front() + Vector3d(0, 0, depth + kAbove);
  path.insert(path.begin(), start);
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const int steps = std::max(1, static_cast<int>((path[k + 1] - path[k]).norm() / kSpeed));
    for (int n = 0; n < steps; ++n) add(path[k] + (path[k + 1] - path[k]) * (static_cast<double>(n) / steps));
  }
  return hand;
}

Wrench wrenchOf(const Configuration& tool, const Configuration& hand, const runtime::Coupling& coupling) {
  const Displacement way = displacementBetween(hand, tool);
  return {coupling.translation * way.translation, coupling.rotation * way.rotation};
}

double quantileOf(std::vector<double>& values, double q) { return values.empty() ? 0 : tool::quantile(values, q); }

/// How smoothly the wrench follows the hand in the steps of `tool` that are in contact.
void addRatios(const ToolCourse& course, std::span<const Configuration> tool, std::span<const bool> touches, const runtime::Coupling& k,
               ToolRow& row) {
  std::vector<double> ratios;
  for (std::size_t n = 1; n < tool.size(); ++n) {
    if (!touches[n] || !touches[n - 1]) continue;
    const Wrench now = wrenchOf(tool[n], course.hand[n], k), before = wrenchOf(tool[n - 1], course.hand[n - 1], k);
    const double way = std::sqrt(k.translation) * (course.hand[n].position - course.hand[n - 1].position).norm(),
                 change = std::sqrt((now.force - before.force).squaredNorm() / k.translation +
                                    (now.torque - before.torque).squaredNorm() / k.rotation);
    if (way > 1e-9) ratios.push_back(change / way);
  }
  row.l_ratio_p99 = quantileOf(ratios, 0.99);
  row.l_ratio_largest = quantileOf(ratios, 1);
}

struct Reference {
  SampledSolid tool, body;
  std::vector<Configuration> exact;
  std::unique_ptr<bool[]> touches;  // (step) the exact tool is off the hand
};

ToolRow measure(const ToolCourse& course, const Reference& right, const ToolModel& model, const SphereTree& tool_tree,
                const SphereTree& body_tree, builder::Progress& progress) {
  runtime::SceneDescription description;
  description.tool = tool_tree;
  description.reference_point = course.reference;
  description.objects.push_back({body_tree, {}});
  runtime::Scene scene;
  std::string fault;
  if (!runtime::compileScene(description, scene, fault)) throw std::runtime_error(fault);
  runtime::Workspace workspace(scene);
  const runtime::Coupling coupling = description.coupling;
  ToolRow row{course.tool, course.body, model.name};
  row.parts = tool_tree.hulls.empty() ? levelSet(tool_tree, tool_tree.levelCount() - 1).size() : tool_tree.hulls.parts.size();
  ToolGaps gaps(right.tool, right.body, course.reference);
  TimeHistogram times;
  std::vector<Configuration> tool;
  std::vector<double> angles, forces, torques, stand_offs;
  for (std::size_t n = 0; n < course.hand.size(); ++n) {
    if (n % 100 == 0) progress.check();
    const double begun = threadTime();
    const runtime::StepResult result = runtime::step(scene, course.hand[n], runtime::Mode::Constrained, workspace);
    times.add(threadTime() - begun);
    tool.push_back(result.graphic);
    if (!right.touches[n]) continue;
    const Wrench exact = wrenchOf(right.exact[n], course.hand[n], coupling);
    angles.push_back(degreesBetween(result.wrench.force, exact.force));
    forces.push_back((result.wrench.force - exact.force).norm());
    torques.push_back((result.wrench.torque - exact.torque).norm());
    double gap = gaps.smallest(result.graphic, 0.1);
    if (gap == 0.1) gap = gaps.smallest(result.graphic, 3);
    stand_offs.push_back(std::abs(gap));
    row.deepest = std::max(row.deepest, -gap);
  }
  row.step_median = times.quantile(0.5), row.step_p99 = times.quantile(0.99);
  row.angle_median = quantileOf(angles, 0.5), row.angle_p99 = quantileOf(angles, 0.99);
  row.force_p99 = quantileOf(forces, 0.99), row.torque_p99 = quantileOf(torques, 0.99);
  row.stand_off_p99 = quantileOf(stand_offs, 0.99);
  addRatios(course, tool, {right.touches.get(), tool.size()}, coupling, row);
  return row;
}

Reference referenceOf(const ToolCourse& course, const runtime::Coupling& coupling, builder::Progress& progress) {
  Reference out{{course.tool_mesh, kToolSpacing}, {course.body_mesh, kBodySpacing}, {}, {}};
  ExactTool exact(out.tool, out.body, course.reference, coupling, course.hand.front());
  out.touches = std::make_unique<bool[]>(course.hand.size());
  for (const Configuration& hand : course.hand) {
    progress.check();
    out.exact.push_back(exact.follow(hand));
    out.touches[out.exact.size() - 1] = wrenchOf(out.exact.back(), hand, coupling).force.norm() > 1e-3;
  }
  return out;
}

const std::vector<std::string> kToolHeads{"tool",           "body",        "model",        "parts",     "step, median [us]",
                                          "p99 [us]",       "angle [deg]", "p99 [deg]",    "force [N]", "torque [N mm]",
                                          "stand-off [mm]", "inside [mm]", "L-ratio, p99", "largest"};

std::vector<std::string> toolCells(const ToolRow& r) {
  if (r.parts == 0) {
    const std::string p99 = shortNumber(r.l_ratio_p99), largest = shortNumber(r.l_ratio_largest);
    return {r.tool, r.body, r.model, "", "", "", "", "", "", "", "", "", p99, largest};
  }
  std::vector<std::string> cells{r.tool, r.body, r.model, std::to_string(r.parts)};
  for (const double figure : {r.step_median, r.step_p99, r.angle_median, r.angle_p99, r.force_p99, r.torque_p99, r.stand_off_p99, r.deepest,
                              r.l_ratio_p99, r.l_ratio_largest})
    cells.push_back(shortNumber(figure));
  return cells;
}

}  // namespace

std::vector<ToolCourse> toolBench(std::span<const std::string> names, double depth, builder::Progress& progress) {
  const std::vector<Part> tools = benchTools(), bodies = benchBodies();
  std::set<std::string> known;
  for (const std::vector<Part>* parts : {&tools, &bodies})
    for (const Part& part : *parts) known.insert(part.name);
  for (const std::string& name : names)
    if (!known.contains(name)) {
      std::string list;
      for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
      throw std::invalid_argument("'" + name + "' is no tool or body of the comparison. They are: " + list);
    }
  const auto chosen = [&](const std::vector<Part>& parts, const Part& part) {
    const auto isNamed = [&](const Part& one) { return std::ranges::count(names, one.name) > 0; };
    return isNamed(part) || std::ranges::none_of(parts, isNamed);
  };
  std::vector<ToolCourse> courses;
  std::map<std::string, TriangleMesh> meshes;
  const auto meshOf = [&](const Part& part) { return meshes.contains(part.name) ? meshes[part.name] : meshes[part.name] = part.mesh(); };
  for (const Part& tool : tools)
    for (const Part& body : bodies)
      if (chosen(tools, tool) && chosen(bodies, body))
        courses.push_back({tool.name, body.name, meshOf(tool), meshOf(body), tool.reference, {}});
  tbb::parallel_for(std::size_t{0}, courses.size(), [&](std::size_t i) {
    if (progress.cancelled()) return;
    ToolCourse& course = courses[i];
    const SampledSolid tool(course.tool_mesh, kToolSpacing), body(course.body_mesh, kBodySpacing);
    course.hand = handOver(tool, body, {course.tool, {}, course.reference}, course.body, depth);
  });
  progress.check();
  return courses;
}

std::vector<ToolModel> toolModels() {
  std::vector<ToolModel> models;
  for (int levels = 2; levels <= 5; ++levels) {
    ToolModel model{std::to_string(1 << 3 * (levels - 1)) + " leaves", {}};
    model.settings.quality = builder::Quality::Quick;
    model.settings.levels = levels;
    model.settings.skin = false;
    models.push_back(model);
  }
  for (const double tolerance : {0.1, 0.03, 0.01}) {
    ToolModel model{"hulls of " + shortNumber(tolerance) + " mm", models[2].settings};
    model.settings.hulls = true;
    model.settings.hull_tolerance_mm = tolerance;
    models.push_back(model);
  }
  return models;
}

std::vector<Configuration> exactAnswer(const ToolCourse& course, const runtime::Coupling& coupling, builder::Progress& progress) {
  return referenceOf(course, coupling, progress).exact;
}

std::vector<ToolRow> compareTools(std::span<const ToolCourse> courses, std::span<const ToolModel> models, BodyLibrary& bodies,
                                  tool::WorkProgress& progress) {
  builder::BuildSettings object;
  object.quality = builder::Quality::Quick;
  std::vector<const SphereTree*> body_trees, tool_trees;
  for (const ToolCourse& course : courses) {
    progress.stage("trees of " + course.tool + " and " + course.body);
    body_trees.push_back(&bodies.tree(course.body_mesh, object));
    for (const ToolModel& model : models) tool_trees.push_back(&bodies.tree(course.tool_mesh, model.settings));
  }
  progress.stage("exact answers");
  const runtime::Coupling coupling;
  std::vector<std::unique_ptr<Reference>> references(courses.size());
  tbb::parallel_for(std::size_t{0}, courses.size(), [&](std::size_t i) {
    if (!progress.cancelled()) references[i] = std::make_unique<Reference>(referenceOf(courses[i], coupling, progress));
  });
  progress.check();
  std::vector<ToolRow> rows;
  for (std::size_t i = 0; i < courses.size(); ++i) {
    progress.stage(courses[i].tool + " on " + courses[i].body);
    ToolRow exact{courses[i].tool, courses[i].body, "exact"};
    addRatios(courses[i], references[i]->exact, {references[i]->touches.get(), references[i]->exact.size()}, coupling, exact);
    rows.push_back(exact);
    for (std::size_t k = 0; k < models.size(); ++k) {
      const SphereTree& tool = *tool_trees[i * models.size() + k];
      if (models[k].settings.hulls && tool.hulls.empty()) continue;  // it would be a block of many corners
      rows.push_back(measure(courses[i], *references[i], models[k], tool, *body_trees[i], progress));
      progress.advance(static_cast<double>(k + 1) / static_cast<double>(models.size()));
    }
  }
  return rows;
}

std::string toolTable(std::span<const ToolRow> rows) {
  std::vector<std::vector<std::string>> lines{kToolHeads};
  for (const ToolRow& row : rows) lines.push_back(toolCells(row));
  return tool::textTable(lines);
}

nlohmann::ordered_json toolJson(std::span<const ToolRow> rows) {
  nlohmann::ordered_json out{{"schema", "spheretree.tools/1"}, {"rows", nlohmann::ordered_json::array()}};
  for (const ToolRow& r : rows) {
    nlohmann::ordered_json row{{"tool", r.tool}, {"body", r.body}, {"model", r.model}};
    if (r.parts > 0) {
      row["parts"] = r.parts;
      row["time_us"] = {{"median", r.step_median}, {"p99", r.step_p99}};
      row["angle_deg"] = {{"median", r.angle_median}, {"p99", r.angle_p99}};
      row["force_error_n"] = r.force_p99;
      row["torque_error_nmm"] = r.torque_p99;
      row["stand_off_mm"] = r.stand_off_p99;
      row["penetration_mm"] = r.deepest;
    }
    row["l_ratio"] = {{"p99", r.l_ratio_p99}, {"largest", r.l_ratio_largest}};
    out["rows"].push_back(std::move(row));
  }
  return out;
}

std::string toolSection(std::span<const ToolRow> rows) {
  // Geometric means over the bodies, for each tool and model.
  const auto chart = [&](const std::string& heading, const std::string& label, double ToolRow::*figure) {
    struct Sum {
      double time = 0, value = 0, parts = 0;
      int count = 0;
    };
    std::vector<std::pair<std::pair<std::string, std::string>, Sum>> sums;  // in the order of the rows
    for (const ToolRow& r : rows) {
      if (r.parts == 0) continue;
      const std::pair key{r.tool, r.model};
      auto found = std::ranges::find(sums, key, &decltype(sums)::value_type::first);
      if (found == sums.end()) found = sums.insert(found, {key, {}});
      Sum& sum = found->second;
      sum.time += std::log(std::max(r.step_p99, 1e-3)), sum.value += std::log(std::max(r.*figure, 1e-4));
      sum.parts += static_cast<double>(r.parts), ++sum.count;
    }
    tool::ScatterChart scatter{heading, "processor time of a step, 99th percentile [us]", label, {}, {}, false};
    for (const auto& [key, sum] : sums) {
      const bool is_hull = key.second.starts_with("hulls");
      const double time = std::exp(sum.time / sum.count), value = std::exp(sum.value / sum.count), parts = sum.parts / sum.count;
      const std::string series = key.first + (is_hull ? ", hulls" : ", leaves");
      scatter.points.push_back({time, value, series,
                                key.first + ", " + key.second + ": " + shortNumber(time) + " us, " + shortNumber(value),
                                parts < 65    ? 0
                                : parts < 600 ? 1
                                              : 2,
                                false, is_hull});
    }
    return tool::scatterSvg(scatter);
  };
  tool::HtmlTable table{
      "Angle, force and torque: off the exact answer; stand-off and depth inside: of the meshes. 99th percentiles but for the medians and "
      "the largest. A row without parts is the exact answer itself.",
      kToolHeads,
      {}};
  for (const ToolRow& row : rows) {
    table.rows.push_back(toolCells(row));
    for (std::string& cell : table.rows.back()) cell = tool::escaped(cell);
  }
  return "<p>Lower left is better. Geometric means over the bodies. Discs are leaves, squares are hulls; the larger, the more parts.</p>"
         "<div class=\"charts\">" +
         chart("Where the force points", "angle, 99th percentile [degree]", &ToolRow::angle_p99) +
         chart("Where the tool rests", "stand-off, 99th percentile [mm]", &ToolRow::stand_off_p99) +
         chart("How the tool turns", "torque error, 99th percentile [N mm]", &ToolRow::torque_p99) +
         chart("How smooth it is", "L-ratio, 99th percentile", &ToolRow::l_ratio_p99) + "</div>" + table.html();
}

}  // namespace spheretree::player
