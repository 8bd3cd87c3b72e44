// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers that are the same with every standard library: the distributions of the library differ between
// implementations, its generators do not.
#pragma once

#include <random>

namespace spheretree::builder {

/// Uniform in [0, 1), in steps of 2^-53. Takes one number from the generator.
inline double randomUnit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace spheretree::builder
