// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>

#include "arrays.h"
#include "bindings.h"
#include "python_types.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/mesh_writer.h"

namespace spheretree::python {
namespace {

using MeshPointer = std::shared_ptr<PythonMesh>;

MeshPointer readMeshFile(const std::filesystem::path& path, const std::string& unit) {
  const py::gil_scoped_release release;
  if (!unit.empty() && unit != "mm" && unit != "cm" && unit != "m" && unit != "in")
    throw std::invalid_argument("unit must be mm, cm, m or in, not " + unit + ".");
  formats::MeshFile file =
      unit.empty() ? formats::readMesh(path) : formats::readMesh(path, formats::unitInMm(unit), formats::unitInMm(unit));
  return std::make_shared<PythonMesh>(PythonMesh{std::move(file.mesh), file.unit_mm, path.string(), std::move(file.notes)});
}

void saveMesh(const PythonMesh& mesh, const std::filesystem::path& path) {
  const py::gil_scoped_release release;
  const std::string ending = path.extension().string();
  if (ending != ".ply" && ending != ".obj")
    throw std::invalid_argument(path.string() + ": the name of a mesh to save must end in .ply or .obj.");
  formats::writeWhole(path, ending == ".ply" ? formats::encodePly(mesh.mesh) : formats::encodeObj(mesh.mesh));
}

PythonMesh partOf(const PythonMesh& mesh, const std::string& name) {
  return {formats::selectPart(mesh.mesh, name), mesh.unit_mm, mesh.name, {}};
}

py::array verticesOf(const py::object& self) {
  const auto& positions = self.cast<const PythonMesh&>().mesh.positions;
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return viewOf(positions.empty() ? nullptr : positions[0].data(), {static_cast<py::ssize_t>(positions.size()), 3},
                {sizeof(Eigen::Vector3d), sizeof(double)}, self);
}

py::array trianglesOf(const py::object& self) {
  const auto& triangles = self.cast<const PythonMesh&>().mesh.triangles;
  return viewOf(triangles.empty() ? nullptr : triangles[0].data(), {static_cast<py::ssize_t>(triangles.size()), 3},
                {sizeof(Triangle), sizeof(std::uint32_t)}, self);
}

}  // namespace

void bindMesh(py::module_& module) {
  py::class_<PythonMesh, MeshPointer>(module, "Mesh", R"(A triangle mesh in millimetres.

Vertices at exactly equal positions become one, and vertices that no triangle uses are left out, as for a mesh that is
read from a file. The arrays given are read once; later changes of them do not reach the mesh.)")
      .def(py::init([](const py::object& vertices, const py::object& triangles) {
             return std::make_shared<PythonMesh>(
                 PythonMesh{meshFrom(arrayFrom(vertices, "vertices"), arrayFrom(triangles, "triangles")), 1, "mesh", {}});
           }),
           py::arg("vertices"), py::arg("triangles"), R"(Makes a mesh of arrays.

vertices: shape (n, 3), real numbers [mm]. triangles: shape (m, 3), whole numbers, the corners of each triangle as rows
of `vertices`, counter-clockwise seen from outside.
Raises ValueError for other shapes, TypeError for other kinds of numbers, IndexError for a corner out of range.)")
      .def_property_readonly("vertices", &verticesOf, "Shape (n, 3), float64 [mm]. Read-only; no copy.")
      .def_property_readonly("triangles", &trianglesOf, "Shape (m, 3), uint32: rows of `vertices`. Read-only; no copy.")
      .def_readonly("unit_mm", &PythonMesh::unit_mm, "One unit of the file that the mesh was read from [mm]; 1 for arrays.")
      .def_readonly("notes", &PythonMesh::notes, "Sentences about what the reader ignored, cut or found doubtful.")
      .def_property_readonly(
          "part_names", [](const PythonMesh& mesh) { return mesh.mesh.part_names; }, "Names of the parts of the file.")
      .def("part", &partOf, py::arg("name"), "The part of this name as a mesh. Raises FormatError that lists the existing names.")
      .def("save", &saveMesh, py::arg("path"),
           "Writes .ply (binary, float64) or .obj (shortest decimals), both without loss. Raises FileError, ValueError.")
      .def("__repr__", [](const PythonMesh& mesh) {
        return "<spheretree.Mesh: " + std::to_string(mesh.mesh.positions.size()) + " vertices, " +
               std::to_string(mesh.mesh.triangles.size()) + " triangles>";
      });
  module.def("read", &readMeshFile, py::arg("path"), py::arg("unit") = "",
             R"(Reads a mesh: .obj, .stl, .ply, .off, .gltf or .glb.

unit: of the numbers in the file, mm, cm, m or in; "": mm, and m for glTF.
Raises FileError if the file cannot be read, FormatError if its content is refused, ValueError for another unit.)");
}

}  // namespace spheretree::python
