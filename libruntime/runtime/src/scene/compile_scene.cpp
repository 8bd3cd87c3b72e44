// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "scene/compiled_scene.h"
#include "scene/cut_model.h"
#include "scene/hull_ways.h"
#include "scene/tissue_model.h"
#include "spheretree/runtime/step.h"

namespace spheretree::runtime {
namespace {

constexpr double kMaxFriction = 2;  // rubber on dry stone has 1; no known material has more than 2
constexpr double kFarthest = 1e7;   // [mm]; beyond it the resolution of float is 1 mm
constexpr std::size_t kMaxBurrBalls = 32;
constexpr double kLeastBurr = 0.1, kLargestBurr = 10;  // [mm]; the burrs of dentists have 0.25 to 2.5
constexpr double kBurrMargin = 0.1;                    // of the radius: a burr of few facets is smaller than its ball by up to this
constexpr double kMaxMass = 1e3;                       // more than anything that a hand moves [kg]

bool inRange(double value, double low, double high) { return value >= low && value <= high; }

std::string faultInSettings(const SceneDescription& d) {
  const auto bad = [](const char* what, double value, const char* range) {
    char number[32];
    std::snprintf(number, sizeof number, "%.9g", value);
    return std::string(what) + " is " + number + "; it must be " + range;
  };
  if (!inRange(d.coupling.translation, 1e-6, 1e6)) return bad("translation stiffness [N/mm]", d.coupling.translation, "within 1e-6 .. 1e6");
  if (!inRange(d.coupling.rotation, 1e-6, 1e9)) return bad("rotation stiffness [N mm/rad]", d.coupling.rotation, "within 1e-6 .. 1e9");
  if (!inRange(d.coupling.damping, 0, 1e6)) return bad("damping of the translation [N s/mm]", d.coupling.damping, "within 0 .. 1e6");
  if (!inRange(d.coupling.rotation_damping, 0, 1e9))
    return bad("damping of the rotation [N mm s/rad]", d.coupling.rotation_damping, "within 0 .. 1e9");
  if (!inRange(d.coupling.mass, 0, kMaxMass)) return bad("mass of the tool [kg]", d.coupling.mass, "within 0 .. 1e3");
  if (!inRange(d.coupling.inertia, 0, 1e6 * kMaxMass)) return bad("inertia of the tool [kg mm^2]", d.coupling.inertia, "within 0 .. 1e9");
  if (!inRange(d.tool_friction, 0, kMaxFriction)) return bad("friction of the tool", d.tool_friction, "within 0 .. 2");
  if (!inRange(d.step_time, 1e-5, 1)) return bad("time of a step [s]", d.step_time, "within 1e-5 .. 1");
  if (!inRange(d.wrench_limits.force, 1e-9, 1e6)) return bad("force limit [N]", d.wrench_limits.force, "above 0, at most 1e6");
  for (int k = 0; k < 3; ++k)
    if (!inRange(d.wrench_limits.torque[k], 1e-9, 1e9))
      return bad("torque limit [N mm]", d.wrench_limits.torque[k], "above 0, at most 1e9");
  const double smallest = std::max<double>(64, 64.0 * static_cast<double>(d.objects.size()));
  if (!inRange(d.step_limits.max_pairs, smallest, 1 << 20))
    return bad("max_pairs", d.step_limits.max_pairs, "64 for each object .. 1048576");
  if (!inRange(d.step_limits.max_work, 1000, 1 << 30)) return bad("max_work", d.step_limits.max_work, "within 1000 .. 1073741824");
  return {};
}

struct CompiledLeaves {
  CompiledTree tree;
  std::vector<std::uint32_t> nodes;  // (leaf) node index in the SphereTree
};

// Compiles leaves relative to `centre`, a point in the frame of the mesh.
CompiledLeaves compileLeaves(const SphereTree& file, const SearchTree& search, const Eigen::Vector3d& centre) {
  CompiledLeaves out;
  out.nodes = levelSet(file, file.levelCount() - 1);
  std::vector<Sphere> spheres;
  spheres.reserve(out.nodes.size());
  for (const std::uint32_t n : out.nodes) spheres.push_back(file.cover[n]);
  out.tree = compileTree(search, spheres, Eigen::Vector3d(file.origin_mm.data()) - centre, TreeOver::Leaves);
  return out;
}

CompiledShape compileShape(const SphereTree& file, bool has_skin, bool has_hulls) {
  CompiledShape shape;
  const Eigen::Vector3d origin(file.origin_mm.data());
  const SearchTree search = searchTreeOf(file);
  shape.centre = centreOf(search.inner[0]) + origin;
  CompiledLeaves leaves = compileLeaves(file, search, shape.centre);
  shape.leaves = std::move(leaves.tree);
  shape.nodes = std::move(leaves.nodes);
  shape.radius = static_cast<double>(search.inner[0].radius);
  shape.overhang = file.statistics.back().overhang_bound;
  if (has_skin && !file.skin.empty()) {
    shape.skin = compileSkin(file.skin, origin - shape.centre);
    if (has_hulls) shape.skin.ways = hullWays(file.skin, shape.skin.patch);
    shape.mesh_distance = file.skin.mesh_distance;
    const Sphere& root = file.skin.search.inner[0];
    shape.radius = std::max(shape.radius, (centreOf(root) + origin - shape.centre).norm() + static_cast<double>(root.radius));
  }
  return shape;
}

// Places objects; their shapes are compiled when they are first used.
class ObjectPlacer {
 public:
  ObjectPlacer(const SceneDescription& description, CompiledScene& out) : description_(description), out_(out) {}

