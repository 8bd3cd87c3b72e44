// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree._builder: checks, builders, measures and batches.
#include <pybind11/pybind11.h>

#include "bindings.h"
#include "program_end.h"
#include "spheretree/builder/build_settings.h"

namespace py = pybind11;

PYBIND11_MODULE(_builder, module) {
  py::module_::import("spheretree._core");  // Mesh and SphereTree
  module.doc() = "Builders and measures of spheretree (GPL-3.0-or-later).";
  py::register_exception<spheretree::builder::BuildError>(module, "BuildError", PyExc_ValueError).attr("__doc__") =
      "A mesh is refused, or no tree can be built for it; the message says why and where.";
  py::register_exception<spheretree::tool::UsageError>(module, "UsageError", PyExc_ValueError).attr("__doc__") =
      "Settings that do not go together, or an output that would replace an input.";
  module.attr("MeshWarning") = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "spheretree.MeshWarning", "What a repair changed in a mesh, or a tolerance that is not met.", PyExc_UserWarning, nullptr));
  spheretree::python::bindCheck(module);
  spheretree::python::bindBuild(module);
  spheretree::python::bindEvaluate(module);
  spheretree::python::bindBatch(module);
  spheretree::python::bindRobot(module);
}
