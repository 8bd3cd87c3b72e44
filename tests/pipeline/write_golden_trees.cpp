// SPDX-License-Identifier: GPL-3.0-or-later
// write_golden_trees FOLDER: trees of the sample meshes in it, whose bytes golden_trees.py compares with its record.
// Each tree is built on one and on two threads. A program of few libraries, so that a lane with other options or
// another compiler compiles a third of what the command line needs.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace {

using namespace spheretree;
using builder::BuilderKind;
using builder::BuildSettings;

struct Case {
  std::string name;
  const char* mesh;
  builder::RepairKind repair = builder::RepairKind::Auto;
  BuildSettings settings;
};

std::vector<Case> cases() {
  BuildSettings quick;
  quick.quality = builder::Quality::Quick;
  BuildSettings three_levels, tolerance = quick, quick_three = quick;
  three_levels.levels = quick_three.levels = 3;
  tolerance.tolerance_mm = 0.3;
  std::vector<Case> all{{"molar quick", "molar", builder::RepairKind::Auto, quick},
                        {"molar standard, 3 levels", "molar", builder::RepairKind::Auto, three_levels},
                        {"molar, 0.3 mm", "molar", builder::RepairKind::Auto, tolerance},
                        {"probe quick", "probe", builder::RepairKind::Auto, quick},
                        {"probe wrapped", "probe", builder::RepairKind::Wrap, quick_three}};
  BuildSettings published = quick_three;
  for (const BuilderKind kind : {BuilderKind::Combined, BuilderKind::Merge, BuilderKind::Burst, BuilderKind::Expand, BuilderKind::Spawn,
                                 BuilderKind::Grid, BuilderKind::Hubbard, BuilderKind::Octree}) {
    published.builder = kind;
    published.combine.clear();
    if (kind == BuilderKind::Combined) published.combine = {BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst};
    all.push_back({"probe " + std::string(builder::name(kind)), "probe", builder::RepairKind::Auto, published});
  }
  published.builder = BuilderKind::Merge;
  published.search = true;
  all.push_back({"probe merge, search", "probe", builder::RepairKind::Auto, published});
  return all;
}

void write(const std::filesystem::path& folder) {
  for (const Case& one : cases()) {
    const TriangleMesh mesh = formats::readMesh(folder / (std::string(one.mesh) + ".obj")).mesh;
    for (const int threads : {1, 2}) {
      BuildSettings settings = one.settings;
      settings.threads = threads;
      builder::Progress progress;
      const builder::RepairedMesh sound = builder::repairMesh(mesh, one.repair, progress);
      const builder::BuildResult result = builder::buildSphereTree(sound.mesh, settings, progress, sound.to_cover);
      formats::writeSphereTree(folder / (one.name + (threads == 1 ? ".stree" : ", two threads.stree")), result.tree);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: write_golden_trees FOLDER\n"), 2;
  try {
    write(argv[1]);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "write_golden_trees: %s\n", error.what()), 1;
  }
}
