// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "spheretree/core/mesh_edit.h"

namespace spheretree::python {
namespace {

constexpr double kRigid = 1e-6;  // R^T R of a matrix given in float32 has a smaller error than this

std::string shapeText(const py::array& a) { return py::str(a.attr("shape")).cast<std::string>(); }

void requireRows(const py::array& a, const char* name) {
  if (a.ndim() != 2 || a.shape(1) != 3) throw py::value_error(std::string(name) + " must have the shape (n, 3), not " + shapeText(a) + ".");
}

/// Calls `take` with a view of `a` in one of the element types `Ts`; false if it has none of these types.
template <class... Ts, class Take>
bool readAs(const py::array& a, Take&& take) {
  return ([&] {
    if (!py::isinstance<py::array_t<Ts>>(a)) return false;
    take(a.unchecked<Ts, 2>());
    return true;
  }() || ...);
}

std::vector<Eigen::Vector3d> positionsFrom(const py::array& vertices) {
  requireRows(vertices, "vertices");
  std::vector<Eigen::Vector3d> positions;
  const auto take = [&](const auto& rows) {
    positions.reserve(static_cast<std::size_t>(rows.shape(0)));
    for (py::ssize_t i = 0; i < rows.shape(0); ++i)
      positions.emplace_back(static_cast<double>(rows(i, 0)), static_cast<double>(rows(i, 1)), static_cast<double>(rows(i, 2)));
  };
  if (readAs<double, float, std::int64_t, std::int32_t>(vertices, take)) return positions;
  const char kind = vertices.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error("vertices must be real numbers, not " + py::str(vertices.dtype()).cast<std::string>() + ".");
  take(py::array_t<double, py::array::forcecast>(vertices).unchecked<2>());
  return positions;
}

std::vector<Triangle> trianglesFrom(const py::array& corners, std::size_t vertex_count) {
  if (corners.ndim() == 2 && corners.shape(1) == 4)
    throw py::value_error("triangles must have the shape (m, 3), not " + shapeText(corners) + ". Cut each quad into two triangles.");
  requireRows(corners, "triangles");
  std::vector<Triangle> triangles;
  const auto take = [&](const auto& rows) {
    triangles.resize(static_cast<std::size_t>(rows.shape(0)));
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = rows(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(k));
        const bool is_minus_one = v == static_cast<decltype(v)>(-1);  // of an unsigned type, too
        if (v < 0 || static_cast<std::uint64_t>(v) >= vertex_count)
          throw py::index_error("triangles[" + std::to_string(i) + "] names vertex " + (is_minus_one ? "-1" : std::to_string(v)) +
                                ", and there are " + std::to_string(vertex_count) + ", counted from 0.");
        triangles[i][k] = static_cast<std::uint32_t>(v);
      }
  };
  if (readAs<std::int64_t, std::int32_t, std::uint32_t, std::uint64_t>(corners, take)) return triangles;
  const char kind = corners.dtype().kind();
  if (kind != 'i' && kind != 'u')
    throw py::type_error("triangles must be whole numbers, not " + py::str(corners.dtype()).cast<std::string>() + ".");
  take(py::array_t<std::int64_t, py::array::forcecast>(corners).unchecked<2>());
  return triangles;
}

py::array_t<double> numbersFrom(const py::handle& values, const char* name) {
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(values);
  if (!numbers) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " must be an array of real numbers.");
  }
  return numbers;
}

Configuration poseFromMatrix(const py::array_t<double>& m) {
  Eigen::Matrix3d rotation;
  Configuration pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation(row, column) = m.at(row, column);
    pose.position[row] = m.at(row, 3);
  }
  const bool has_last_row = m.at(3, 0) == 0 && m.at(3, 1) == 0 && m.at(3, 2) == 0 && m.at(3, 3) == 1;
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (rotation.allFinite() && (!has_last_row || !(off <= kRigid) || !(rotation.determinant() > 0)))
    throw py::value_error("a pose (4, 4) must be a rotation and a translation, without scale, and end in the row 0 0 0 1.");
  pose.orientation = Quaternion(Eigen::Quaterniond(rotation));
  if (!rotation.allFinite()) pose.orientation.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
  return pose;
}

}  // namespace

TriangleMesh meshFrom(const py::array& vertices, const py::array& triangles) {
  TriangleMesh mesh;
  mesh.positions = positionsFrom(vertices);
  if (mesh.positions.size() >= std::numeric_limits<std::uint32_t>::max())
    throw py::value_error("vertices has " + std::to_string(mesh.positions.size()) + " rows; a mesh can have 4294967294 vertices.");
  mesh.triangles = trianglesFrom(triangles, mesh.positions.size());
  if (mesh.triangles.empty()) throw py::value_error("triangles is empty. A solid needs faces.");
  weldEqualVertices(mesh);
  return mesh;
}

py::array arrayFrom(const py::handle& values, const char* name) {
  py::array array = py::array::ensure(values);
  if (array) return array;
  PyErr_Clear();
  throw py::type_error(std::string(name) + " must be an array of numbers.");
}

py::array_t<double> arrayOf(const Eigen::Vector3d& v) { return py::array_t<double>(3, v.data()); }

Eigen::Vector3d vectorFrom(const py::handle& values, const char* name) {
  const py::array_t<double> numbers = numbersFrom(values, name);
  if (numbers.ndim() != 1 || numbers.shape(0) != 3)
    throw py::value_error(std::string(name) + " must have the shape (3,), not " + shapeText(numbers) + ".");
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

Configuration poseFrom(const py::handle& pose) {
  const py::array_t<double> p = numbersFrom(pose, "a pose");
  if (p.ndim() == 2 && p.shape(0) == 4 && p.shape(1) == 4) return poseFromMatrix(p);
  if (p.ndim() != 1 || (p.shape(0) != 3 && p.shape(0) != 7))
    throw py::value_error("a pose must have the shape (3,), (7,) or (4, 4), not " + shapeText(p) + ".");
  Configuration out;
  out.position = {p.at(0), p.at(1), p.at(2)};
  if (p.shape(0) == 7) out.orientation = Quaternion(p.at(3), p.at(4), p.at(5), p.at(6));
  return out;
}

py::array_t<double> arrayOf(const Configuration& pose) {
  const Quaternion& q = pose.orientation;
  const double numbers[] = {pose.position.x(), pose.position.y(), pose.position.z(), q.w(), q.x(), q.y(), q.z()};
  return py::array_t<double>(7, numbers);
}

}  // namespace spheretree::python
