// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "spheretree/formats/sphere_tree_file.h"

int main(int, char** argv) {
  const spheretree::SphereTree tree = spheretree::formats::readSphereTree(argv[1]);
  const std::string fault = spheretree::findFault(tree);
  std::printf("%d levels, %s\n", tree.levelCount(), fault.empty() ? "sound" : fault.c_str());
  return fault.empty() && tree.levelCount() == 3 ? 0 : 1;
}
