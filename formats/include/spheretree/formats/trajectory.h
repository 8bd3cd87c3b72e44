// SPDX-License-Identifier: Apache-2.0
// The pose of the haptic tool at every servo step, as CSV: a trajectory, or what the player recorded.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/rigid.h"

namespace spheretree::formats {

/// First line `t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz`, then a row for each servo step, 1 ms after the one before (to a
/// microsecond; the first may have any time). Of a recording (first line with t_s, hx_mm, hy_mm, hz_mm, hqw, hqx, hqy,
/// hqz among others) these columns are taken. A quaternion within 0.1 % of length 1 is normalised; one that a
/// normalised quaternion was printed from stays as it is, to the bit, so that a recording replays to the same bytes.
/// Cost: O(size).
/// @throws FormatError with line and column: another header, a missing, spare or malformed field, a number that is not
/// finite or beyond 1e7 mm, a time out of step, a quaternion of another length, no row at all.
std::vector<Configuration> parseTrajectory(std::string_view text, const std::string& name);

/// @throws FormatError as parseTrajectory(), FileError if the file cannot be read.
std::vector<Configuration> readTrajectory(const std::filesystem::path& path);

}  // namespace spheretree::formats
