// SPDX-License-Identifier: Apache-2.0
// copy_trees IN OUT: reads every tree in the folder IN and writes it to the folder OUT, from what was read. It stands
// for a program on another machine that takes trees as files.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "spheretree/formats/sphere_tree_file.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: copy_trees IN OUT\n"), 2;
  try {
    for (const auto& entry : std::filesystem::directory_iterator(argv[1]))
      if (entry.path().extension() == ".stree")
        spheretree::formats::writeSphereTree(std::filesystem::path(argv[2]) / entry.path().filename(),
                                             spheretree::formats::readSphereTree(entry.path()));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "copy_trees: %s\n", error.what()), 1;
  }
}
