// SPDX-License-Identifier: GPL-3.0-or-later
// 01_build_a_tree MESH TREE.stree: reads a mesh, builds its sphere-tree, prints its levels and writes it.
#include <cstdio>
#include <exception>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

int main(int argc, char** argv) try {
  using namespace spheretree;
  if (argc != 3) {
    std::fputs("Usage: 01_build_a_tree MESH TREE.stree\n", stderr);
    return 2;
  }
  const TriangleMesh mesh = formats::readMesh(argv[1]).mesh;

  // A tree needs a closed, oriented, manifold mesh that does not cross itself; the report lists the defects and their
  // places.
  const builder::MeshReport report = builder::checkMesh(mesh);
  if (!report.clean()) throw builder::BuildError(report.summary());

  builder::BuildSettings settings;  // four levels of at most eight children: 1, 8, 64 and 512 spheres
  builder::Progress progress;       // silent; a subclass can show it or cancel the build
  const SphereTree tree = builder::buildSphereTree(mesh, settings, progress).tree;

  for (int level = 0; level < tree.levelCount(); ++level) {
    const LevelStatistics& s = tree.statistics[static_cast<std::size_t>(level)];
    std::printf("level %d: %u spheres, none reaches more than %.3f mm out of the mesh\n", level, s.sphere_count, s.overhang_bound);
  }
  formats::writeSphereTree(argv[2], tree);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "01_build_a_tree: %s\n", error.what());
  return 1;
}
