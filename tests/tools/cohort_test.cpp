// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/cohort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "support/random.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;

TEST(Cohort, SharesAreBalancedAndTheSameForAll) {
  test::Random random(5);
  for (const std::size_t shards : {1u, 3u, 8u}) {
    std::vector<double> work;
    for (int i = 0; i < 1000; ++i) work.push_back(std::exp(random.between(0, 4)));  // 1 to 55
    const std::vector<std::size_t> shard_of = shareOut(work, shards);
    std::vector<double> load(shards, 0);
    for (std::size_t i = 0; i < work.size(); ++i) {
      ASSERT_GE(shard_of[i], 1u);
      ASSERT_LE(shard_of[i], shards);
      load[shard_of[i] - 1] += work[i];
    }
    const double mean = std::accumulate(load.begin(), load.end(), 0.0) / static_cast<double>(shards);
    EXPECT_GT(mean / *std::max_element(load.begin(), load.end()), 0.99);
    EXPECT_EQ(shareOut(work, shards), shard_of);
  }
}

TEST(Cohort, ALargePatientStandsAlone) {
  EXPECT_EQ(shareOut({1, 10, 1, 1, 1}, 2), (std::vector<std::size_t>{2, 1, 2, 2, 2}));
  EXPECT_EQ(shareOut({1, 1}, 4), (std::vector<std::size_t>{1, 2}));
}

class CohortLogs : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) { formats::writeWhole(folder_ / name, text); }
  const fs::path folder_ = fs::temp_directory_path() / ("cohort_logs_" + std::to_string(::getpid()));
};

PatientResult patient(const std::string& name, PatientState state, std::optional<double> ratio) {
  PatientResult out;
  out.name = name, out.state = state, out.worst_ratio = ratio, out.built = 3, out.seconds = 1.5;
  return out;
}

TEST_F(CohortLogs, ComeBackWorstFirst) {
  std::string log;
  for (const PatientResult& p : {patient("a", PatientState::Ok, 0.2), patient("b", PatientState::Ok, 0.9),
                                 patient("c", PatientState::Refused, std::nullopt), patient("d", PatientState::Missed, 1.5)})
    log += toJson(p).dump() + "\n";
  write("cohort.1-of-1.jsonl", log + "{\"schema\": \"sphere");  // killed as it wrote
  const std::vector<PatientResult> read = readCohortLogs(folder_);
  std::string order;
  for (const PatientResult& p : read) order += p.name;
  EXPECT_EQ(order, "cdba");
  EXPECT_EQ(toJson(read[1]), toJson(patient("d", PatientState::Missed, 1.5)));
}

TEST_F(CohortLogs, AreRefusedWithTheirLine) {
  EXPECT_THROW(readCohortLogs(folder_), formats::FileError);
  const std::string good = toJson(patient("a", PatientState::Ok, 0.2)).dump() + "\n";
  for (const std::string bad : {"{", "[]", "{\"schema\": \"spheretree.cohort/1\"}", "{\"schema\": \"other\"}"}) {
    write("cohort.1-of-1.jsonl", good + bad + "\n");
    try {
      (void)readCohortLogs(folder_);
      ADD_FAILURE() << bad;
    } catch (const formats::FormatError& error) {
      EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace spheretree::pipeline
