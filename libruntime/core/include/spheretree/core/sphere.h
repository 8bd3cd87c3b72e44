// SPDX-License-Identifier: Apache-2.0
// The sphere as files store it and as the runtime tests it.
#pragma once

namespace spheretree {

/// Centre and radius in the frame of the tree [mm]. 16 bytes, the layout of the file.
struct Sphere {
  float x, y, z;
  float radius;  // finite, > 0
  friend bool operator==(const Sphere&, const Sphere&) = default;
};
static_assert(sizeof(Sphere) == 16);

}  // namespace spheretree
