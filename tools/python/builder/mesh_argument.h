// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh arguments of the functions of spheretree._builder, and the warnings about changes to a mesh.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

#include "core/python_types.h"
#include "spheretree/builder/repair_mesh.h"

namespace spheretree::python {

namespace py = pybind11;

/// A spheretree.Mesh, or vertices of shape (n, 3) with triangles of shape (m, 3).
/// @throws py::type_error for anything else, and the exceptions of spheretree.Mesh.
std::shared_ptr<PythonMesh> meshArgument(const py::object& mesh, const py::object& triangles);

/// "auto", "off" or "wrap". @throws py::value_error
builder::RepairKind repairArgument(const std::string& repair);

/// Issues a spheretree.MeshWarning for each note. @throws py::error_already_set if warnings are errors.
void warn(const std::string& name, const std::vector<std::string>& notes);

}  // namespace spheretree::python
