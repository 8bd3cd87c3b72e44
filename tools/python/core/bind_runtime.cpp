// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "python_types.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/runtime/step.h"
#include "spheretree/scene/describe_scene.h"

namespace spheretree::python {
namespace {

using ScenePointer = std::shared_ptr<runtime::Scene>;

ScenePointer compiled(const runtime::SceneDescription& description) {
  auto scene = std::make_shared<runtime::Scene>();
  std::string fault;
  if (!compileScene(description, *scene, fault)) throw std::invalid_argument(fault);
  return scene;
}

runtime::ContactSurface surfaceNamed(const std::string& name) {
  if (name == "skin") return runtime::ContactSurface::Skin;
  if (name == "leaves") return runtime::ContactSurface::Leaves;
  throw py::value_error("contact must be skin or leaves, not " + name + ".");
}

/// A tree of Python, or the path of a .stree or .soft file.
scene::LoadedTree treeFrom(const py::handle& tree, const std::string& where) {
  if (py::isinstance<PythonTree>(tree)) return {tree.cast<const PythonTree&>().shared()};
  if (!py::isinstance<py::str>(tree) && !py::hasattr(tree, "__fspath__"))
    throw py::type_error(where + " must be a SphereTree, or the path of a .stree or .soft file.");
  const auto path = tree.cast<std::filesystem::path>();
  return scene::parseTree(formats::readFile(path, formats::kMaxSoftBytes), path.string());
}

template <class Number>
Number numberFrom(const py::handle& value, const std::string& where) {
  try {
    return value.cast<Number>();
  } catch (const py::cast_error&) {
    throw py::type_error(where + " must be a number, and a body one of 0 and more.");
  }
}

/// From a dictionary with the keys of an object in a scene file, except that tree may be a SphereTree, and pose is one
/// value.
runtime::SceneObject objectFrom(const py::dict& entry, const std::string& where) {
  runtime::SceneObject object;
  bool has_tree = false;
  for (const auto& [key, value] : entry) {
    const auto name = py::str(key).cast<std::string>();
    if (name == "tree") {
      scene::LoadedTree loaded = treeFrom(value, where + "[\"tree\"]");
      object.tree = std::move(loaded.tree);
      object.tissue = std::move(loaded.tissue);
      has_tree = true;
    } else if (name == "pose") {
      object.pose = poseFrom(value);
    } else if (name == "body") {
      object.body = numberFrom<std::uint32_t>(value, where + "[\"body\"]");
    } else if (name == "friction") {
      object.friction = numberFrom<double>(value, where + "[\"friction\"]");
    } else if (name == "stiffness") {
      object.stiffness = numberFrom<double>(value, where + "[\"stiffness\"]");
    } else {
      throw py::value_error(where + " has the key " + name + "; the keys are tree, pose, body, friction and stiffness.");
    }
  }
  if (!has_tree) throw py::value_error(where + " has no tree.");
  return object;
}

runtime::SceneObject objectFrom(const py::handle& entry, const std::string& where) {
  if (py::isinstance<py::dict>(entry)) return objectFrom(entry.cast<py::dict>(), where);
  runtime::SceneObject object;
  const bool is_pair = py::isinstance<py::sequence>(entry) && !py::isinstance<py::str>(entry) && py::len(entry) == 2;
  const py::object tree = is_pair ? py::object(entry[py::int_(0)]) : py::reinterpret_borrow<py::object>(entry);
  if (!py::isinstance<PythonTree>(tree))
    throw py::type_error("objects must be SphereTree, (SphereTree, pose), or a dict; " + where + " is none of these.");
  object.tree = tree.cast<const PythonTree&>().shared();
  if (is_pair) object.pose = poseFrom(entry[py::int_(1)]);
  return object;
}

runtime::SceneDescription readDescription(const formats::SceneFile& file, const std::filesystem::path& path) {
  const py::gil_scoped_release release;
  return scene::describeScene(file, path);
}

ScenePointer loadScene(const py::object& source) {
  runtime::SceneDescription description;
  if (py::isinstance<py::dict>(source)) {
    const auto text = py::module_::import("json").attr("dumps")(source).cast<std::string>();
    description = readDescription(formats::parseScene(text, "the scene"), "scene.json");
  } else {
    const std::filesystem::path path = scene::sceneFileAt(source.cast<std::filesystem::path>());
    description = readDescription(formats::readScene(path), path);
  }
  const py::gil_scoped_release release;
  return compiled(description);
}

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}
std::string shown(const Eigen::Vector3d& v) { return "(" + shown(v.x()) + ", " + shown(v.y()) + ", " + shown(v.z()) + ")"; }

/// One step, and the contacts at its end.
struct PythonStep {
  runtime::StepResult result;
  std::vector<runtime::Contact> contacts;
};

class Renderer {
 public:
  Renderer(ScenePointer scene, runtime::Mode mode) : scene_(std::move(scene)), mode_(mode), workspace_(*scene_) {}
  PythonStep step(const py::handle& pose) {
    PythonStep out{runtime::step(*scene_, poseFrom(pose), mode_, workspace_), {}};
    const std::span<const runtime::Contact> held = runtime::contacts(workspace_);
    out.contacts.assign(held.begin(), held.end());
    return out;
  }
  void moveObject(std::size_t object, const py::handle& pose) {
    if (!runtime::moveObject(object, poseFrom(pose), workspace_))
      throw py::value_error("object " + std::to_string(object) + " cannot be moved: the scene has " +
                            std::to_string(scene_->objectCount()) +
                            " objects, counted from 0, and a pose must be finite and within 1e7 mm.");
  }
  void moveBody(std::uint32_t body, const py::handle& pose) {
    if (!runtime::moveBody(body, poseFrom(pose), workspace_))
      throw py::value_error("body " + std::to_string(body) + " cannot be moved: bodies count from 1 in the order of the scene file, one " +
                            "that carries nothing is not known, and a pose must be finite and within 1e7 mm.");
  }
  void setActive(std::size_t object, bool is_active) {
    if (!runtime::setActive(object, is_active, workspace_)) throw py::index_error(noObject(object));
  }
  void setSpindle(bool turns) {
    if (!runtime::setSpindle(turns, workspace_)) throw py::value_error("the scene has no burr, or no object with `cut`.");
  }
  std::vector<double> removed(std::size_t object) const {
    if (object >= scene_->objectCount()) throw py::index_error(noObject(object));
    const runtime::CutState state = runtime::cutState(object, workspace_);
    return {state.removed.begin(), state.removed.begin() + static_cast<std::ptrdiff_t>(scene_->cutLayers(object))};
  }
  void mend() { runtime::mend(workspace_); }
  py::array_t<double> objectPose(std::size_t object) const {
    if (object >= scene_->objectCount()) throw py::index_error(noObject(object));
    return arrayOf(runtime::objectPose(object, workspace_));
  }
  runtime::Distance distance(std::size_t object, const py::handle& pose, double limit) const {
    if (object >= scene_->objectCount()) throw py::index_error(noObject(object));
    runtime::Distance found;
    if (!runtime::distance(object, poseFrom(pose), limit, workspace_, found))
      throw py::value_error("pose and limit must be finite numbers.");
    return found;
  }
  void reset(const py::object& pose) {
    if (pose.is_none())
      runtime::reset(workspace_);
    else
      runtime::resetTo(poseFrom(pose), workspace_);
  }

