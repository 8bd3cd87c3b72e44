// SPDX-License-Identifier: Apache-2.0
// The material of an object that a burr cuts, as objects of a scene share it.
#pragma once

#include <memory>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

class Cutting;
struct StepMemory;

/// Material, and the factory of what cuts it.
struct CutModel {
  SharedTree tree;
  CutMaterial material;
  std::unique_ptr<Cutting> (*make)(StepMemory& memory) = nullptr;
};

}  // namespace spheretree::runtime
