// SPDX-License-Identifier: Apache-2.0
// spheretree._core: meshes, trees and the haptic runtime. It links only code under the Apache licence or an equally
// permissive one.
#include <pybind11/pybind11.h>

#include "bindings.h"
#include "spheretree/formats/errors.h"

namespace py = pybind11;

PYBIND11_MODULE(_core, module) {
  module.doc() = "Meshes, sphere-trees and the haptic runtime of spheretree (Apache-2.0).";
  module.attr("__version__") = SPHERETREE_VERSION;
  py::register_exception<spheretree::formats::FileError>(module, "FileError", PyExc_OSError).attr("__doc__") =
      "A file cannot be read or written: it is missing, not permitted, or the disk is full.";
  py::register_exception<spheretree::formats::FormatError>(module, "FormatError", PyExc_ValueError).attr("__doc__") =
      "A file was read, but its content is refused; the message names the place and the remedy.";
  spheretree::python::bindMesh(module);
  spheretree::python::bindTree(module);
  spheretree::python::bindRuntime(module);
}