 private:
  std::string noObject(std::size_t object) const {
    return "there is no object " + std::to_string(object) + ": the scene has " + std::to_string(scene_->objectCount()) +
           ", counted from 0.";
  }

  ScenePointer scene_;
  runtime::Mode mode_;
  runtime::Workspace workspace_;
};

void bindScene(py::module_& module) {
  const runtime::SceneDescription defaults;
  const auto torque =
      py::make_tuple(defaults.wrench_limits.torque.x(), defaults.wrench_limits.torque.y(), defaults.wrench_limits.torque.z());
  py::class_<runtime::Scene, ScenePointer>(module, "Scene", "A tool and objects at their poses, compiled for steps. It is immutable.")
      .def(py::init([](const PythonTree& tool, const py::sequence& objects, const py::object& reference_point, double stiffness,
                       double rotational_stiffness, double damping, double rotational_damping, double mass, double inertia,
                       double tool_friction, double force_limit, const py::object& torque_limit, const std::string& contact,
                       double step_time) {
             runtime::SceneDescription d;
             d.tool = *tool;
             d.reference_point = vectorFrom(reference_point, "reference_point");
             d.tool_friction = tool_friction;
             for (const py::handle entry : objects)
               d.objects.push_back(objectFrom(entry, "objects[" + std::to_string(d.objects.size()) + "]"));
             d.coupling = {stiffness, rotational_stiffness, damping, rotational_damping, mass, inertia};
             d.wrench_limits = {force_limit, vectorFrom(torque_limit, "torque_limit")};
             d.step_limits = runtime::defaultLimits(d.objects.size());
             d.contact = surfaceNamed(contact);
             d.step_time = step_time;
             const py::gil_scoped_release release;
             return compiled(d);
           }),
           py::arg("tool"), py::arg("objects"), py::kw_only(), py::arg("reference_point") = py::make_tuple(0.0, 0.0, 0.0),
           py::arg("stiffness") = defaults.coupling.translation, py::arg("rotational_stiffness") = defaults.coupling.rotation,
           py::arg("damping") = 0.0, py::arg("rotational_damping") = 0.0, py::arg("mass") = 0.0, py::arg("inertia") = 0.0,
           py::arg("tool_friction") = 0.0, py::arg("force_limit") = defaults.wrench_limits.force, py::arg("torque_limit") = torque,
           py::arg("contact") = "skin", py::arg("step_time") = defaults.step_time,
           R"(Compiles a scene.

tool: the tree of the tool. objects: trees, pairs (tree, pose), or dicts {"tree": tree or path of a .stree or .soft file,
"pose": pose, "friction": 0 .. 2, "stiffness": N/mm of an object that yields, "body": number of the body that moves it};
only the tree is needed. A .soft file is soft tissue. A pose takes the frame of the object's mesh to the world and has the
shape (3,), a position, (7,), x y z qw qx qy qz, or (4, 4), a rigid matrix [mm].
reference_point: of the tool, in the frame of its mesh (3,) [mm]. stiffness [N/mm] and rotational_stiffness [N mm/rad] of
the spring between hand and tool, > 0; damping [N s/mm] and rotational_damping [N mm s/rad] beside it; mass [kg] and inertia
[kg mm^2] of the tool. tool_friction: 0 .. 2; a contact uses the larger coefficient.
force_limit [N] and torque_limit (3,) [N mm] of what is rendered, > 0. contact: "skin", the smooth surface of each object
that has one, or "leaves". step_time: from one step to the next [s].
Raises ValueError or TypeError that names the part which is wrong, FileError, FormatError.)")
      .def_static("load", &loadScene, py::arg("source"),
                  R"(Reads and compiles a scene with all that a scene file can hold: friction, soft tissue, bodies, limits.

source: path of the scene.json that `spheretree batch` wrote, or of its folder; or a dict with the keys of a scene file
(docs/scene_file.md), whose items are trees. Paths in a dict are relative to the working directory.
Raises FileError, FormatError, ValueError.)")
      .def("__len__", &runtime::Scene::objectCount)
      .def_property_readonly("byte_count", &runtime::Scene::byteCount, "Memory that the compiled scene holds [bytes].")
      .def("__repr__",
           [](const runtime::Scene& scene) { return "<spheretree.Scene: " + std::to_string(scene.objectCount()) + " objects>"; });
}

void bindContact(py::module_& module) {
  using runtime::Contact;
  py::class_<Contact>(module, "Contact", "A contact of the graphic tool.")
      .def_readonly("object", &Contact::object, "Index of the object in the scene.")
      .def_readonly("tool_leaf", &Contact::tool_leaf, "Node of the tool's tree; if it rests with its hulls: their part.")
      .def_readonly("on_skin", &Contact::on_skin, "True if it is on the skin of the object, false if on one of its leaves.")
      .def_readonly("element", &Contact::element, "Triangle of the object's skin, or node of its tree.")
      .def_property_readonly(
          "point", [](const Contact& c) { return arrayOf(c.point); }, "Shape (3,): world [mm].")
      .def_property_readonly(
          "normal", [](const Contact& c) { return arrayOf(c.normal); }, "Shape (3,): from object to tool, unit length, world axes.")
      .def_readonly("force", &Contact::force, "Along the normal, on the tool [N].")
      .def_property_readonly(
          "friction", [](const Contact& c) { return arrayOf(c.friction); }, "Shape (3,): across the normal, on the tool, world axes [N].")
      .def_property_readonly(
          "slip", [](const Contact& c) { return arrayOf(c.slip); },
          "Shape (3,): velocity of the tool's point across the object, world axes [mm/s].")
      .def("__repr__", [](const Contact& c) {
        return "<spheretree.Contact: object " + std::to_string(c.object) + ", " + (c.on_skin ? "triangle " : "leaf ") +
               std::to_string(c.element) + ", at " + shown(c.point) + " mm, " + shown(c.force) + " N>";
      });
}

void bindStep(py::module_& module) {
  py::class_<PythonStep>(module, "Step", "The result of one servo step.")
      .def_property_readonly(
          "graphic_tool", [](const PythonStep& s) { return arrayOf(s.result.graphic); },
          "Shape (7,): x y z qw qx qy qz of the reference point of the graphic tool, which stays outside [mm].")
      .def_property_readonly(
          "force", [](const PythonStep& s) { return arrayOf(s.result.limited_wrench.force); },
          "Shape (3,): to render to the hand, within force_limit, world axes [N].")
      .def_property_readonly(
          "torque", [](const PythonStep& s) { return arrayOf(s.result.limited_wrench.torque); },
          "Shape (3,): to render, about the reference point, within torque_limit, world axes [N mm].")
      .def_property_readonly(
          "spring_force", [](const PythonStep& s) { return arrayOf(s.result.wrench.force); }, "Shape (3,): without the limit [N].")
      .def_property_readonly(
          "spring_torque", [](const PythonStep& s) { return arrayOf(s.result.wrench.torque); }, "Shape (3,): without the limit [N mm].")
      .def_property_readonly(
          "penetration", [](const PythonStep& s) { return s.result.penetration; },
          "Penetration of the graphic tool into the guaranteed surface; constrained mode [mm].")
      .def_property_readonly(
          "faults", [](const PythonStep& s) { return s.result.faults; }, "Bits of spheretree.Fault; 0: no fault.")
      .def_property_readonly(
          "pairs", [](const PythonStep& s) { return s.result.pairs; }, "Pairs of leaves of the last search.")
      .def_readonly("contacts", &PythonStep::contacts, "Contacts that hold the graphic tool, at most 24; their forces balance the spring.")
      .def("__repr__", [](const PythonStep& s) {
        std::string text = "<spheretree.Step: tool at " + shown(s.result.graphic.position) + " mm, force " +
                           shown(s.result.limited_wrench.force) + " N, " + std::to_string(s.contacts.size()) +
                           (s.contacts.size() == 1 ? " contact" : " contacts");
        if (s.result.faults != 0) text += ", faults " + std::to_string(s.result.faults);
        return text + ">";
      });
  using runtime::Distance;
  py::class_<Distance>(module, "Distance", "The distance of the tool from an object, with proven bounds (docs/runtime.md).")
      .def_readonly("lower", &Distance::lower, "No point of the tool's mesh is nearer to the mesh of the object [mm].")
      .def_readonly("upper", &Distance::upper,
                    "Two points of the solids are at most this far apart [mm]; infinite if nothing is proven, or beyond the limit.")
      .def_property_readonly(
          "on_tool", [](const Distance& d) { return arrayOf(d.on_tool); },
          "Shape (3,): the nearest point of the tool's leaves, world [mm].")
      .def_property_readonly(
          "on_object", [](const Distance& d) { return arrayOf(d.on_object); },
          "Shape (3,): the nearest point of the object's skin, or of its leaves if it has none, world [mm].")
      .def("__repr__", [](const Distance& d) { return "<spheretree.Distance: " + shown(d.lower) + " to " + shown(d.upper) + " mm>"; });
}

}  // namespace

