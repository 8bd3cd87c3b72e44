// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "python_types.h"
#include "scene/describe_scene.h"
#include "spheretree/runtime/step.h"

namespace spheretree::python {
namespace {

using ScenePointer = std::shared_ptr<runtime::Scene>;

ScenePointer compiled(const runtime::SceneDescription& description) {
  auto scene = std::make_shared<runtime::Scene>();
  std::string fault;
  if (!compileScene(description, *scene, fault)) throw std::invalid_argument(fault);
  return scene;
}

struct SceneOptions {
  py::object reference_point, force_limit, torque_limit;
  double stiffness, rotational_stiffness;
  std::string contact;
};

runtime::ContactSurface surfaceNamed(const std::string& name) {
  if (name == "skin") return runtime::ContactSurface::Skin;
  if (name == "leaves") return runtime::ContactSurface::Leaves;
  throw py::value_error("contact must be skin or leaves, not " + name + ".");
}

ScenePointer makeScene(const PythonTree& tool, const py::sequence& objects, const SceneOptions& options) {
  runtime::SceneDescription d;
  d.tool = *tool;
  d.reference_point = vectorFrom(options.reference_point, "reference_point");
  for (const py::handle entry : objects) {
    if (py::isinstance<PythonTree>(entry)) {
      d.objects.push_back({entry.cast<const PythonTree&>().shared(), {}});
      continue;
    }
    const bool is_pair = py::isinstance<py::sequence>(entry) && py::len(entry) == 2;
    if (!is_pair || !py::isinstance<PythonTree>(entry[py::int_(0)]))
      throw py::type_error("objects must be SphereTree, or (SphereTree, pose); objects[" + std::to_string(d.objects.size()) +
                           "] is neither.");
    d.objects.push_back({entry[py::int_(0)].cast<const PythonTree&>().shared(), poseFrom(entry[py::int_(1)])});
  }
  d.coupling = {options.stiffness, options.rotational_stiffness};
  d.wrench_limits = {options.force_limit.cast<double>(), vectorFrom(options.torque_limit, "torque_limit")};
  d.step_limits = runtime::defaultLimits(d.objects.size());
  d.contact = surfaceNamed(options.contact);
  const py::gil_scoped_release release;
  return compiled(d);
}

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
  void reset(const py::object& pose) {
    if (pose.is_none())
      runtime::reset(workspace_);
    else
      runtime::resetTo(poseFrom(pose), workspace_);
  }

 private:
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
                       double rotational_stiffness, double force_limit, const py::object& torque_limit, const std::string& contact) {
             return makeScene(tool, objects,
                              {reference_point, py::float_(force_limit), torque_limit, stiffness, rotational_stiffness, contact});
           }),
           py::arg("tool"), py::arg("objects"), py::kw_only(), py::arg("reference_point") = py::make_tuple(0.0, 0.0, 0.0),
           py::arg("stiffness") = defaults.coupling.translation, py::arg("rotational_stiffness") = defaults.coupling.rotation,
           py::arg("force_limit") = defaults.wrench_limits.force, py::arg("torque_limit") = torque, py::arg("contact") = "skin",
           R"(Compiles a scene.

tool: the tree of the tool. objects: trees, or pairs (tree, pose); a pose takes the frame of the object's mesh to the world
and has the shape (3,), a position, (7,), x y z qw qx qy qz, or (4, 4), a rigid matrix [mm].
reference_point: of the tool, in the frame of its mesh (3,) [mm]. stiffness [N/mm] and rotational_stiffness [N mm/rad] of
the spring between hand and tool, > 0. force_limit [N] and torque_limit (3,) [N mm] of what is rendered, > 0.
contact: "skin", the smooth surface of each object that has one, or "leaves".
Raises ValueError that names the part which is wrong.)")
      .def_static(
          "load", [](const std::filesystem::path& path) { return compiled(scene::describeScene(formats::readScene(path), path)); },
          py::arg("path"), py::call_guard<py::gil_scoped_release>(),
          "Reads and compiles a scene.json that `spheretree batch` wrote. Raises FileError, FormatError, ValueError.")
      .def("__len__", &runtime::Scene::objectCount)
      .def_property_readonly("byte_count", &runtime::Scene::byteCount, "Memory that the compiled scene holds [bytes].")
      .def("__repr__",
           [](const runtime::Scene& scene) { return "<spheretree.Scene: " + std::to_string(scene.objectCount()) + " objects>"; });
}

void bindStep(py::module_& module) {
  using runtime::Contact;
  py::class_<Contact>(module, "Contact", "A contact of the graphic tool.")
      .def_readonly("object", &Contact::object, "Index of the object in the scene.")
      .def_readonly("tool_leaf", &Contact::tool_leaf, "Node of the tool's tree.")
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
          "Shape (3,): velocity of the tool's point across the object, world axes [mm/s].");
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
      .def_readonly("contacts", &PythonStep::contacts, "Contacts that hold the graphic tool, at most 24; their forces balance the spring.");
}

}  // namespace

void bindRuntime(py::module_& module) {
  bindScene(module);
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
