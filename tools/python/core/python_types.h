// SPDX-License-Identifier: Apache-2.0
// Types that the two extension modules share: the C++ side of spheretree.Mesh and spheretree.SphereTree.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <string>
#include <vector>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::python {

struct PythonMesh {
  TriangleMesh mesh;
  double unit_mm = 1;              // one unit of the file that it was read from [mm]
  std::string name = "mesh";       // for messages: its file
  std::vector<std::string> notes;  // of the reader
};

class PythonTree {
 public:
  explicit PythonTree(SphereTree tree) : tree_(std::move(tree)) {}
  PythonTree(SphereTree tree, pybind11::object of_build) : statistics(std::move(of_build)), tree_(std::move(tree)) {}
  const SphereTree& operator*() const { return *tree_; }
  const SphereTree* operator->() const { return &*tree_; }
  const runtime::SharedTree& shared() const { return tree_; }

  /// The spheres of a level set in contiguous memory: in the tree itself, or copied once if earlier levels have leaves.
  /// The GIL must be held.
  std::pair<const Sphere*, std::size_t> levelSpheres(int level);

  pybind11::object statistics = pybind11::none();  // statistics of the build

 private:
  runtime::SharedTree tree_;
  std::array<std::vector<Sphere>, kMaxLevels> gathered_;
};

}  // namespace spheretree::python
