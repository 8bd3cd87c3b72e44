// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/runtime.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <string>
#include <utility>

#include "c_handles.h"
#include "spheretree/core/sphere_tree_codec.h"

namespace rt = spheretree::runtime;
using rt::fromC, rt::guarded, rt::noObject, rt::toC;

static_assert(ST_PAIRS_FULL == int{rt::kPairsFull} && ST_WORK_LIMIT == int{rt::kWorkLimit} && ST_QP_STOPPED == int{rt::kQpStopped} &&
              ST_ROWS_CONFLICT == int{rt::kRowsConflict} && ST_PENETRATING == int{rt::kPenetrating} && ST_BAD_INPUT == int{rt::kBadInput});
static_assert(ST_SKIN == static_cast<int>(rt::ContactSurface::Skin) && ST_LEAVES == static_cast<int>(rt::ContactSurface::Leaves) &&
              ST_MAX_CONTACTS == rt::kMaxContacts);
static_assert(ST_CONSTRAINED == static_cast<int>(rt::Mode::Constrained) && ST_PAPER == static_cast<int>(rt::Mode::Published));

namespace {

st_wrench wrenchToC(const spheretree::Wrench& w) {
  return {{w.force.x(), w.force.y(), w.force.z()}, {w.torque.x(), w.torque.y(), w.torque.z()}};
}

std::string decode(const char* what, const void* bytes, size_t size, spheretree::SphereTree& tree) {
  if (!bytes) return std::string(what) + ": no bytes were given";
  std::string fault;
  const spheretree::LoadStatus status = spheretree::decodeSphereTree({static_cast<const std::byte*>(bytes), size}, tree, &fault);
  if (status == spheretree::LoadStatus::Ok) return {};
  return std::string(what) + ": " + std::string(spheretree::explain(status)) + (fault.empty() ? "" : " (" + fault + ")");
}

}  // namespace

namespace spheretree::runtime {

int guarded(st_scene* scene, const Work& work) noexcept {
  if (!scene) return -1;
  try {
    scene->error = work();
    return scene->error.empty() ? 0 : -1;
  } catch (const std::exception& error) {
    try {
      scene->error = error.what();
    } catch (...) {
      scene->error.clear();
    }
    return -1;
  }
}

std::string noObject(const char* what, size_t index, const st_scene& scene) {
  return std::string(what) + ": there is no object " + std::to_string(index) + "; the scene has " +
         std::to_string(scene.description.objects.size());
}

}  // namespace spheretree::runtime

