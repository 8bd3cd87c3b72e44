// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_argument.h"

#include "core/arrays.h"
#include "pipeline/sound_mesh.h"

namespace spheretree::python {

std::shared_ptr<PythonMesh> meshArgument(const py::object& mesh, const py::object& triangles) {
  if (py::isinstance<PythonMesh>(mesh)) {
    if (!triangles.is_none()) throw py::type_error("triangles belong to a mesh given as arrays; a spheretree.Mesh has its own.");
    return mesh.cast<std::shared_ptr<PythonMesh>>();
  }
  if (triangles.is_none()) throw py::type_error("the mesh must be a spheretree.Mesh, or vertices (n, 3) and triangles (m, 3).");
  return std::make_shared<PythonMesh>(PythonMesh{meshFrom(arrayFrom(mesh, "vertices"), arrayFrom(triangles, "triangles")), 1, "mesh", {}});
}

builder::RepairKind repairArgument(const std::string& repair) {
  if (repair != "auto" && repair != "off" && repair != "wrap")
    throw py::value_error("repair must be auto, off or wrap, not " + repair + ".");
  return pipeline::repairKind(repair);
}

void warn(const std::string& name, const std::vector<std::string>& notes) {
  const py::object category = py::module_::import("spheretree._builder").attr("MeshWarning");
  for (const std::string& note : notes)
    if (PyErr_WarnEx(category.ptr(), (name + ": " + note).c_str(), 1) != 0) throw py::error_already_set();
}

}  // namespace spheretree::python
