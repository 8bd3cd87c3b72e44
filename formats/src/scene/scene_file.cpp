// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "spheretree/core/tissue.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "spheretree/formats/safe_name.h"
#include "text/json_element.h"
#include "text/json_layout.h"

namespace spheretree::formats {
namespace {

using Eigen::Vector3d;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* kSceneSchema = "spheretree.scene/1";
constexpr std::uint64_t kMaxBytes = 16 << 20;
constexpr std::size_t kMaxHingeAngles = 100'000;
constexpr double kMaxFriction = 2;
constexpr double kFastestRemoval = 1e4;  // [mm/(N s)]
constexpr std::size_t kLongestText = 4096;
constexpr std::array<const char*, 4> kUnits{"mm", "cm", "m", "in"};
constexpr std::array<const char*, 2> kMedialAxes{"adaptive", "static"};
constexpr std::array<const char*, 9> kBuilders{"cover", "combined", "merge", "burst", "expand", "spawn", "grid", "hubbard", "octree"};
constexpr std::array<const char*, 3> kQualities{"quick", "standard", "best"};
constexpr std::array<const char*, 2> kReferencePoints{"tip", "centre"};
constexpr const char* kNoSkin = "off";
constexpr std::array<const char*, 3> kRepairs{"auto", "off", "wrap"};

std::string shortNumber(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.9g", value);
  return digits;
}

std::string shortText(const JsonElement& e) {
  std::string text = e.text();
  if (text.size() > kLongestText) e.fail("is longer than " + std::to_string(kLongestText) + " bytes");
  if (text.find('\0') != std::string::npos) e.fail("holds a zero byte");
  return text;
}

std::string oneOf(const JsonElement& e, std::span<const char* const> allowed) {
  const std::string text = e.text();
  std::string all;
  for (const char* known : allowed) {
    if (text == known) return text;
    all += all.empty() ? known : std::string(", ") + known;
  }
  e.fail("is " + inQuotes(text) + ", not one of " + all);
}

double within(const JsonElement& e, double smallest, double largest) {
  const double value = e.number();
  if (!(value >= smallest && value <= largest))
    e.fail("is " + shortNumber(value) + ", not within " + shortNumber(smallest) + " .. " + shortNumber(largest));
  return value;
}

double above0(const JsonElement& e, double largest) {
  const double value = e.number();
  if (!(value > 0 && value <= largest)) e.fail("is " + shortNumber(value) + ", not above 0 and at most " + shortNumber(largest));
  return value;
}

Vector3d vector(const JsonElement& e, double largest = kMaxSceneLength) {
  if (e.size() != 3) e.fail("is not [x, y, z]");
  Vector3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    v[static_cast<Eigen::Index>(axis)] = e.item(axis).number();
    if (std::abs(e.item(axis).number()) > largest) e.item(axis).fail("is beyond " + shortNumber(largest));
  }
  return v;
}

Quaternion unitQuaternion(const JsonElement& e) {
  if (e.size() != 4) e.fail("is not [w, x, y, z]");
  const Quaternion q(e.item(0).number(), e.item(1).number(), e.item(2).number(), e.item(3).number());
  const double length = q.norm();
  if (!(std::abs(length - 1) <= 1e-3)) e.fail("has length " + shortNumber(length) + ", not 1");
  // A quaternion that has unit length up to rounding is kept, so that a file written from it has the same numbers.
  return std::abs(length - 1) <= 1e-15 ? q : Quaternion(q.normalized());
}

/// The pose in `e`, or the identity.
Configuration readPose(const JsonElement& e) {
  Configuration pose;
  if (e.has("position_mm")) pose.position = vector(e.at("position_mm"));
  if (e.has("quaternion_wxyz")) pose.orientation = unitQuaternion(e.at("quaternion_wxyz"));
  return pose;
}

std::string fileSafeName(const JsonElement& e) {
  const std::string name = e.text();
  if (!isSafeName(name)) {
    e.fail("is " + inQuotes(name) + ", not safe as a file name: use 1 to " + std::to_string(kMaxNameBytes) +
           " bytes of letters, digits, _, - and . (not - or . first)");
  }
  return name;
}

#define SPHERETREE_TREE_SETTINGS \
  "builder", "search", "medial_axis", "quality", "repair", "levels", "branching", "tolerance_mm", "seed", "skin_mm", "crease_angle_deg"

/// A length, or 0 for "off".
double skinOf(const JsonElement& e) {
  if (!e.isText()) return above0(e, kMaxSceneLength);
  if (e.text() != kNoSkin) e.fail("is neither a length nor \"off\"");
  return 0;
}

TreeSettings readSettings(const JsonElement& e) {
  TreeSettings s;
  if (e.has("builder")) s.builder = oneOf(e.at("builder"), kBuilders);
  if (e.has("search")) s.search = e.at("search").truth();
  if (e.has("medial_axis")) s.medial_axis = oneOf(e.at("medial_axis"), kMedialAxes);
  if (e.has("quality")) s.quality = oneOf(e.at("quality"), kQualities);
  if (e.has("repair")) s.repair = oneOf(e.at("repair"), kRepairs);
  if (e.has("levels")) s.levels = static_cast<int>(e.at("levels").whole(6, 2));
  if (e.has("branching")) s.branching = static_cast<int>(e.at("branching").whole(8, 2));
  if (e.has("tolerance_mm")) s.tolerance_mm = above0(e.at("tolerance_mm"), kMaxSceneLength);
  if (e.has("seed")) s.seed = e.at("seed").whole(std::numeric_limits<std::uint64_t>::max());
  if (e.has("skin_mm")) s.skin_mm = skinOf(e.at("skin_mm"));
  if (e.has("crease_angle_deg")) {
    const JsonElement angle = e.at("crease_angle_deg");
    s.crease_angle_deg = angle.number();
    if (!(*s.crease_angle_deg >= 1 && *s.crease_angle_deg <= 180)) angle.fail("is not within 1 .. 180");
  }
  return s;
}

SceneItem readItem(const JsonElement& e) {
  SceneItem item;
  item.name = fileSafeName(e.at("name"));
  if (!e.has("mesh") && !e.has("tree")) e.fail("has neither \"mesh\" nor \"tree\"");
  for (const auto& [key, path] : {std::pair("mesh", &item.mesh), std::pair("tree", &item.tree)}) {
    if (!e.has(key)) continue;
    *path = toPath(shortText(e.at(key)));
    if (path->empty()) e.at(key).fail("is empty");
  }
  if (e.has("unit")) {
    if (!e.has("mesh")) e.at("unit").fail("is for a mesh; a tree is in mm");
    item.unit = oneOf(e.at("unit"), kUnits);
  }
  if (e.has("part")) {
    if (!e.has("mesh")) e.at("part").fail("is for a mesh; a tree has no parts");
    item.part = shortText(e.at("part"));
    if (item.part.empty()) e.at("part").fail("is empty; leave it out for the whole mesh");
  }
  item.settings = readSettings(e);
  if (e.has("friction")) item.friction = within(e.at("friction"), 0, kMaxFriction);
  return item;
}

/// The region from "sphere" or "box".
WorkRegion readShape(const JsonElement& e) {
  WorkRegion region;
  if (e.has("sphere") == e.has("box")) e.fail(e.has("box") ? "has both \"sphere\" and \"box\"" : "has neither \"sphere\" nor \"box\"");
  if (e.has("sphere")) {
    const JsonElement sphere = e.at("sphere");
    sphere.onlyKeys({"centre_mm", "radius_mm"});
    region.centre_mm = vector(sphere.at("centre_mm"));
    region.radius_mm = above0(sphere.at("radius_mm"), kMaxSceneLength);
  } else {
    const JsonElement box = e.at("box");
    box.onlyKeys({"low_mm", "high_mm"});
    region.shape = WorkRegion::Shape::Box;
    region.low_mm = vector(box.at("low_mm"));
    region.high_mm = vector(box.at("high_mm"));
    if (!(region.low_mm.array() < region.high_mm.array()).all()) box.fail("has a low_mm that is not below its high_mm on every axis");
  }
  return region;
}

WorkRegion readRegion(const JsonElement& e) {
  e.onlyKeys({"name", "sphere", "box", "tolerance_mm"});
  WorkRegion region = readShape(e);
  if (e.has("name")) region.name = shortText(e.at("name"));
  region.tolerance_mm = above0(e.at("tolerance_mm"), kMaxSceneLength);
  return region;
}

SoftSettings readSoft(const JsonElement& e) {
  e.onlyKeys({"young_kpa", "poisson", "density_kg_m3", "share", "tetrahedra", "fixed"});
  SoftSettings soft;
  soft.young_kpa = e.at("young_kpa").number();
  if (e.has("poisson")) soft.poisson = e.at("poisson").number();
  if (e.has("density_kg_m3")) soft.density_kg_m3 = e.at("density_kg_m3").number();
  if (const std::string fault = findFault(TissueMaterial{soft.young_kpa, soft.poisson, soft.density_kg_m3}); !fault.empty())
    e.fail("is out of range: " + fault);
  if (e.has("share")) soft.share = within(e.at("share"), 0.05, 0.5);
  if (e.has("tetrahedra")) soft.tetrahedra = static_cast<int>(e.at("tetrahedra").whole(50'000, 100));
  const JsonElement fixed = e.at("fixed");
  if (fixed.size() < 1 || fixed.size() > kMaxSceneObjects) fixed.fail("has no region: say what holds the tissue");
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    const JsonElement region = fixed.item(i);
    region.onlyKeys({"sphere", "box", "inside"});
    FixedRegion& held = soft.fixed.emplace_back();
    if (region.has("inside"))
      held.inside = shortText(region.at("inside"));
    else
      held.region = readShape(region);
  }
  return soft;
}

/// The rate of each layer, by its name in `rates`.
void readRates(const JsonElement& rates, std::vector<CutLayer>& layers) {
  for (CutLayer& layer : layers) {
    if (!rates.has(layer.name.c_str())) rates.fail("has no rate for the layer " + inQuotes(layer.name));
    layer.removal = above0(rates.at(layer.name.c_str()), kFastestRemoval);
  }
  for (const std::string& name : rates.keys())
    if (std::none_of(layers.begin(), layers.end(), [&](const CutLayer& layer) { return layer.name == name; }))
      rates.fail("has a rate for " + inQuotes(name) + ", and layers has none of this name");
}

CutDescription readCut(const JsonElement& e) {
  e.onlyKeys({"layers", "removal_mm_per_n_s", "tangential"});
  CutDescription cut;
  const JsonElement layers = e.at("layers");
  if (layers.size() < 1 || layers.size() > kMaxCutLayers)
    layers.fail("has " + std::to_string(layers.size()) + " layers, not 1 to " + std::to_string(kMaxCutLayers));
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const JsonElement layer = layers.item(i);
    layer.onlyKeys({"name", "mesh", "tree"});
    CutLayer read{fileSafeName(layer.at("name")), shortText(layer.at("mesh"))};
    if (layer.has("tree")) read.tree = shortText(layer.at("tree"));
    for (const CutLayer& other : cut.layers)
      if (other.name == read.name) layer.at("name").fail("is " + inQuotes(read.name) + ", the name of another layer");
    if (read.mesh.empty()) layer.at("mesh").fail("is empty");
    cut.layers.push_back(std::move(read));
  }
  readRates(e.at("removal_mm_per_n_s"), cut.layers);
  if (e.has("tangential")) cut.tangential = within(e.at("tangential"), 0, kMaxFriction);
  return cut;
}

/// What an object needs for a burr to cut it.
void refuseUncuttable(const JsonElement& object, const SceneFile& scene, const SceneItem& item) {
  const JsonElement cut = object.at("cut");
  if (item.soft) cut.fail("is for a rigid object; leave out soft");
  if (item.stiffness_n_per_mm > 0) cut.fail("is for a rigid object; leave out stiffness_n_per_mm");
  if (!item.part.empty()) cut.fail("is for a whole mesh; write the part to a file of its own");
  if (mergedSettings(item.settings, scene.defaults).skin_mm == 0.0) cut.fail("needs a skin; leave out skin_mm");
  const std::filesystem::path& outer = item.cut->layers.front().mesh;
  if (!item.mesh.empty() && item.mesh.lexically_normal() != outer.lexically_normal())
    cut.at("layers").item(0).at("mesh").fail("is " + inQuotes(outer.string()) + ", not " + inQuotes(item.mesh.string()) +
                                             ": the first layer is the whole object");
}

constexpr double kLeastBurr = 0.1, kLargestBurr = 10;  // radius of its balls, as in the runtime [mm]

std::vector<Ball> readBurr(const JsonElement& e) {
  if (e.size() < 1 || e.size() > kMaxBurrBalls)
    e.fail("has " + std::to_string(e.size()) + " balls, not 1 to " + std::to_string(kMaxBurrBalls));
  std::vector<Ball> burr;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const JsonElement ball = e.item(i);
    ball.onlyKeys({"centre_mm", "radius_mm"});
    burr.push_back({vector(ball.at("centre_mm")), within(ball.at("radius_mm"), kLeastBurr, kLargestBurr)});
  }
  return burr;
}