  std::string place(const SceneObject& object) {
    if (!isFinite(object.pose)) return "the pose is not finite or its quaternion is null";
    if (object.body > kMaxBodies) return "its body is " + std::to_string(object.body) + "; at most " + std::to_string(kMaxBodies);
    if (!inRange(object.friction, 0, kMaxFriction)) return "its friction is not within 0 .. 2";
    if (object.stiffness != 0 && !inRange(object.stiffness, 1e-6, 1e6)) return "its stiffness is neither 0 nor within 1e-6 .. 1e6 N/mm";
    if (object.tissue && &*object.tissue->tree != &*object.tree) return "its tissue is that of another tree";
    if (object.tissue && object.stiffness > 0) return "it has both tissue and a stiffness";
    if (std::string why = faultInCut(object); !why.empty()) return why;
    const void* const what = object.tissue ? static_cast<const void*>(object.tissue.get())
                             : object.cut  ? static_cast<const void*>(object.cut.get())
                                           : &*object.tree;
    std::uint32_t known = 0;
    while (known < out_.shapes.size() && out_.shapes[known].of != what) ++known;
    if (known == out_.shapes.size()) {
      if (!object.tree.isSound())
        if (std::string why = findFault(*object.tree); !why.empty()) return why;
      out_.shapes.push_back(compileShape(*object.tree, description_.contact == ContactSurface::Skin || object.tissue, !out_.hulls.empty()));
      out_.shapes.back().of = what;
      out_.shapes.back().tissue = object.tissue;
      if (object.tissue) out_.make_tissue = object.tissue->make;
      out_.shapes.back().cut = object.cut;
      if (object.cut && !description_.burr.empty()) out_.make_cutting = object.cut->make;
    }
    const CompiledShape& shape = out_.shapes[known];
    const CompiledObject placed = out_.placed(known, object.body, object.pose);
    const double reach = std::max({shape.leaves.reach, shape.skin.tree.reach, shape.radius});
    if (!(placed.anchor.norm() <= kFarthest && reach <= kFarthest)) return "it reaches farther than 1e7 mm from the origin of the world";
    out_.objects_reach = std::max(out_.objects_reach, reach);
    out_.objects.push_back(placed);
    CompiledObject& kept = out_.objects.back();
    kept.friction = std::max(object.friction, description_.tool_friction);
    kept.softness = object.stiffness > 0 ? std::sqrt(out_.pull.translation / object.stiffness) : 0;
    out_.has_friction = out_.has_friction || kept.friction > 0;
    out_.has_soft = out_.has_soft || kept.softness > 0 || object.tissue;
    out_.body_count = std::max(out_.body_count, object.body + 1);
    return {};
  }

 private:
  std::string faultInCut(const SceneObject& object) const {
    if (!object.cut) return {};
    if (&*object.cut->tree != &*object.tree) return "its material is that of another tree";
    if (object.tissue || object.stiffness > 0) return "what is cut can neither be tissue nor give way; remove its stiffness";
    if (description_.contact != ContactSurface::Skin) return "what is cut is felt as its skin, not as its leaves";
    return {};
  }

