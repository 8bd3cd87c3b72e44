// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the extension module spheretree._builder.
#pragma once

#include <pybind11/pybind11.h>

namespace spheretree::python {

void bindCheck(pybind11::module_& module);
void bindBuild(pybind11::module_& module);
void bindEvaluate(pybind11::module_& module);
void bindBatch(pybind11::module_& module);
void bindRobot(pybind11::module_& module);

}  // namespace spheretree::python