void readCouplingAndLimits(const JsonElement& root, SceneFile& scene) {
  if (root.has("coupling")) {
    const JsonElement coupling = root.at("coupling");
    coupling.onlyKeys({"translation_n_per_mm", "rotation_n_mm_per_rad", "damping_n_s_per_mm", "rotation_damping_n_mm_s_per_rad", "mass_kg",
                       "inertia_kg_mm2"});
    if (coupling.has("mass_kg")) scene.mass_kg = within(coupling.at("mass_kg"), 0, 1e3);
    if (coupling.has("inertia_kg_mm2")) scene.inertia_kg_mm2 = within(coupling.at("inertia_kg_mm2"), 0, 1e9);
    if (coupling.has("damping_n_s_per_mm")) scene.damping_n_s_per_mm = within(coupling.at("damping_n_s_per_mm"), 0, 1e6);
    if (coupling.has("rotation_damping_n_mm_s_per_rad"))
      scene.rotation_damping_n_mm_s_per_rad = within(coupling.at("rotation_damping_n_mm_s_per_rad"), 0, 1e9);
    if (coupling.has("translation_n_per_mm")) scene.translation_n_per_mm = above0(coupling.at("translation_n_per_mm"), 1e6);
    if (coupling.has("rotation_n_mm_per_rad")) scene.rotation_n_mm_per_rad = above0(coupling.at("rotation_n_mm_per_rad"), 1e9);
  }
  if (!root.has("limits")) return;
  const JsonElement limits = root.at("limits");
  limits.onlyKeys({"force_n", "torque_n_mm"});
  if (limits.has("force_n")) scene.force_n = above0(limits.at("force_n"), 1e6);
  if (limits.has("torque_n_mm")) {
    const JsonElement torque = limits.at("torque_n_mm");
    scene.torque_n_mm = vector(torque, 1e9);
    for (std::size_t axis = 0; axis < 3; ++axis) (void)above0(torque.item(axis), 1e9);
  }
}

