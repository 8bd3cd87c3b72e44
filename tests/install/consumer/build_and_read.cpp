// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/formats/sphere_tree_file.h"

int main(int, char** argv) {
  using namespace spheretree;
  TriangleMesh cube;
  for (int i = 0; i < 8; ++i) cube.positions.emplace_back(i & 1 ? 10 : 0, i & 2 ? 10 : 0, i & 4 ? 10 : 0);
  cube.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  builder::BuildSettings settings;
  settings.levels = 3;
  settings.quality = builder::Quality::Quick;
  builder::Progress progress;
  const SphereTree built = builder::buildSphereTree(cube, settings, progress).tree;
  formats::writeSphereTree(argv[1], built);
  const bool same = formats::readSphereTree(argv[1]) == built;
  std::printf("%zu nodes, %s\n", built.nodeCount(), same ? "read back alike" : "READ BACK DIFFERENTLY");
  return same ? 0 : 1;
}
