// SPDX-License-Identifier: Apache-2.0
// The parts of the extension module spheretree._core.
#pragma once

#include <pybind11/pybind11.h>

namespace spheretree::python {

void bindMesh(pybind11::module_& module);
void bindTree(pybind11::module_& module);
void bindRuntime(pybind11::module_& module);

}  // namespace spheretree::python