Hinge readHinge(const JsonElement& e) {
  e.onlyKeys({"point_mm", "axis", "angle_deg"});
  Hinge hinge;
  hinge.point_mm = vector(e.at("point_mm"));
  const Vector3d axis = vector(e.at("axis"));
  if (!(axis.norm() > 1e-6)) e.at("axis").fail("has no direction");
  hinge.axis = std::abs(axis.norm() - 1) <= 1e-15 ? axis : Vector3d(axis.normalized());
  const JsonElement angles = e.at("angle_deg");
  if (angles.size() == 0 || angles.size() > kMaxHingeAngles)
    angles.fail("has " + std::to_string(angles.size()) + " rows [t_s, degree], not 1 to " + std::to_string(kMaxHingeAngles));
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const JsonElement row = angles.item(i);
    if (row.size() != 2) row.fail("is not [t_s, degree]");
    const Hinge::Angle angle{within(row.item(0), 0, 1e6), within(row.item(1), -180, 180)};
    if (i > 0 && !(angle.t_s > hinge.angles.back().t_s)) row.fail("is not later than the row before");
    hinge.angles.push_back(angle);
  }
  return hinge;
}

void readBodies(const JsonElement& root, SceneFile& scene) {
  if (!root.has("bodies")) return;
  const JsonElement bodies = root.at("bodies");
  if (bodies.size() > kMaxSceneObjects) bodies.fail("has more than " + std::to_string(kMaxSceneObjects) + " bodies");
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const JsonElement e = bodies.item(i);
    e.onlyKeys({"name", "pose_csv", "hinge"});
    SceneBody body;
    body.name = fileSafeName(e.at("name"));
    for (const SceneBody& other : scene.bodies)
      if (other.name == body.name) e.at("name").fail("is " + inQuotes(body.name) + ", the name of another body");
    if (e.has("pose_csv") == e.has("hinge"))
      e.fail(e.has("hinge") ? "has both \"pose_csv\" and \"hinge\"" : "has neither \"pose_csv\" nor \"hinge\"");
    if (e.has("hinge")) body.hinge = readHinge(e.at("hinge"));
    if (e.has("pose_csv")) body.pose_csv = toPath(shortText(e.at("pose_csv")));
    if (e.has("pose_csv") && body.pose_csv.empty()) e.at("pose_csv").fail("is empty");
    scene.bodies.push_back(std::move(body));
  }
}