  const SceneDescription& description_;
  CompiledScene& out_;
};

// Hulls are for skins and leaves that stay as they are: on tissue and what is cut the tool rests with its leaves.
bool usesHulls(const SceneDescription& d) {
  return d.contact == ContactSurface::Skin && std::ranges::none_of(d.objects, [](const SceneObject& o) { return o.tissue || o.cut; });
}

std::string compileTool(const SceneDescription& d, CompiledScene& out) {
  if (std::string why = findFault(d.tool); !why.empty()) return why;
  if (!d.reference_point.allFinite()) return "the reference point is not finite";
  CompiledLeaves leaves = compileLeaves(d.tool, searchTreeOf(d.tool), d.reference_point);
  out.tool = std::move(leaves.tree);
  out.tool_nodes = std::move(leaves.nodes);
  const Sphere& root = out.tool.spheres[0];
  out.tool_root = centreOf(root);
  out.tool_root_radius = static_cast<double>(root.radius);
  out.tool_overhang = d.tool.statistics.back().overhang_bound;
  if (usesHulls(d)) out.hulls = compileHulls(d.tool.hulls, Eigen::Vector3d(d.tool.origin_mm.data()) - d.reference_point);
  if (!out.hulls.empty()) {
    const Sphere& around = out.hulls.ball[0];
    out.tool_root_radius = std::max(out.tool_root_radius, (centreOf(around) - out.tool_root).norm() + double{around.radius} * (1 + 1e-6));
    out.tool.reach = std::max(out.tool.reach, out.hulls.tree.reach);
  }
  if (!(out.tool.reach <= kFarthest))
    return "a sphere is " + std::to_string(out.tool.reach) + " mm from the reference point; at most 1e7 mm";
  return {};
}

// The connected parts of the tool, from its leaves. Leaves are connected if they overlap by more than `least`.
// out.tool_parts: (slot) the part of a leaf.
void findToolParts(double least, CompiledScene& out) {
  std::vector<std::uint32_t> leaves, root(out.tool.spheres.size());
  for (std::uint32_t slot = 0; slot < root.size(); ++slot) {
    root[slot] = slot;
    if (out.tool.item[slot] != kNoItem) leaves.push_back(slot);
  }
  const auto rootOf = [&](std::uint32_t slot) {
    while (root[slot] != slot) slot = root[slot] = root[root[slot]];
    return slot;
  };
  const auto& spheres = out.tool.spheres;
  const auto begin = [&](std::uint32_t slot) { return spheres[slot].x - spheres[slot].radius; };
  std::sort(leaves.begin(), leaves.end(), [&](std::uint32_t a, std::uint32_t b) { return begin(a) < begin(b); });
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Sphere& a = spheres[leaves[i]];
    for (std::size_t j = i + 1; j < leaves.size() && begin(leaves[j]) < a.x + a.radius; ++j) {
      const Sphere& b = spheres[leaves[j]];
      const double reach = static_cast<double>(a.radius) + static_cast<double>(b.radius) - least;
      if (reach > 0 && (centreOf(a) - centreOf(b)).squaredNorm() < reach * reach) root[rootOf(leaves[j])] = rootOf(leaves[i]);
    }
  }
  out.tool_parts = std::vector<std::uint32_t>(root.size());
  std::vector<std::uint32_t> number(root.size(), kNoItem);
  for (const std::uint32_t slot : leaves) {
    std::uint32_t& part = number[rootOf(slot)];
    if (part == kNoItem) part = out.tool_part_count++;
    out.tool_parts[slot] = part;
  }
}

std::string faultInBurr(const SceneDescription& d) {
  if (d.burr.size() > kMaxBurrBalls) return "a burr has at most " + std::to_string(kMaxBurrBalls) + " balls";
  for (const Ball& ball : d.burr)
    if (!(ball.centre.allFinite() && ball.radius >= kLeastBurr && ball.radius <= kLargestBurr))
      return "the radius of a ball of the burr is not within 0.1 .. 10 mm";
  if (!(d.spindle_axis.allFinite() && d.spindle_axis.norm() > 1e-6)) return "the axis of the spindle has no direction";
  return {};
}

// A ball that meets no leaf of the tool was most likely given in another frame.
std::string faultInBurrPlace(const SceneDescription& d, const CompiledScene& scene) {
  for (std::size_t i = 0; i < d.burr.size(); ++i) {
    double gap = std::numeric_limits<double>::infinity();
    for (std::size_t slot = 0; slot < scene.tool.spheres.size(); ++slot) {
      const Sphere& leaf = scene.tool.spheres[slot];
      if (scene.tool.item[slot] == kNoItem) continue;
      gap = std::min(gap, (centreOf(leaf) - (d.burr[i].centre - d.reference_point)).norm() - double{leaf.radius} - d.burr[i].radius);
    }
    if (gap > 0)
      return "ball " + std::to_string(i) + " of the burr is " + std::to_string(gap) + " mm away from the tool; give it in the tool's frame";
  }
  return {};
}

// The balls of the burr follow the leaves. A leaf is of the burr if it is within a ball, larger by what the mesh is
// smaller than the ball, and by twice what leaves reach out of the mesh: if a leaf covers the whole ball, and its
// centre is by e nearer to the shank, it reaches 2 e into the shank, but at least e (1 + cos a) out of the mesh beside
// it, where a is half of the angle at which the shank is seen, at most 90 degrees.
void addBurr(const SceneDescription& d, CompiledScene& out) {
  out.spindle_axis = d.spindle_axis.normalized();
  CompiledTree& tool = out.tool;
  out.burr_slot = static_cast<std::uint32_t>(tool.spheres.size());
  out.burr_of.assign(tool.spheres.size() + d.burr.size(), kNoItem);
  for (const Ball& exact : d.burr) {
    const auto number = static_cast<std::uint32_t>(out.burr.size());
    const Eigen::Vector3d centre = exact.centre - d.reference_point;
    const Sphere ball{static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()),
                      static_cast<float>(exact.radius)};
    const double radius = double{ball.radius} + std::max(kBurrMargin * double{ball.radius},
                                                         out.tool_overhang < ball.radius ? 2 * double{out.tool_overhang} : 0.0);
    std::uint32_t item = 0;
    for (std::uint32_t slot = 0; slot < out.burr_slot; ++slot) {
      const Sphere& leaf = tool.spheres[slot];
      if (tool.item[slot] == kNoItem || (centreOf(leaf) - centreOf(ball)).norm() + double{leaf.radius} > radius) continue;
      out.burr_of[slot] = number;
      item = tool.item[slot];
    }
    out.burr.push_back(ball);
    tool.spheres.push_back(ball);
    tool.exact.push_back({centre.x(), centre.y(), centre.z()});
    tool.item.push_back(item);
    out.tool_parts.push_back(0);
    tool.reach = std::max(tool.reach, centre.norm() + double{ball.radius});
    tool.smallest_radius = std::min(tool.smallest_radius, ball.radius);
  }
  for (std::uint32_t slot = 0; slot < out.burr_slot; ++slot)
    if (tool.item[slot] != kNoItem && out.burr_of[slot] == kNoItem) out.wall_slots.push_back(slot);
  for (std::uint32_t slot = out.burr_slot; slot < tool.spheres.size(); ++slot) out.wall_slots.push_back(slot);
}

