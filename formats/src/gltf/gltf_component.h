// SPDX-License-Identifier: Apache-2.0
// The types of numbers in a glTF file, with the values of its componentType.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022.
#pragma once

#include <cstdint>

namespace spheretree::formats {

enum Component : std::uint64_t { kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125, kFloat32 = 5126 };

}  // namespace spheretree::formats