/// The contact settings of an object that a tool does not have.
void readContact(const JsonElement& object, const SceneFile& scene, SceneItem& item) {
  if (object.has("stiffness_n_per_mm")) item.stiffness_n_per_mm = above0(object.at("stiffness_n_per_mm"), 1e6);
  if (!object.has("body")) return;
  item.body = object.at("body").text();
  for (const SceneBody& body : scene.bodies)
    if (body.name == item.body) return;
  object.at("body").fail("is " + inQuotes(item.body) + ", and bodies has none of this name");
}

void refuseTwins(const JsonElement& root, const SceneFile& scene) {
  struct Item {
    std::string place, name;
  };
  std::map<std::string, Item> seen;  // by the name in lower case, since some file systems ignore case
  const auto lower = [](std::string name) {
    for (char& c : name)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return name;
  };
  seen[lower(scene.tool.name)] = {"the tool", scene.tool.name};
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto [other, is_new] =
        seen.emplace(lower(scene.objects[i].name), Item{"objects[" + std::to_string(i) + "]", scene.objects[i].name});
    if (!is_new)
      root.at("objects").item(i).at("name").fail("is " + inQuotes(scene.objects[i].name) + ", the name of " + other->second.place +
                                                 (other->second.name == scene.objects[i].name ? "" : " but for case") +
                                                 "; give it a name of its own");
  }
}

