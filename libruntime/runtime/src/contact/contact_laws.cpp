// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_laws.h"

#include <cmath>

namespace spheretree::runtime {
namespace {

// Moves `z` along two axes, from `first` on, into the disc.
void slide(double radius, double* z, std::size_t first, Slopes* slopes) {
  const double square = z[first] * z[first] + z[first + 1] * z[first + 1], length = std::sqrt(square);
  const double share = length > radius ? radius / length : 1;
  for (std::size_t a = first; slopes && a < first + 2; ++a)
    for (std::size_t b = first; b < first + 2; ++b)
      slopes->by[a][b] = (a == b ? share : 0) - (length > radius ? share * z[a] * z[b] / square : 0);
  z[first] *= share, z[first + 1] *= share;
}

// Moves `z` into the cone.
void enterCone(double friction, double* z, Slopes* slopes) {
  const double length = std::sqrt(z[1] * z[1] + z[2] * z[2]);
  if (length <= friction * z[0]) {
    for (std::size_t a = 0; slopes && a < 3; ++a) slopes->by[a][a] = 1;
  } else if (friction * length > -z[0]) {
    const double along[3] = {1, friction * z[1] / length, friction * z[2] / length};  // the line of the cone that z moves to
    const double u = (z[0] + friction * length) / (1 + friction * friction);
    slide(friction * u, z, 1, slopes);
    z[0] = u;
    for (std::size_t a = 0; slopes && a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) slopes->by[a][b] += along[a] * along[b] / (1 + friction * friction);
  } else {
    z[0] = z[1] = z[2] = 0;
  }
}

}  // namespace

void nearestForce(Law law, const ContactPart& part, double normal, double* z, Slopes* slopes) noexcept {
  if (part.size == 2) return slide(part.radius, z, 0, slopes);
  if (part.size == 3 && law == Law::Cones) return enterCone(part.friction, z, slopes);
  const bool presses = z[0] > 0;
  if (!presses) z[0] = 0;
  if (slopes && presses) slopes->by[0][0] = 1;
  if (part.size == 1) return;
  if (law == Law::Discs) return slide(part.radius, z, 1, slopes);
  if (!presses) {
    z[1] = z[2] = 0;
    return;
  }
  const double radius = part.friction * normal, length = std::sqrt(z[1] * z[1] + z[2] * z[2]);
  for (std::size_t a = 1; slopes && a < 3 && length > radius; ++a) slopes->widening[a] = part.friction * z[a] / length;
  slide(radius, z, 1, slopes);
}

}  // namespace spheretree::runtime