extern "C" {

const char* st_version(void) { return SPHERETREE_VERSION; }

st_scene* st_scene_create(void) { return new (std::nothrow) st_scene; }

void st_scene_destroy(st_scene* scene) { delete scene; }

const char* st_scene_error(const st_scene* scene) { return scene ? scene->error.c_str() : "no scene was given"; }

int st_scene_set_tool(st_scene* scene, const void* bytes, size_t size, const double reference_point_mm[3]) {
  return guarded(scene, [&]() -> std::string {
    if (!reference_point_mm) return "tool: no reference point was given";
    std::string fault = decode("tool", bytes, size, scene->description.tool);
    if (fault.empty()) scene->description.reference_point = {reference_point_mm[0], reference_point_mm[1], reference_point_mm[2]};
    return fault;
  });
}

int st_scene_add_object(st_scene* scene, const void* bytes, size_t size, const st_pose* pose) {
  return guarded(scene, [&]() -> std::string {
    if (!pose) return "object: no pose was given";
    rt::SceneObject object;
    object.pose = fromC(*pose);
    const std::string name = "object " + std::to_string(scene->description.objects.size());
    spheretree::SphereTree tree;
    std::string fault = decode(name.c_str(), bytes, size, tree);
    object.tree = rt::SharedTree::sound(std::move(tree));
    if (fault.empty()) scene->description.objects.push_back(std::move(object));
    return fault;
  });
}

int st_scene_add_copy(st_scene* scene, size_t index, const st_pose* pose) {
  return guarded(scene, [&]() -> std::string {
    std::vector<rt::SceneObject>& objects = scene->description.objects;
    if (!pose) return "copy: no pose was given";
    if (index >= objects.size()) return noObject("copy", index, *scene);
    objects.push_back({objects[index].tree, fromC(*pose)});
    return {};
  });
}

int st_scene_set_body(st_scene* scene, size_t object, uint32_t body) {
  return guarded(scene, [&]() -> std::string {
    std::vector<rt::SceneObject>& objects = scene->description.objects;
    if (object >= objects.size()) return noObject("body", object, *scene);
    objects[object].body = body;
    return {};
  });
}

int st_scene_set_tool_friction(st_scene* scene, double coefficient) {
  return guarded(scene, [&]() -> std::string {
    scene->description.tool_friction = coefficient;
    return {};
  });
}

int st_scene_set_friction(st_scene* scene, size_t object, double coefficient) {
  return guarded(scene, [&]() -> std::string {
    if (object >= scene->description.objects.size()) return noObject("friction", object, *scene);
    scene->description.objects[object].friction = coefficient;
    return {};
  });
}

int st_scene_set_stiffness(st_scene* scene, size_t object, double stiffness_n_per_mm) {
  return guarded(scene, [&]() -> std::string {
    if (object >= scene->description.objects.size()) return noObject("stiffness", object, *scene);
    scene->description.objects[object].stiffness = stiffness_n_per_mm;
    return {};
  });
}

int st_scene_set_damping(st_scene* scene, double translation_n_s_per_mm, double rotation_n_mm_s_per_rad) {
  return guarded(scene, [&]() -> std::string {
    scene->description.coupling.damping = translation_n_s_per_mm;
    scene->description.coupling.rotation_damping = rotation_n_mm_s_per_rad;
    return {};
  });
}

int st_scene_set_mass(st_scene* scene, double mass_kg, double inertia_kg_mm2) {
  return guarded(scene, [&]() -> std::string {
    scene->description.coupling.mass = mass_kg;
    scene->description.coupling.inertia = inertia_kg_mm2;
    return {};
  });
}

int st_scene_set_step_time(st_scene* scene, double seconds) {
  return guarded(scene, [&]() -> std::string {
    scene->description.step_time = seconds;
    return {};
  });
}

int st_scene_set_coupling(st_scene* scene, double translation_n_per_mm, double rotation_n_mm_per_rad) {
  return guarded(scene, [&]() -> std::string {
    scene->description.coupling.translation = translation_n_per_mm;
    scene->description.coupling.rotation = rotation_n_mm_per_rad;
    return {};
  });
}

int st_scene_set_wrench_limits(st_scene* scene, double force_n, const double torque_n_mm[3]) {
  return guarded(scene, [&]() -> std::string {
    if (!torque_n_mm) return "wrench limits: no torque limits were given";
    scene->description.wrench_limits = {force_n, {torque_n_mm[0], torque_n_mm[1], torque_n_mm[2]}};
    return {};
  });
}

int st_scene_set_step_limits(st_scene* scene, uint32_t max_pairs, uint32_t max_work) {
  return guarded(scene, [&]() -> std::string {
    scene->description.step_limits = {max_pairs, max_work};
    return {};
  });
}

int st_scene_set_contact(st_scene* scene, int surface) {
  return guarded(scene, [&]() -> std::string {
    if (surface != ST_SKIN && surface != ST_LEAVES)
      return "contact surface " + std::to_string(surface) + " is unknown; ST_SKIN is 0, ST_LEAVES is 1";
    scene->description.contact = static_cast<rt::ContactSurface>(surface);
    return {};
  });
}

st_renderer* st_renderer_create(st_scene* scene, int mode) {
  st_renderer* renderer = nullptr;
  guarded(scene, [&]() -> std::string {
    if (mode != ST_CONSTRAINED && mode != ST_PAPER)
      return "mode " + std::to_string(mode) + " is unknown; ST_CONSTRAINED is 0, ST_PAPER is 1";
    if (scene->description.tool.cover.empty()) return "the scene has no tool; call st_scene_set_tool() first";
    rt::Scene compiled;
    std::string fault;
    if (!rt::compileScene(scene->description, compiled, fault)) return fault;
    renderer = new st_renderer(std::move(compiled), static_cast<rt::Mode>(mode));
    return {};
  });
  return renderer;
}

void st_renderer_destroy(st_renderer* renderer) { delete renderer; }

void st_renderer_step(st_renderer* renderer, const st_pose* haptic_tool, st_step* out) {
  const rt::StepResult result = rt::step(renderer->scene, fromC(*haptic_tool), renderer->mode, renderer->workspace);
  const st_step step = {.struct_size = out->struct_size,
                        .graphic_tool = toC(result.graphic),
                        .wrench = wrenchToC(result.wrench),
                        .limited_wrench = wrenchToC(result.limited_wrench),
                        .penetration_mm = result.penetration,
                        .faults = result.faults,
                        .pairs = result.pairs,
                        .rows = result.rows,
                        .active = result.active,
                        .qp_iterations = result.qp_iterations,
                        .work = result.work};
  std::memcpy(out, &step, std::min(out->struct_size, sizeof step));
}

size_t st_renderer_contacts(const st_renderer* renderer, st_contact* out, size_t capacity) {
  const std::span<const rt::Contact> contacts = rt::contacts(renderer->workspace);
  const size_t stride = capacity > 0 ? out->struct_size : 0;
  for (size_t i = 0; i < std::min(capacity, contacts.size()); ++i) {
    const rt::Contact& c = contacts[i];
    const st_contact contact = {.struct_size = stride,
                                .point_mm = {c.point.x(), c.point.y(), c.point.z()},
                                .normal = {c.normal.x(), c.normal.y(), c.normal.z()},
                                .force_n = c.force,
                                .object = c.object,
                                .on_skin = c.on_skin,
                                .element = c.element,
                                .tool_leaf = c.tool_leaf,
                                .friction_n = {c.friction.x(), c.friction.y(), c.friction.z()},
                                .slip_mm_per_s = {c.slip.x(), c.slip.y(), c.slip.z()}};
    std::memcpy(reinterpret_cast<char*>(out) + i * stride, &contact, std::min(stride, sizeof contact));
  }
  return contacts.size();
}

int st_renderer_move_body(st_renderer* renderer, uint32_t body, const st_pose* pose, const st_velocity* velocity) {
  spheretree::Displacement v;
  if (velocity) v = {Eigen::Vector3d(velocity->mm_per_s), Eigen::Vector3d(velocity->rad_per_s)};
  return pose && rt::moveBody(body, fromC(*pose), renderer->workspace, v) ? 0 : -1;
}

int st_renderer_move_object(st_renderer* renderer, size_t object, const st_pose* pose) {
  return pose && rt::moveObject(object, fromC(*pose), renderer->workspace) ? 0 : -1;
}

int st_renderer_set_active(st_renderer* renderer, size_t object, int is_active) {
  return rt::setActive(object, is_active != 0, renderer->workspace) ? 0 : -1;
}

void st_renderer_reset(st_renderer* renderer, const st_pose* graphic_tool) {
  if (graphic_tool)
    rt::resetTo(fromC(*graphic_tool), renderer->workspace);
  else
    rt::reset(renderer->workspace);
}

}  // extern "C"