void refuseUnknownHolders(const JsonElement& root, const SceneFile& scene) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (!scene.objects[i].soft) continue;
    for (std::size_t k = 0; k < scene.objects[i].soft->fixed.size(); ++k) {
      const std::string& name = scene.objects[i].soft->fixed[k].inside;
      if (name.empty()) continue;
      const auto other = std::find_if(scene.objects.begin(), scene.objects.end(), [&](const SceneItem& o) { return o.name == name; });
      const JsonElement region = root.at("objects").item(i).at("soft").at("fixed").item(k).at("inside");
      if (other == scene.objects.end()) region.fail("is " + inQuotes(name) + ", which is the name of no object");
      if (other->soft) region.fail("is " + inQuotes(name) + ", which is soft itself; a rigid object holds tissue");
    }
  }
}

void readTool(const JsonElement& tool, SceneFile& scene) {
  tool.onlyKeys({"name", "mesh", "tree", "unit", "part", "reference_point_mm", "reference_point", "position_mm", "quaternion_wxyz",
                 "friction", "burr", SPHERETREE_TREE_SETTINGS});
  scene.tool = readItem(tool);
  if (tool.has("burr")) scene.tool.burr = readBurr(tool.at("burr"));
  scene.tool.pose = readPose(tool);
  if (tool.has("reference_point")) {
    if (tool.has("reference_point_mm")) tool.fail("has both \"reference_point\" and \"reference_point_mm\"");
    scene.tool.reference_point = oneOf(tool.at("reference_point"), kReferencePoints);
  }
  if (tool.has("reference_point_mm")) scene.tool.reference_point_mm = vector(tool.at("reference_point_mm"));
}

void readDevice(const JsonElement& device, SceneFile& scene) {
  device.onlyKeys({"position_mm", "quaternion_wxyz", "passivity_control"});
  scene.device = readPose(device);
  if (device.has("passivity_control")) scene.passivity_control = device.at("passivity_control").truth();
}