// A burr within a leaf that is also one of the shank would never touch anything.
std::string faultInBurrLeaves(const CompiledScene& scene) {
  for (const std::uint32_t slot : scene.wall_slots)
    for (std::size_t i = 0; i < scene.burr.size() && slot < scene.burr_slot; ++i) {
      const Sphere &leaf = scene.tool.spheres[slot], &ball = scene.burr[i];
      if ((centreOf(leaf) - centreOf(ball)).norm() + double{ball.radius} <= double{leaf.radius})
        return "a leaf of the tool holds ball " + std::to_string(i) +
               " of the burr and some of what does not cut; build the tool's tree with more leaves or a smaller tolerance";
    }
  return {};
}

// A ball is kept from leaves at the sum of two radii, and from a skin at its own radius minus the allowance, but at
// least at half of its radius.
double minContact(const CompiledScene& scene) {
  const auto tool = static_cast<double>(scene.hulls.empty() ? scene.tool.smallest_radius
                                                            : std::min(scene.tool.smallest_radius, scene.hulls.smallest_radius));
  double smallest = std::numeric_limits<double>::infinity();
  for (const CompiledShape& shape : scene.shapes)
    smallest = std::min(smallest, shape.skin.empty() ? tool + static_cast<double>(shape.leaves.smallest_radius) : 0.5 * tool);
  return smallest;
}

}  // namespace

