// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of teeth: FDI (ISO 3950), Universal and Palmer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace spheretree::pipeline {

/// Permanent teeth 11 to 48, deciduous 51 to 85.
bool isFdi(std::int32_t number);
/// Quadrants 1, 2, 5 and 6.
bool isUpperFdi(std::int32_t number);

/// FDI number of a Universal number, 1 to 32; empty for any other number.
std::optional<std::int32_t> fdiOfUniversal(std::int32_t number);

/// FDI number of a Palmer notation such as "UR6", "LL-2" or "URE" (deciduous A to E), in any case; empty for any other
/// text.
std::optional<std::int32_t> fdiOfPalmer(std::string_view text);

/// The label in the name of a part, in this numbering ("fdi", "universal", "palmer"): "tooth_16" is 16; 0 for a name
/// that contains gum or gingiva; empty if there is no number.
std::optional<std::int32_t> labelOfName(std::string_view name, const std::string& numbering);

}  // namespace spheretree::pipeline