void readObjects(const JsonElement& objects, SceneFile& scene) {
  const std::size_t count = objects.size();
  if (count < 1 || count > kMaxSceneObjects)
    objects.fail("has " + std::to_string(count) + " objects, not 1 to " + std::to_string(kMaxSceneObjects));
  for (std::size_t i = 0; i < count; ++i) {
    const JsonElement object = objects.item(i);
    object.onlyKeys({"name", "mesh", "tree", "unit", "part", "position_mm", "quaternion_wxyz", "body", "friction", "stiffness_n_per_mm",
                     "soft", "cut", SPHERETREE_TREE_SETTINGS});
    SceneItem item = readItem(object);
    if (object.has("soft")) {
      if (object.has("tree")) object.at("soft").fail("is for a mesh that a tree is built from; a soft tree (.soft) has it in it");
      item.soft = readSoft(object.at("soft"));
    }
    item.pose = readPose(object);
    readContact(object, scene, item);
    if (object.has("cut")) {
      item.cut = readCut(object.at("cut"));
      refuseUncuttable(object, scene, item);
    }
    scene.objects.push_back(std::move(item));
  }
}

OrderedJson toJson(const Vector3d& v) { return OrderedJson::array({v.x(), v.y(), v.z()}); }

void addPose(OrderedJson& out, const Configuration& pose) {
  const Quaternion& q = pose.orientation;
  out["position_mm"] = toJson(pose.position);
  out["quaternion_wxyz"] = OrderedJson::array({q.w(), q.x(), q.y(), q.z()});
}

void addSettings(OrderedJson& out, const TreeSettings& s) {
  if (s.builder) out["builder"] = *s.builder;
  if (s.search) out["search"] = *s.search;
  if (s.medial_axis) out["medial_axis"] = *s.medial_axis;
  if (s.quality) out["quality"] = *s.quality;
  if (s.repair) out["repair"] = *s.repair;
  if (s.levels) out["levels"] = *s.levels;
  if (s.branching) out["branching"] = *s.branching;
  if (s.tolerance_mm) out["tolerance_mm"] = *s.tolerance_mm;
  if (s.seed) out["seed"] = *s.seed;
  if (s.skin_mm) {
    if (*s.skin_mm > 0)
      out["skin_mm"] = *s.skin_mm;
    else
      out["skin_mm"] = kNoSkin;
  }
  if (s.crease_angle_deg) out["crease_angle_deg"] = *s.crease_angle_deg;
}

OrderedJson toJson(const SceneItem& item) {
  OrderedJson out{{"name", item.name}};
  if (!item.tree.empty()) out["tree"] = toUtf8(item.tree);
  if (!item.mesh.empty()) out["mesh"] = toUtf8(item.mesh);
  if (!item.unit.empty()) out["unit"] = item.unit;
  if (!item.part.empty()) out["part"] = item.part;
  if (!item.body.empty()) out["body"] = item.body;
  if (item.friction > 0) out["friction"] = item.friction;
  if (item.stiffness_n_per_mm > 0) out["stiffness_n_per_mm"] = item.stiffness_n_per_mm;
  return out;
}

OrderedJson toJson(const SceneBody& body) {
  OrderedJson out{{"name", body.name}};
  if (!body.pose_csv.empty()) out["pose_csv"] = toUtf8(body.pose_csv);
  if (!body.hinge) return out;
  OrderedJson angles = OrderedJson::array();
  for (const Hinge::Angle& angle : body.hinge->angles) angles.push_back(OrderedJson::array({angle.t_s, angle.degree}));
  out["hinge"] = {{"point_mm", toJson(body.hinge->point_mm)}, {"axis", toJson(body.hinge->axis)}, {"angle_deg", std::move(angles)}};
  return out;
}

OrderedJson shapeJson(const WorkRegion& region) {
  OrderedJson out = OrderedJson::object();
  if (region.shape == WorkRegion::Shape::Sphere)
    out["sphere"] = {{"centre_mm", toJson(region.centre_mm)}, {"radius_mm", region.radius_mm}};
  else
    out["box"] = {{"low_mm", toJson(region.low_mm)}, {"high_mm", toJson(region.high_mm)}};
  return out;
}

OrderedJson toJson(const WorkRegion& region) {
  OrderedJson out = OrderedJson::object();
  if (!region.name.empty()) out["name"] = region.name;
  out.update(shapeJson(region));
  out["tolerance_mm"] = region.tolerance_mm;
  return out;
}