void bindRuntime(py::module_& module) {
  bindScene(module);
  bindContact(module);
  bindStep(module);
  py::class_<Renderer>(module, "Renderer",
                       "Computes wrench and contacts of a scene from the pose of the hand, step by step. It keeps its state between steps.")
      .def(py::init([](ScenePointer scene, const std::string& mode) {
             if (mode != "constrained" && mode != "paper") throw py::value_error("mode must be constrained or paper, not " + mode + ".");
             return std::make_unique<Renderer>(std::move(scene), mode == "paper" ? runtime::Mode::Published : runtime::Mode::Constrained);
           }),
           py::arg("scene"), py::arg("mode") = "constrained",
           R"(mode: "constrained", where the graphic tool never passes through anything, or "paper", the published algorithm.)")
      .def("step", &Renderer::step, py::arg("pose"), R"(One servo step of the runtime, which takes microseconds.

pose: of the haptic tool's reference point in the world: shape (3,), (7,) as x y z qw qx qy qz, or (4, 4) [mm].
The first step, and the first after reset(), puts the graphic tool at the pose. A pose that is not finite is no error:
the tool rests, the wrench decays, and `faults` says so.
Raises ValueError for another shape.)")
      .def("move_object", &Renderer::moveObject, py::arg("object"), py::arg("pose"),
           "Moves an object to another pose for the following steps, without the tool. Raises ValueError.")
      .def("move_body", &Renderer::moveBody, py::arg("body"), py::arg("pose"),
           R"(Moves a body, such as a jaw, to a pose during the next step: it pushes the tool ahead and never passes through it.

body: 1 for the first of the scene file. pose: displacement of its objects from their poses in the scene,
shapes as for step() [mm]. Raises ValueError.)")
      .def("set_active", &Renderer::setActive, py::arg("object"), py::arg("active"),
           R"(Switches an object off or on: one that is off is not felt and costs no work.

Switched on where the tool is, it pushes the tool out; nothing passes through it from the first free pose. Raises IndexError.)")
      .def("set_spindle", &Renderer::setSpindle, py::arg("turns"),
           R"(Switches the spindle of the burr on or off; it rests at the beginning. While it turns, the burr removes material.

Raises ValueError if the scene has nothing to cut.)")
      .def("removed", &Renderer::removed, py::arg("object"),
           R"(The volume that was removed of each layer of an object, the outermost first [mm^3]. Empty if no burr cuts it.

Raises IndexError.)")
      .def("mend", &Renderer::mend, "Makes all material whole again; reset() does not.")
      .def("object_pose", &Renderer::objectPose, py::arg("object"),
           "Shape (7,): x y z qw qx qy qz, where the frame of an object's mesh is now in the world [mm]. Raises IndexError.")
      .def("distance", &Renderer::distance, py::arg("object"), py::arg("pose"), py::arg("limit") = std::numeric_limits<double>::infinity(),
           R"(The Distance of the tool, with its reference point at `pose`, from an object where it is now.

pose: shapes as for step() [mm]. limit [mm]: if nothing is nearer, `lower` is the limit; a small one is quicker.
Raises IndexError, ValueError.)")
      .def("reset", &Renderer::reset, py::arg("pose") = py::none(),
           "Forgets the last step. The graphic tool starts at `pose`, which should be free, or at the next pose of the hand.");
  py::object int_flag = py::module_::import("enum").attr("IntFlag");
  py::dict faults;
  faults["PAIRS_FULL"] = static_cast<int>(runtime::kPairsFull);
  faults["WORK_LIMIT"] = static_cast<int>(runtime::kWorkLimit);
  faults["QP_STOPPED"] = static_cast<int>(runtime::kQpStopped);
  faults["ROWS_CONFLICT"] = static_cast<int>(runtime::kRowsConflict);
  faults["PENETRATING"] = static_cast<int>(runtime::kPenetrating);
  faults["BAD_INPUT"] = static_cast<int>(runtime::kBadInput);
  faults["TISSUE_FROZEN"] = static_cast<int>(runtime::kTissueFrozen);
  module.attr("Fault") = int_flag("Fault", faults, py::arg("module") = "spheretree");
}

}  // namespace spheretree::python
