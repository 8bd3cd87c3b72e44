// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree evaluate --states: how well a soft tree represents its object when it is deformed.
#pragma once

#include <cstdint>
#include <string>

#include "spheretree/builder/progress.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/core/tissue.h"

namespace spheretree::tool {

struct StatesOptions {
  std::string states;  // a number of sample states, or a CSV file of states; empty: none
  int samples = 10'000;
  bool json = false;
  std::uint64_t seed = 1;
  int threads = 0;
};

inline constexpr int kMaxStateSamples = 1'000'000;

/// `name`: of the soft tree, for messages. `mesh`: from which the tree was built. Prints a table by kind, or JSON.
/// Returns an exit code: kExitInternal, with a message, if a state violates the certificate.
int reportStates(const std::string& name, const SphereTree& tree, const Tissue& tissue, const builder::RepairedMesh& mesh,
                 const StatesOptions& options, builder::Progress& progress);

}  // namespace spheretree::tool
