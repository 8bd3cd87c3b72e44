// SPDX-License-Identifier: Apache-2.0
// The pose of the haptic tool over time, as CSV: a trajectory, or a recording of the player.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/rigid.h"

namespace spheretree::formats {

struct Trajectory {
  std::vector<Configuration> poses;  // one for each servo step of 1 ms; at least one
  std::vector<bool> spins;           // for each pose: whether the burr spins during its step; empty: the file does not say
  double longest_gap = 1e-3;         // longest time between two rows of the file [s]; above 1 ms the poses between them are interpolated
};

/// First line `t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz`, then rows of increasing time, at most 0.1 s apart; the first may have
/// any time. A ninth column `spin` may say whether the burr of the tool spins (0 or 1). Rows at each millisecond (to a
/// microsecond) are used unchanged. From other rows, such as motion capture at 100 Hz, the poses at each millisecond
/// are interpolated: positions linearly, orientations by the shortest rotation, `spin` is that of the row before. A
/// recording has the columns t_s, hx_mm, hy_mm, hz_mm, hqw, ... hqz and perhaps spin among others; these are used. A
/// quaternion within 0.1 % of length 1 is normalised. A quaternion that was printed from a normalised one is kept bit
/// for bit, so that a recording replays to the same bytes. Cost: O(size).
/// @throws FormatError with line and column: another header, a missing, additional or malformed field, a number that is
/// not finite or beyond 1e7 mm, a time that does not increase or leaves a gap, a quaternion of another length, no row.
Trajectory parseTrajectory(std::string_view text, const std::string& name);

/// @throws FormatError as parseTrajectory(), FileError if the file cannot be read.
Trajectory readTrajectory(const std::filesystem::path& path);

}  // namespace spheretree::formats
