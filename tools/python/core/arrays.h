// SPDX-License-Identifier: Apache-2.0
// Conversion between numpy arrays and the plain types of core: meshes from arrays, views of C++ memory, poses in both
// directions.
// Units: mm, rad.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::python {

namespace py = pybind11;

/// A mesh from vertices of shape (n, 3) and triangles of shape (m, 3), welded (core's weldEqualVertices). Each array is
/// read once, in place: arrays of float32, float64 and 32 or 64 bit integers are not copied before, whatever their
/// strides.
/// @throws py::value_error for other shapes, py::type_error for other kinds of numbers, py::index_error for a triangle
/// with a missing vertex.
TriangleMesh meshFrom(const py::array& vertices, const py::array& triangles);

/// Any array or nested sequence of numbers. @throws py::type_error; the message begins with `name`.
py::array arrayFrom(const py::handle& values, const char* name);

/// A read-only array over memory that `owner` keeps alive. `strides` in bytes.
template <class T>
py::array viewOf(const T* first, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const py::object& owner) {
  py::array view(py::dtype::of<T>(), std::move(shape), std::move(strides), first, owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

/// A one-dimensional view of a vector.
template <class T>
py::array viewOf(const std::vector<T>& values, const py::object& owner) {
  return viewOf(values.data(), {static_cast<py::ssize_t>(values.size())}, {static_cast<py::ssize_t>(sizeof(T))}, owner);
}

/// A new array of shape (3,).
py::array_t<double> arrayOf(const Eigen::Vector3d& v);

/// (x, y, z) from any sequence of three numbers. @throws py::value_error; the message begins with `name`.
Eigen::Vector3d vectorFrom(const py::handle& values, const char* name);

/// A position (3,), a position with a quaternion (7,) as (x, y, z, qw, qx, qy, qz), or a rigid matrix (4, 4). Numbers
/// that are not finite are passed on: the runtime handles them.
/// @throws py::value_error for another shape or a matrix that is not rigid.
Configuration poseFrom(const py::handle& pose);

/// (7,): x, y, z, qw, qx, qy, qz.
py::array_t<double> arrayOf(const Configuration& pose);

}  // namespace spheretree::python