void CompiledScene::couple(const Coupling& other) {
  const double before = pull.translation;
  coupling = other;
  const double by_mass = 1e-3 / (step_time * step_time);  // 1 kg mm/s^2 is 1e-3 N, 1 kg mm^2/s^2 is 1e-3 N mm
  inertia = {by_mass * coupling.mass, by_mass * coupling.inertia};
  pull.translation = coupling.translation + coupling.damping / step_time + inertia.translation;
  pull.rotation = coupling.rotation + coupling.rotation_damping / step_time + inertia.rotation;
  angle_length = std::sqrt(pull.rotation / pull.translation);
  for (CompiledObject& object : objects) object.softness *= std::sqrt(pull.translation / before);
}

CompiledObject CompiledScene::placed(std::uint32_t shape, std::uint32_t body, const Configuration& pose) const {
  CompiledObject object;
  object.shape = shape;
  object.body = body;
  object.rotation = pose.orientation.normalized().toRotationMatrix();
  object.anchor = object.rotation * shapes[shape].centre + pose.position;
  return object;
}

bool compileScene(const SceneDescription& d, Scene& scene, std::string& fault) {
  fault = faultInSettings(d);
  if (fault.empty()) fault = faultInBurr(d);
  if (!fault.empty()) return false;
  auto out = std::make_unique<CompiledScene>();
  out->wrench_limits = d.wrench_limits;
  out->step_limits = d.step_limits;
  out->step_time = d.step_time;
  out->couple(d.coupling);
  if (const std::string why = compileTool(d, *out); !why.empty()) {
    fault = "tool: " + why;
    return false;
  }
  ObjectPlacer placer(d, *out);
  for (std::size_t i = 0; i < d.objects.size(); ++i)
    if (const std::string why = placer.place(d.objects[i]); !why.empty()) {
      fault = "object " + std::to_string(i) + ": " + why;
      return false;
    }
  for (const CompiledShape& shape : out->shapes) out->skin_tolerance = std::max(out->skin_tolerance, shape.skin.tolerance);
  out->min_contact = minContact(*out);
  findToolParts(2 * (static_cast<double>(out->skin_tolerance) + kGapTolerance), *out);
  if (out->make_cutting) {
    fault = faultInBurrPlace(d, *out);
    if (!fault.empty()) return false;
    addBurr(d, *out);
    fault = faultInBurrLeaves(*out);
    if (!fault.empty()) return false;
  }
  scene = Scene(std::move(out));
  return true;
}

Scene::Scene() : Scene(std::make_unique<CompiledScene>()) {}
Scene::Scene(std::unique_ptr<CompiledScene> compiled) : compiled_(std::move(compiled)) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

std::size_t Scene::objectCount() const { return compiled_->objects.size(); }
std::size_t Scene::bodyCount() const { return compiled_->body_count; }
std::size_t Scene::cutLayers(std::size_t object) const {
  const CutModel* const cut = compiled_->shapeOf(object).cut.get();
  return cut ? 1 + cut->material.inner.size() : 0;
}
const Coupling& Scene::coupling() const { return compiled_->coupling; }
const WrenchLimits& Scene::wrenchLimits() const { return compiled_->wrench_limits; }
const StepLimits& Scene::stepLimits() const { return compiled_->step_limits; }

std::size_t Scene::byteCount() const {
  const CompiledScene& s = *compiled_;
  std::size_t bytes = sizeof s + s.tool.byteCount() + s.tool_parts.size() * 4 + s.objects.size() * sizeof(CompiledObject);
  for (const CompiledShape& b : s.shapes) {
    if (b.tissue) bytes += b.tissue->bytes;
    bytes += sizeof b + b.leaves.byteCount() + b.skin.tree.byteCount() + b.skin.patch.size() * sizeof(CompiledPatch) +
             b.skin.far.size() * sizeof(FarFace) + b.nodes.size() * 4;
  }
  return bytes;
}

}  // namespace spheretree::runtime
