// SPDX-License-Identifier: GPL-3.0-or-later
// The basis of the plots and the time slider: playback.h, history.h
#include <gtest/gtest.h>

#include <vector>

#include "panel/history.h"
#include "replay/playback.h"

namespace spheretree::view {
namespace {

TEST(Playback, PlaysAtItsSpeedAndWaitsAtTheEnd) {
  Playback playback(1001);
  playback.advance(0.1);
  EXPECT_EQ(playback.step(), 0u);  // it is paused at first
  playback.play();
  playback.advance(0.25);
  EXPECT_EQ(playback.step(), 250u);
  playback.setSpeed(0.1);
  playback.advance(0.25);
  EXPECT_EQ(playback.step(), 275u);
  playback.setSpeed(8);
  playback.advance(1);
  EXPECT_EQ(playback.step(), 1000u);
  EXPECT_FALSE(playback.isPlaying());
  playback.toggle();  // from the start again
  EXPECT_EQ(playback.step(), 0u);
  EXPECT_TRUE(playback.isPlaying());
}

TEST(Playback, JumpsStayInside) {
  Playback playback(10);
  playback.seek(1e18);
  EXPECT_EQ(playback.step(), 9u);
  playback.seek(-5);
  EXPECT_EQ(playback.step(), 0u);
  playback.play();
  playback.nudge(3);
  EXPECT_EQ(playback.step(), 3u);
  EXPECT_FALSE(playback.isPlaying());
  playback.nudge(-100);
  EXPECT_EQ(playback.step(), 0u);
  playback.setSpeed(0);
  EXPECT_GT(playback.speed(), 0);
  Playback one(1);
  one.play();
  one.advance(1);
  EXPECT_EQ(one.step(), 0u);
}

TEST(Playback, LoopsWhenAsked) {
  Playback playback(101);
  playback.loops = true;
  playback.play();
  playback.advance(0.130);
  EXPECT_EQ(playback.step(), 30u);
  EXPECT_TRUE(playback.isPlaying());
}

TEST(History, KeepsTheLastMinuteInOrder) {
  History history;
  PlotSample sample{};
  for (int n = 0; n < 200'000; ++n) {
    sample.time = n / 1000.0;
    history.add(sample);
  }
  const auto samples = history.samples();
  EXPECT_GE(samples.size(), History::kKept);
  EXPECT_DOUBLE_EQ(samples.back().time, 199.999);
  for (std::size_t n = 1; n < samples.size(); ++n) ASSERT_LT(samples[n - 1].time, samples[n].time);
  EXPECT_EQ(lastOf(samples, 2).size(), 2001u);
  EXPECT_EQ(lastOf(samples.first(10), 60).size(), 10u);
  EXPECT_TRUE(lastOf({}, 1).empty());
}

TEST(History, StepTimesAreQuantiles) {
  std::vector<PlotSample> samples(100);
  for (std::size_t n = 0; n < samples.size(); ++n) samples[n].step_us = static_cast<float>((n * 37) % 100);  // 0 .. 99, unordered
  const StepTimes times = stepTimes(samples);
  EXPECT_EQ(times.median, 49);
  EXPECT_EQ(times.p99, 98);
  EXPECT_EQ(times.longest, 99);
  EXPECT_EQ(stepTimes({}).longest, 0);
}

}  // namespace
}  // namespace spheretree::view
