// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/trajectory.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <string>

#include "spheretree/formats/errors.h"
#include "support/random.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

const std::string kHeader = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";

std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string messageOf(const std::string& text) {
  return test::refusalOf<FormatError>([&] { parseTrajectory(text, "in.csv"); });
}

TEST(Trajectory, ReadsPosesInOrder) {
  const auto poses = parseTrajectory(kHeader + "5,1,2,3,1,0,0,0\r\n5.001,-1e-3,0,+4,0,0.6,0,0.8\n\n", "in.csv").poses;
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(poses[1].position, Eigen::Vector3d(-1e-3, 0, 4));
  EXPECT_EQ(poses[1].orientation.x(), 0.6);
  EXPECT_EQ(poses[1].orientation.z(), 0.8);
}

TEST(Trajectory, NormalisesWhatIsNearlyUnit) {
  const auto poses = parseTrajectory(kHeader + "0,0,0,0,0.7071,0.7071,0,0\n", "in.csv").poses;
  EXPECT_NEAR(poses[0].orientation.norm(), 1, 1e-15);
}

TEST(Trajectory, RecordingReplaysToTheBit) {
  test::Random random(1);
  std::string text = "tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,fx_n\n";
  std::vector<Configuration> sent;
  for (int n = 0; n < 10'000; ++n) {
    Configuration q = moved({random.inCube(500), rotationOf(random.inCube(2))}, {random.inCube(1), random.inCube(3)});
    text += std::to_string(n) + "," + shortest(n * 1e-3);
    for (const double v :
         {q.position.x(), q.position.y(), q.position.z(), q.orientation.w(), q.orientation.x(), q.orientation.y(), q.orientation.z()})
      (text += ',') += shortest(v);
    text += ",7,nan\n";
    sent.push_back(q);
  }
  const auto poses = parseTrajectory(text, "in.csv").poses;
  ASSERT_EQ(poses.size(), sent.size());
  for (std::size_t n = 0; n < poses.size(); ++n) {
    ASSERT_EQ(poses[n].position, sent[n].position) << n;
    for (int k = 0; k < 4; ++k)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(poses[n].orientation.coeffs()[k]),
                std::bit_cast<std::uint64_t>(sent[n].orientation.coeffs()[k]))
          << n;
  }
}

TEST(Trajectory, RefusesWithLineAndColumn) {
  const std::string row = "0,0,0,0,1,0,0,0\n";
  const std::pair<std::string, std::string> cases[] = {
      {"", "empty"},
      {"x,y\n" + row, "line 1: the header is \"x,y\""},
      {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,more\n", "line 1: the header"},
      {"t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy\n", "no column hqz"},
      {kHeader, "no row"},
      {kHeader + "0,0,0,0,1,0,0\n", "line 2: 7 fields, the header has 8"},
      {kHeader + "0,0,0,0,1,0,0,0,\n", "line 2: 9 fields"},
      {kHeader + row + "0.001,0,zero,0,1,0,0,0\n", "line 3: column 3 (y_mm) is \"zero\""},
      {kHeader + "0,0,0,0,1,0,0,nan\n", "column 8 (qz) is \"nan\""},
      {kHeader + "0,inf,0,0,1,0,0,0\n", "column 2 (x_mm) is \"inf\""},
      {kHeader + "0,2e7,0,0,1,0,0,0\n", "column 2 (x_mm) is \"2e7\""},
      {kHeader + "0,0,0,0,,0,0,0\n", "column 5 (qw) is \"\""},
      {kHeader + "0,0,0,0,1,1,0,0\n", "has length 1.414"},
      {kHeader + "0,0,0,0,0,0,0,0\n", "has length 0"},
      {kHeader + row + "0.2,0,0,0,1,0,0,0\n", "line 3: t_s is 0.2, 0.2 s after the row before"},
      {kHeader + row + "0,0,0,0,1,0,0,0\n", "line 3: t_s is 0, not after the 0"},
      {kHeader + row + "-1,0,0,0,1,0,0,0\n", "line 3: t_s is -1, not after the 0"},
  };
  for (const auto& [text, expected] : cases)
    EXPECT_NE(messageOf(text).find(expected), std::string::npos) << text << "gave: " << messageOf(text);
}

/// A circle, rotated with its angle: straight lines between its rows are off by at most r (1 - cos(step / 2)).
TEST(Trajectory, OtherRatesAreInterpolated) {
  for (const double rate : {20., 60., 100., 143., 2000.}) {
    std::string text = kHeader;
    const auto rows = static_cast<int>(rate);
    for (int n = 0; n <= rows; ++n) {
      const double a = n / rate;
      text += shortest(n / rate) + "," + shortest(10 * std::cos(a)) + "," + shortest(10 * std::sin(a)) + ",0," + shortest(std::cos(a / 2)) +
              ",0,0," + shortest(std::sin(a / 2)) + "\n";
    }
    const Trajectory read = parseTrajectory(text, "in.csv");
    EXPECT_NEAR(read.longest_gap, 1 / rate, 1e-9);
    ASSERT_EQ(read.poses.size(), 1001u) << rate;
    for (int n = 0; n <= 1000; ++n) {
      const Configuration& pose = read.poses[static_cast<std::size_t>(n)];
      const double a = n / 1000.0;
      EXPECT_LE((pose.position - Eigen::Vector3d(10 * std::cos(a), 10 * std::sin(a), 0)).norm(), 10 * (1 - std::cos(0.5 / rate)) + 1e-5);
      EXPECT_NEAR(rotationVector(pose.orientation).z(), a, 2e-6 + 1e-6 * a);
    }
  }
}

TEST(Trajectory, SaysWhetherTheBurrSpins) {
  const std::string header = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin\n";
  EXPECT_TRUE(parseTrajectory(kHeader + "0,0,0,0,1,0,0,0\n", "in.csv").spins.empty());
  EXPECT_EQ(parseTrajectory(header + "0,0,0,0,1,0,0,0,1\n0.001,0,0,0,1,0,0,0,0\n", "in.csv").spins, (std::vector<bool>{true, false}));
  // Between rows the burr does as in the row before.
  EXPECT_EQ(parseTrajectory(header + "0,0,0,0,1,0,0,0,1\n0.003,0,0,0,1,0,0,0,0\n0.005,0,0,0,1,0,0,0,1\n", "in.csv").spins,
            (std::vector<bool>{true, true, true, false, false, true}));
  EXPECT_EQ(parseTrajectory("spin,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz\n1,0,0,0,0,1,0,0,0\n", "in.csv").spins, std::vector<bool>{true});
  EXPECT_NE(messageOf(header + "0,0,0,0,1,0,0,0,2\n").find("column 9 (spin) is \"2\""), std::string::npos);
  EXPECT_NE(messageOf("t_s,x_mm,y_mm,z_mm,qw,qx,qy,spin,qz\n").find("line 1: the header"), std::string::npos);
}

TEST(Trajectory, MissingFileIsAFileError) { EXPECT_THROW(readTrajectory("/nowhere/in.csv"), FileError); }

}  // namespace
}  // namespace spheretree::formats
