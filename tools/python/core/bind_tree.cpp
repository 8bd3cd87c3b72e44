// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "arrays.h"
#include "bindings.h"
#include "python_types.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::python {

std::pair<const Sphere*, std::size_t> PythonTree::levelSpheres(int level) {
  const SphereTree& tree = *tree_;
  const auto l = static_cast<std::size_t>(level);
  const std::size_t begin = tree.level_begin[l], end = tree.level_begin[l + 1], count = tree.statistics[l].sphere_count;
  if (end - begin == count) return {tree.cover.data() + begin, count};
  if (gathered_[l].empty())
    for (const std::uint32_t node : levelSet(tree, level)) gathered_[l].push_back(tree.cover[node]);
  return {gathered_[l].data(), gathered_[l].size()};
}

namespace {

using TreePointer = std::shared_ptr<PythonTree>;

int checkedLevel(const SphereTree& tree, int level) {
  const int count = tree.levelCount(), from_start = level < 0 ? level + count : level;
  if (from_start < 0 || from_start >= count)
    throw py::index_error("level " + std::to_string(level) + " is out of range: the tree has the levels 0 to " + std::to_string(count - 1) +
                          ".");
  return from_start;
}

py::tuple levelOf(const py::object& self, int level) {
  auto& tree = self.cast<PythonTree&>();
  const auto [first, size] = tree.levelSpheres(checkedLevel(*tree, level));
  const auto count = static_cast<py::ssize_t>(size);
  return py::make_tuple(viewOf(&first->x, {count, 3}, {sizeof(Sphere), sizeof(float)}, self),
                        viewOf(&first->radius, {count}, {sizeof(Sphere)}, self));
}

py::array spheresView(const std::vector<Sphere>& spheres, const py::object& owner) {
  return viewOf(spheres.empty() ? nullptr : &spheres[0].x, {static_cast<py::ssize_t>(spheres.size()), 4}, {sizeof(Sphere), sizeof(float)},
                owner);
}

double boundOf(const LevelStatistics& level) {
  return level.overhang_bound == kUnproven ? std::numeric_limits<double>::quiet_NaN() : level.overhang_bound;
}

py::array_t<double> overhangBounds(const PythonTree& tree) {
  py::array_t<double> bounds(static_cast<py::ssize_t>(tree->statistics.size()));
  for (std::size_t level = 0; level < tree->statistics.size(); ++level)
    bounds.mutable_at(static_cast<py::ssize_t>(level)) = boundOf(tree->statistics[level]);
  return bounds;
}

py::dict provenanceOf(const PythonTree& tree) {
  const Provenance& p = tree->provenance;
  py::dict out;
  out["builder"] = p.builder;
  out["quality"] = p.quality;
  out["generator"] = p.generator;
  out["unit_mm"] = p.unit_mm;
  out["diagonal_mm"] = p.diagonal_mm;
  out["volume_mm3"] = p.volume_mm3;
  out["area_mm2"] = p.area_mm2;
  out["tolerance_mm"] = p.tolerance_mm > 0 ? py::object(py::float_(p.tolerance_mm)) : py::object(py::none());
  out["triangles"] = p.triangle_count;
  out["seed"] = p.seed;
  out["mesh_hash"] = toHex(p.mesh_hash);
  out["settings_hash"] = toHex(p.settings_hash);
  return out;
}

py::bytes bytesOf(const PythonTree& tree) {
  const std::vector<std::byte> bytes = encodeSphereTree(*tree);
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

TreePointer treeFromBytes(const py::bytes& content) {
  const auto text = static_cast<std::string_view>(content);
  return std::make_shared<PythonTree>(
      formats::parseSphereTree(std::as_bytes(std::span(text.data(), text.size())), "the bytes of the tree"));
}

TreePointer loadTree(const std::filesystem::path& path) {
  const py::gil_scoped_release release;
  return std::make_shared<PythonTree>(formats::readSphereTree(path));
}

void bindNodes(py::class_<PythonTree, TreePointer>& tree) {
  tree.def_property_readonly(
          "cover", [](const py::object& self) { return spheresView((*self.cast<PythonTree&>()).cover, self); },
          "Shape (nodes, 4), float32: centre and radius of the cover sphere of each node, breadth first [mm]. No copy.")
      .def_property_readonly(
          "bound", [](const py::object& self) { return spheresView((*self.cast<PythonTree&>()).bound, self); },
          "Shape (inner nodes, 4), float32: spheres that enclose the cover spheres of a node and of all below it [mm]. No copy.")
      .def_property_readonly(
          "bound_index", [](const py::object& self) { return viewOf((*self.cast<PythonTree&>()).bound_index, self); },
          "Shape (nodes,), uint32: row of `bound`; 2**32 - 1 for a leaf. No copy.")
      .def_property_readonly(
          "first_child", [](const py::object& self) { return viewOf((*self.cast<PythonTree&>()).first_child, self); },
          "Shape (nodes,), uint32: the first child, whose siblings follow it; 0 for a leaf. No copy.")
      .def_property_readonly(
          "child_count", [](const py::object& self) { return viewOf((*self.cast<PythonTree&>()).child_count, self); },
          "Shape (nodes,), uint8: children of each node; 0 for a leaf. No copy.")
      .def_property_readonly(
          "level_begin", [](const py::object& self) { return viewOf((*self.cast<PythonTree&>()).level_begin, self); },
          "Shape (levels + 1,), uint32: first node of each level, then the number of nodes. No copy.");
}

}  // namespace

void bindTree(py::module_& module) {
  py::class_<PythonTree, TreePointer> tree(module, "SphereTree", R"(A sphere-tree: every level covers the whole surface of the object.

It is immutable. Its arrays are read-only views of its own memory and keep it alive. Lengths in millimetres, in the
frame of the mesh moved by -origin; origin is zero unless the mesh lies far from its frame's origin.)");
  bindNodes(tree);
  tree.def("level", &levelOf, py::arg("level"), R"(The spheres of one level: (centres, radii).

level: 0 (the root) to level_count - 1, or from the end if negative.
centres: shape (n, 3), float32 [mm]; radii: shape (n,), float32 [mm], > 0. Both are read-only and no copies: rows of
`cover`, or, on levels above which some branches ended, copied rows.
Raises IndexError.)")
      .def_property_readonly(
          "level_count", [](const PythonTree& self) { return self->levelCount(); }, "Levels with the root, 1 to 6.")
      .def_property_readonly(
          "node_count", [](const PythonTree& self) { return self->nodeCount(); }, "Nodes of all levels.")
      .def_property_readonly(
          "leaf_count", [](const PythonTree& self) { return self->nodeCount() - self->bound.size(); }, "Nodes without children.")
      .def_property_readonly(
          "branching", [](const PythonTree& self) { return static_cast<int>(self->branching); },
          "Largest number of children of a node, 2 to 8.")
      .def_property_readonly(
          "origin",
          [](const PythonTree& self) { return arrayOf(Eigen::Vector3d(self->origin_mm[0], self->origin_mm[1], self->origin_mm[2])); },
          "Shape (3,), float64 [mm]: add it to a centre to get the frame of the mesh.")
      .def_property_readonly(
          "overhang_bound", [](const PythonTree& self) { return boundOf(self->statistics.back()); },
          "Proven upper bound on how far a leaf reaches out of the object [mm]; nan without a proof.")
      .def_property_readonly("overhang_bounds", &overhangBounds, "Shape (levels,), float64: the same for every level [mm].")
      .def_property_readonly("provenance", &provenanceOf, "Builder, quality, hashes, and size of the mesh, as the file states them.")
      .def_readonly("statistics", &PythonTree::statistics,
                    "Results of the build as a dict (docs/python.md); None for a tree that was loaded.")
      .def("to_bytes", &bytesOf, "The content of a .stree file.")
      .def_static("from_bytes", &treeFromBytes, py::arg("content"), "The tree of these bytes. Raises FormatError for other content.")
      .def_static("load", &loadTree, py::arg("path"), "Reads a .stree file. Raises FileError, FormatError.")
      .def(
          "save",
          [](const PythonTree& self, const std::filesystem::path& path) {
            const py::gil_scoped_release release;
            formats::writeSphereTree(path, *self);
          },
          py::arg("path"), "Writes a .stree file, which appears under its name only when it is complete. Raises FileError.")
      .def(py::pickle(&bytesOf, &treeFromBytes))
      .def("__repr__", [](const PythonTree& self) {
        return "<spheretree.SphereTree: " + std::to_string(self->levelCount()) + " levels, " + std::to_string(self->nodeCount()) +
               " nodes>";
      });
}

}  // namespace spheretree::python
