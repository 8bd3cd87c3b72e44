// SPDX-License-Identifier: Apache-2.0
// What a contact may exert: a force along its normal that presses, and a force across it within a disc or a cone.
// docs/algorithms/runtime/contact_forces.md
#pragma once

#include <cstddef>
#include <cstdint>

namespace spheretree::runtime {

/// Derivatives of the nearest force that a part may exert to another one: by the other one, and by the normal force on
/// which a disc depends.
struct Slopes {
  double by[3][3] = {}, widening[3] = {};
};

/// A row alone, a disc of a given radius, or a contact with friction in proportion to its row. Its forces are at[0],
/// which is along the normal but for a disc, and so on.
struct ContactPart {
  std::size_t at[3], size;
  double friction, radius;  // of the disc
  double scale[3] = {};     // of a force against its motion
};

/// What the forces of contacts with friction obey.
enum class Law : std::uint8_t {
  Coulomb,
  Discs,  // of given radii
  Cones,  // and contacts may lift off where they slip
};

/// Moves `z` to the nearest force that the part may exert. With Coulomb's law the radius of the disc is that of
/// `normal`, the present normal force. `slopes`: zeros, or null.
void nearestForce(Law law, const ContactPart& part, double normal, double* z, Slopes* slopes) noexcept;

}  // namespace spheretree::runtime
