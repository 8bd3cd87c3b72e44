// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/recording.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::tool {
namespace {

const std::string kHeader =
    "tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,pairs,rows,active,"
    "qp_iterations,faults,find_us,rows_us,qp_us,total_us\n";

std::filesystem::path written(const std::string& text) {
  static const test::ScratchFolder kFolder;  // of this process alone: tests run side by side
  const std::filesystem::path path = kFolder.path() / "recording_test.csv";
  formats::writeWhole(path, text);
  return path;
}

std::string complaint(const std::string& text) {
  return test::refusalOf<formats::FormatError>([&] { readRecording(written(text)); });
}

Recording still(std::size_t steps) {
  Recording r;
  for (std::size_t i = 0; i < steps; ++i) {
    r.time.push_back(static_cast<float>(i) * 0.001f);
    r.hand.push_back({0, 0, 0, 1, 0, 0, 0});
    r.tool.push_back({0, 0, 0, 1, 0, 0, 0});
    r.wrench.push_back({});
    r.pairs.push_back(0);
    r.total_us.push_back(1);
    r.faults.push_back(0);
  }
  return r;
}

TEST(Recording, PenetrationIsReadWhereItWasRecorded) {
  const std::string row = "0,0,1,2,3,1,0,0,0,1,2,3,1,0,0,0,0,0,0,0,0,0,1,1,1,1,0,1,1,1,1";
  EXPECT_TRUE(readRecording(written(kHeader + row + "\n")).penetration.empty());
  std::string header = kHeader;
  header.insert(header.size() - 1, ",penetration_mm");
  EXPECT_EQ(readRecording(written(header + row + ",0.25\n")).penetration, std::vector<float>{0.25f});
  EXPECT_NE(complaint(header + row + ",deep\n").find("(penetration_mm) is \"deep\""), std::string::npos);
}

TEST(Recording, SaysWhatWasTouchedAndForHowLong) {
  std::string text = kHeader;
  text.insert(text.size() - 1, ",touched");
  const char* const names[] = {"", "tooth_11", "tooth_11", "", "tooth%2012", "tooth_11"};
  for (int n = 0; n < 6; ++n)
    text +=
        std::to_string(n) + ",0.00" + std::to_string(n) + ",1,2,3,1,0,0,0,1,2,3,1,0,0,0,0,0,0,0,0,0,1,1,1,1,0,1,1,1,1," + names[n] + "\n";
  const Recording r = readRecording(written(text));
  ASSERT_EQ(r.touched.size(), 2u);
  EXPECT_EQ(r.touched[0], (std::pair<std::string, std::size_t>("tooth_11", 3)));
  EXPECT_EQ(r.touched[1].first, "tooth 12");
  EXPECT_NEAR(recordingFigures(r).at("touched")[0].at("seconds").get<double>(), 0.003, 1e-6);
}

TEST(Recording, AHandThatBeginsElsewhereGivesNoEnergy) {
  Recording r = still(3);
  r.wrench.assign(3, {1, 0, 0, 0, 0, 0});
  r.hand[1][0] = 9;
  r.hand[2][0] = 59;
  EXPECT_EQ(energyTaken(r), (std::vector<float>{0, -9, -9}));
}

TEST(Recording, ColumnsGoByTheirNames) {
  const Recording r =
      readRecording(written("t_s,extra,total_us,faults,pairs,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,fx_n,fy_n,"
                            "fz_n,tx_nmm,ty_nmm,tz_nmm\n"
                            "0.5,x,7,2,3,1,2,3,1,0,0,0,4,5,6,0,1,0,0,10,11,12,13,14,15\r\n"));
  ASSERT_EQ(r.steps(), 1u);
  EXPECT_EQ(r.time[0], 0.5f);
  EXPECT_EQ(r.hand[0], (std::array<float, 7>{1, 2, 3, 1, 0, 0, 0}));
  EXPECT_EQ(r.tool[0], (std::array<float, 7>{4, 5, 6, 0, 1, 0, 0}));
  EXPECT_EQ(r.wrench[0], (std::array<float, 6>{10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(r.total_us[0], 7);
  EXPECT_EQ(r.pairs[0], 3);
  EXPECT_EQ(r.faults[0], 2u);
}

TEST(Recording, RefusalsNameThePlace) {
  const std::string row = "0,0.001,1,2,3,1,0,0,0,1,2,3,1,0,0,0,0,0,0,0,0,0,1,1,1,1,0,1,1,1,3\n", early = "1,0" + row.substr(7);
  EXPECT_EQ(complaint(kHeader + row), "");
  EXPECT_NE(complaint("a,b\n1,2\n").find("no column t_s"), std::string::npos);
  EXPECT_NE(complaint(kHeader).find("no step"), std::string::npos);
  EXPECT_NE(complaint("").find("empty"), std::string::npos);
  EXPECT_NE(complaint(kHeader + row + "1,2\n").find("line 3: 2 fields, the header has 31"), std::string::npos);
  EXPECT_NE(complaint(kHeader + row + early).find("line 3: column 2 (t_s) is \"0\": the time decreases"), std::string::npos);
  for (const char* bad : {"nan", "inf", "1e99", "x", "", "1 2", "0x1"}) {
    std::string broken = row;
    broken.replace(broken.find(",1,2,3,") + 1, 1, bad);
    EXPECT_NE(complaint(kHeader + broken).find("line 2: column 3 (hx_mm) is"), std::string::npos) << bad;
  }
}

TEST(Recording, EnergyOfAConstantForceIsForceTimesWay) {
  Recording r = still(101);
  for (std::size_t i = 0; i < r.steps(); ++i) r.hand[i][0] = 0.1f * static_cast<float>(i), r.wrench[i] = {-2, 5, 0, 0, 0, 0};
  EXPECT_NEAR(energyTaken(r).back(), 2 * 10, 1e-4) << "the hand pushed 10 mm against 2 N";
  for (auto& w : r.wrench) w[0] = 2;
  EXPECT_NEAR(energyTaken(r).back(), -2 * 10, 1e-4) << "the hand was pushed";
}

TEST(Recording, EnergyOfATurnIsTorqueTimesAngle) {
  Recording r = still(1001);
  for (std::size_t i = 0; i < r.steps(); ++i) {
    const double half = 0.5 * 4.0 * static_cast<double>(i) / 1000;  // 4 rad in all: more than half a turn
    r.hand[i] = {0, 0, 0, static_cast<float>(std::cos(half)), 0, static_cast<float>(std::sin(half)), 0};
    r.wrench[i] = {0, 0, 0, 0, -3, 7};
  }
  EXPECT_NEAR(energyTaken(r).back(), 3 * 4, 1e-3);
}

TEST(Recording, ASampledSpringGivesEnergyAndADampedOneTakesIt) {
  Recording spring = still(4000), damped = spring;
  for (std::size_t i = 0; i < spring.steps(); ++i) {
    const double t = static_cast<double>(i) * 0.001, x = std::sin(2 * std::numbers::pi * t),
                 v = 2 * std::numbers::pi * std::cos(2 * std::numbers::pi * t);
    spring.hand[i][2] = damped.hand[i][2] = static_cast<float>(x);
    spring.wrench[i][2] = static_cast<float>(-x);
    damped.wrench[i][2] = static_cast<float>(-x - 0.05 * v);
  }
  // Holding the force for a step of T loses k T / 2 times the integral of the squared speed, here 4 periods of 1 mm and
  // 1 N/mm.
  const double leak = 0.5 * 0.001 * 0.5 * std::pow(2 * std::numbers::pi, 2) * 4;
  EXPECT_NEAR(energyTaken(spring).back(), -leak, 0.02 * leak);
  EXPECT_GT(energyTaken(damped).back(), 0);
}

TEST(Recording, TheSpectrumShowsASineAtItsFrequencyWithItsAmplitude) {
  std::vector<float> values;
  for (int i = 0; i < 8192; ++i) values.push_back(static_cast<float>(3 + 0.25 * std::sin(2 * std::numbers::pi * 125 * i / 1000.0)));
  const Spectrum s = spectrumOf(values, 1000);
  const auto top = static_cast<std::size_t>(std::max_element(s.amplitude.begin(), s.amplitude.end()) - s.amplitude.begin());
  EXPECT_NEAR(s.hertz[top], 125, 1e-3);
  EXPECT_NEAR(s.amplitude[top], 0.25, 1e-4);
  EXPECT_LT(s.amplitude[0], 1e-4) << "the mean is no vibration";
  EXPECT_LT(s.amplitude[top + 3], 1e-4);
  EXPECT_TRUE(spectrumOf(std::vector<float>(15, 1.0f), 1000).hertz.empty());
}

TEST(Recording, FiguresOfAKnownRun) {
  Recording r = still(10);
  r.wrench[4] = {3, 0, 4, 0, 0, 0};
  r.hand[7][0] = 2;
  r.tool[7][0] = 0.5f;
  r.faults[2] = 4;
  const Json f = recordingFigures(r);
  EXPECT_EQ(f["steps"], 10);
  EXPECT_NEAR(f["largest_force_n"].get<double>(), 5, 1e-6);
  EXPECT_NEAR(f["largest_force_step_n"].get<double>(), 5, 1e-6);
  EXPECT_NEAR(f["largest_hand_to_tool_mm"].get<double>(), 1.5, 1e-6);
  EXPECT_EQ(f["steps_with_faults"], 1);
}

}  // namespace
}  // namespace spheretree::tool
