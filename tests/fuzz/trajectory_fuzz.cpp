// SPDX-License-Identifier: Apache-2.0
// Feeds any text to the reader of trajectories: it is refused with a reason that names the text, or gives poses that a
// servo step accepts.
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/trajectory.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  return {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n0.001,1.5,-2e-3,3,0.6,0.8,0,0\n0.002,1,2,3,0.5,-0.5,0.5,-0.5\n",
          "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\r\n7.25,0,0,0,-1,0,0,0\r\n\r\n",
          "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin\n0,0,0,0,1,0,0,0,1\n0.05,0,0,0,1,0,0,0,0\n",
          "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.05,0,0,0,1,0,0,0\n0.0612,0,1,0,0,1,0,0\n",
          "tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,fx_n,faults\n0,0,1,2,3,1,0,0,0,1,0.5,0\n1,0.001,1,2,3,1,0,0,0,1,nan,2\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  try {
    const formats::Trajectory read = formats::parseTrajectory({reinterpret_cast<const char*>(data), size}, "input");
    const std::vector<Configuration>& poses = read.poses;
    fuzz::require(read.spins.empty() || read.spins.size() == poses.size(), "every pose or none says whether the burr spins");
    fuzz::require(!poses.empty() && poses.size() <= 102 * size, "no more poses than 0.1 s a row");
    for (const Configuration& pose : poses) {
      fuzz::require(isFinite(pose) && pose.position.cwiseAbs().maxCoeff() <= 1e7, "a pose is finite and within 1e7 mm");
      fuzz::require(std::abs(pose.orientation.norm() - 1) < 1e-14, "an orientation is of unit length");
    }
  } catch (const formats::FormatError& error) {
    fuzz::require(std::string(error.what()).starts_with("input"), "a refusal names the text");
  }
  return 0;
}
