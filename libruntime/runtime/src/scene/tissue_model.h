// SPDX-License-Identifier: Apache-2.0
// The soft tissue of a tree, as objects of a scene share it.
#pragma once

#include <cstddef>
#include <memory>

#include "spheretree/core/tissue.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

class SoftTissue;
struct StepMemory;

/// Tissue for a scene, and the factory of its implementation.
struct TissueModel {
  SharedTree tree;
  std::shared_ptr<const Tissue> tissue;
  std::size_t bytes = 0;
  std::unique_ptr<SoftTissue> (*make)(StepMemory& memory) = nullptr;
};

}  // namespace spheretree::runtime
