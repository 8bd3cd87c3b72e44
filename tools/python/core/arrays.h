// SPDX-License-Identifier: Apache-2.0
// Between numpy arrays and the plain types of core: meshes in, views of what C++ holds out, poses both ways.
// Units: mm, rad.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::python {

namespace py = pybind11;

/// Vertices of shape (n, 3) and triangles of shape (m, 3) as a mesh, welded (core's weldEqualVertices). Each array is
/// read once, in place: no other copy is made of float32, float64 and of 32 and 64 bit integers, whatever their
/// strides.
/// @throws py::value_error for other shapes, py::type_error for other kinds of numbers, py::index_error for a triangle
/// that names a vertex that does not exist.
TriangleMesh meshFrom(const py::array& vertices, const py::array& triangles);

/// Any array or nested sequence of numbers. @throws py::type_error that begins with `name`.
py::array arrayFrom(const py::handle& values, const char* name);

/// A read-only array over memory that `owner` keeps alive. `strides` in bytes.
template <class T>
py::array viewOf(const T* first, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const py::object& owner) {
  py::array view(py::dtype::of<T>(), std::move(shape), std::move(strides), first, owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

/// A row of numbers that may be gone through again and again.
template <class T>
py::array viewOf(const std::vector<T>& values, const py::object& owner) {
  return viewOf(values.data(), {static_cast<py::ssize_t>(values.size())}, {static_cast<py::ssize_t>(sizeof(T))}, owner);
}

/// (3,) as a new array.
py::array_t<double> arrayOf(const Eigen::Vector3d& v);

/// (x, y, z) of any sequence of three numbers. @throws py::value_error that begins with `name`.
Eigen::Vector3d vectorFrom(const py::handle& values, const char* name);

/// A position (3,), a position with a quaternion (7,) as (x, y, z, qw, qx, qy, qz), or a rigid matrix (4, 4).
/// Numbers that are not finite pass: the runtime answers for them.
/// @throws py::value_error for another shape or a matrix that is not rigid.
Configuration poseFrom(const py::handle& pose);

/// (7,): x, y, z, qw, qx, qy, qz.
py::array_t<double> arrayOf(const Configuration& pose);

}  // namespace spheretree::python