OrderedJson toJson(const SoftSettings& soft) {
  OrderedJson out{{"young_kpa", soft.young_kpa},
                  {"poisson", soft.poisson},
                  {"density_kg_m3", soft.density_kg_m3},
                  {"share", soft.share},
                  {"tetrahedra", soft.tetrahedra}};
  out["fixed"] = OrderedJson::array();
  for (const FixedRegion& region : soft.fixed)
    out["fixed"].push_back(region.inside.empty() ? shapeJson(region.region) : OrderedJson{{"inside", region.inside}});
  return out;
}

OrderedJson toJson(const CutDescription& cut) {
  OrderedJson layers = OrderedJson::array(), rates = OrderedJson::object();
  for (const CutLayer& layer : cut.layers) {
    OrderedJson entry{{"name", layer.name}, {"mesh", layer.mesh.string()}};
    if (!layer.tree.empty()) entry["tree"] = layer.tree.string();
    layers.push_back(std::move(entry));
    rates[layer.name] = layer.removal;
  }
  return {{"layers", std::move(layers)}, {"removal_mm_per_n_s", std::move(rates)}, {"tangential", cut.tangential}};
}

OrderedJson toJson(const std::vector<Ball>& burr) {
  OrderedJson out = OrderedJson::array();
  for (const Ball& ball : burr) out.push_back({{"centre_mm", toJson(ball.centre)}, {"radius_mm", ball.radius}});
  return out;
}

}  // namespace

TreeSettings mergedSettings(const TreeSettings& own, const TreeSettings& defaults) {
  TreeSettings s = defaults;
  if (own.builder) s.builder = own.builder;
  if (own.search) s.search = own.search;
  if (own.medial_axis) s.medial_axis = own.medial_axis;
  if (own.quality) s.quality = own.quality;
  if (own.repair) s.repair = own.repair;
  if (own.levels) s.levels = own.levels;
  if (own.branching) s.branching = own.branching;
  if (own.tolerance_mm) s.tolerance_mm = own.tolerance_mm;
  if (own.seed) s.seed = own.seed;
  if (own.skin_mm) s.skin_mm = own.skin_mm;
  if (own.crease_angle_deg) s.crease_angle_deg = own.crease_angle_deg;
  return s;
}

double hingeAngle(const Hinge& hinge, double t) {
  const std::vector<Hinge::Angle>& rows = hinge.angles;
  const auto after = std::upper_bound(rows.begin(), rows.end(), t, [](double time, const Hinge::Angle& row) { return time < row.t_s; });
  double degree = after == rows.begin() ? rows.front().degree : std::prev(after)->degree;
  if (after != rows.begin() && after != rows.end()) {
    const Hinge::Angle& before = *std::prev(after);
    degree += (after->degree - before.degree) * (t - before.t_s) / (after->t_s - before.t_s);
  }
  return degree;
}

Configuration hingePose(const Hinge& hinge, double degree) {
  const Quaternion turn = rotationOf(hinge.axis * (degree * 3.14159265358979323846 / 180));
  return {hinge.point_mm - turn * hinge.point_mm, turn};
}

bool canCut(const SceneFile& scene) {
  return !scene.tool.burr.empty() &&
         std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneItem& object) { return object.cut.has_value(); });
}

std::filesystem::path scenePath(const std::filesystem::path& scene_path, const std::filesystem::path& path) {
  return (scene_path.parent_path() / path).lexically_normal();  // an absolute `path` is kept
}

