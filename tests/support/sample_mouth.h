// SPDX-License-Identifier: GPL-3.0-or-later
// The sample mouth, made once for all tests of a process: it takes seconds.
#pragma once

#include "mouth.h"

namespace spheretree::test {

inline const samples::Mouth& sampleMouth() {
  static const samples::Mouth made = samples::makeMouth();
  return made;
}

}  // namespace spheretree::test
