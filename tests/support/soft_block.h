// SPDX-License-Identifier: GPL-3.0-or-later
// A block of soft tissue for tests of the runtime.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/soften_tree.h"
#include "spheretree/runtime/scene.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"

namespace spheretree::test {

struct SoftBlock {
  runtime::SharedTree shared;
  SphereTree tree;
  std::shared_ptr<const Tissue> tissue;
  std::shared_ptr<const runtime::TissueModel> model;
};

/// Of 24 x 20 x 12 mm, fixed below; 15 kPa.
inline SoftBlock softBlock(int levels) {
  const Eigen::Vector3d size(24, 20, 12);
  const TriangleMesh boundary = boxMesh(Eigen::Vector3d::Zero(), size);
  const TriangleMesh mesh = quartered(quartered(quartered(boundary)));
  builder::Progress progress;
  builder::BuildSettings settings;
  settings.levels = levels;
  settings.quality = builder::Quality::Quick;
  settings.soft_share = 0.5;
  SoftBlock out;
  out.tree = builder::buildSphereTree(mesh, settings, progress).tree;
  out.tissue = std::make_shared<const Tissue>(builder::softenTree(
      mesh, out.tree, boundary, boxTetrahedra(size, {8, 6, 4}), {15, 0.45, 1040}, [](const Eigen::Vector3d& p) { return p.z() < 1e-6; },
      progress));
  out.shared = out.tree;
  std::string fault;
  out.model = runtime::tissueModel(out.shared, out.tissue, fault);
  EXPECT_EQ(fault, "");
  return out;
}

/// With 64 leaves. Built once.
inline const SoftBlock& block() {
  static const SoftBlock made = softBlock(3);
  return made;
}

/// With 512 leaves, small enough to follow what a tool presses in. Built once.
inline const SoftBlock& fineBlock() {
  static const SoftBlock made = softBlock(4);
  return made;
}

}  // namespace spheretree::test