SceneFile parseScene(std::string_view text, const std::string& name) {
  const JsonSource source{name, "a scene (.scene.json)"};
  const nlohmann::json parsed = parseJson(text, source);
  const JsonElement root(parsed, "", source);
  if (const JsonElement schema = root.at("schema"); schema.text() != kSceneSchema)
    schema.fail(std::string("is not \"") + kSceneSchema + "\"");
  root.onlyKeys({"schema", "unit", "defaults", "coupling", "limits", "tool", "bodies", "objects", "work", "reach", "device"});

  SceneFile scene;
  if (root.has("unit")) scene.unit = oneOf(root.at("unit"), kUnits);
  if (root.has("defaults")) {
    root.at("defaults").onlyKeys({SPHERETREE_TREE_SETTINGS});
    scene.defaults = readSettings(root.at("defaults"));
  }
  readCouplingAndLimits(root, scene);
  readTool(root.at("tool"), scene);
  if (root.has("device")) readDevice(root.at("device"), scene);
  readBodies(root, scene);
  readObjects(root.at("objects"), scene);
  refuseTwins(root, scene);
  refuseUnknownHolders(root, scene);

  if (root.has("work")) {
    const JsonElement work = root.at("work");
    if (work.size() > kMaxSceneObjects) work.fail("has more than " + std::to_string(kMaxSceneObjects) + " regions");
    for (std::size_t i = 0; i < work.size(); ++i) scene.work.push_back(readRegion(work.item(i)));
  }
  if (root.has("reach")) {
    const JsonElement reach = root.at("reach");
    reach.onlyKeys({"radius_mm", "tolerance_mm"});
    scene.reach = Reach{above0(reach.at("radius_mm"), kMaxSceneLength), above0(reach.at("tolerance_mm"), kMaxSceneLength)};
  }
  return scene;
}

SceneFile readScene(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path, kMaxBytes);
  return parseScene({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, toUtf8(path));
}

std::string sceneText(const SceneFile& scene) {
  OrderedJson out{{"schema", kSceneSchema}, {"unit", scene.unit}};
  OrderedJson defaults = OrderedJson::object();
  addSettings(defaults, scene.defaults);
  if (!defaults.empty()) out["defaults"] = std::move(defaults);
  out["coupling"] = {{"translation_n_per_mm", scene.translation_n_per_mm}, {"rotation_n_mm_per_rad", scene.rotation_n_mm_per_rad}};
  if (scene.damping_n_s_per_mm > 0) out["coupling"]["damping_n_s_per_mm"] = scene.damping_n_s_per_mm;
  if (scene.rotation_damping_n_mm_s_per_rad > 0) out["coupling"]["rotation_damping_n_mm_s_per_rad"] = scene.rotation_damping_n_mm_s_per_rad;
  if (scene.mass_kg > 0) out["coupling"]["mass_kg"] = scene.mass_kg;
  if (scene.inertia_kg_mm2 > 0) out["coupling"]["inertia_kg_mm2"] = scene.inertia_kg_mm2;
  out["limits"] = {{"force_n", scene.force_n}, {"torque_n_mm", toJson(scene.torque_n_mm)}};
  out["tool"] = toJson(scene.tool);
  if (scene.tool.reference_point.empty())
    out["tool"]["reference_point_mm"] = toJson(scene.tool.reference_point_mm);
  else
    out["tool"]["reference_point"] = scene.tool.reference_point;
  if (!isIdentity(scene.tool.pose)) addPose(out["tool"], scene.tool.pose);
  if (!scene.tool.burr.empty()) out["tool"]["burr"] = toJson(scene.tool.burr);
  addSettings(out["tool"], scene.tool.settings);
  if (!isIdentity(scene.device)) {
    out["device"] = OrderedJson::object();
    addPose(out["device"], scene.device);
  }
  if (scene.passivity_control) out["device"]["passivity_control"] = true;
  if (!scene.bodies.empty()) {
    out["bodies"] = OrderedJson::array();
    for (const SceneBody& body : scene.bodies) out["bodies"].push_back(toJson(body));
  }
  out["objects"] = OrderedJson::array();
  for (const SceneItem& object : scene.objects) {
    OrderedJson item = toJson(object);
    addPose(item, object.pose);
    addSettings(item, object.settings);
    if (object.soft) item["soft"] = toJson(*object.soft);
    if (object.cut) item["cut"] = toJson(*object.cut);
    out["objects"].push_back(std::move(item));
  }
  if (!scene.work.empty()) {
    out["work"] = OrderedJson::array();
    for (const WorkRegion& region : scene.work) out["work"].push_back(toJson(region));
  }
  if (scene.reach) out["reach"] = {{"radius_mm", scene.reach->radius_mm}, {"tolerance_mm", scene.reach->tolerance_mm}};
  try {
    return layOut(out) + "\n";
  } catch (const nlohmann::json::exception&) {
    throw FormatError("a scene with a name or path that is not UTF-8 cannot be written. Rename it.");
  }
}

}  // namespace spheretree::formats
