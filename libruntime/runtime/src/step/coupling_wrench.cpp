// SPDX-License-Identifier: Apache-2.0
#include "step/coupling_wrench.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {

Wrench couplingWrench(const Coupling& coupling, const Configuration& haptic, const Configuration& graphic) noexcept {
  const Displacement stretch = displacementBetween(haptic, graphic);
  return {coupling.translation * stretch.translation, coupling.rotation * stretch.rotation};
}

Wrench limited(const Wrench& wrench, const WrenchLimits& limits) noexcept {
  if (!wrench.force.allFinite() || !wrench.torque.allFinite()) return {};
  Wrench out = wrench;
  if (const double force = wrench.force.norm(); force > limits.force) out.force *= limits.force / force;
  double excess = 1;
  for (int k = 0; k < 3; ++k) excess = std::max(excess, std::abs(wrench.torque[k]) / limits.torque[k]);
  out.torque /= excess;
  return out;
}

}  // namespace spheretree::runtime
