// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/recording.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "spheretree/formats/csv_table.h"

namespace spheretree::player {
namespace {

template <class Number>
void appendNumber(std::string& text, Number value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
  text += ',';
}

void appendPose(std::string& text, const Configuration& pose) {
  for (int k = 0; k < 3; ++k) appendNumber(text, pose.position[k]);
  for (const double q : {pose.orientation.w(), pose.orientation.x(), pose.orientation.y(), pose.orientation.z()}) appendNumber(text, q);
}

}  // namespace

std::string_view recordingHeader() {
  return "tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,pairs,rows,"
         "active,qp_iterations,faults,find_us,rows_us,qp_us,total_us,penetration_mm\n";
}

void appendRow(std::string& text, const RecordedStep& row) {
  appendNumber(text, row.tick);
  appendNumber(text, row.time);
  appendPose(text, row.haptic);
  appendPose(text, row.graphic);
  for (int k = 0; k < 3; ++k) appendNumber(text, row.wrench.force[k]);
  for (int k = 0; k < 3; ++k) appendNumber(text, row.wrench.torque[k]);
  for (const std::uint32_t count : {row.pairs, row.rows, row.active, row.qp_iterations, row.faults}) appendNumber(text, count);
  for (const double us : {row.find_us, row.rows_us, row.qp_us, row.total_us, row.penetration}) appendNumber(text, us);
  text.back() = '\n';
}

RecordingWriter::RecordingWriter(const std::filesystem::path& path, RunIdentity identity, std::size_t capacity)
    : ring_(capacity), path_(path), identity_(std::move(identity)), file_(path) {
  std::string header(recordingHeader());
  header.insert(header.size() - 1, ",scene,settings,touched,friction_n,slip_mm_s,hinges_deg");
  if (identity_.has_tissue) header.insert(header.size() - 1, ",tissue_states");
  if (identity_.has_passivity) header.insert(header.size() - 1, ",passivity_n,passivity_nmm,passivity_mj");
  if (!identity_.layers.empty()) header.insert(header.size() - 1, ",spin,removed_mm3,layer");
  file_.append(header);
  thread_ = std::thread([this] { drain(); });
}

RecordingWriter::~RecordingWriter() { stop(); }

void RecordingWriter::pushWaiting(const RecordedStep& row) noexcept {
  while (ring_.full() && !failed_.load(std::memory_order_relaxed)) std::this_thread::yield();
  push(row);
}

void RecordingWriter::appendFullRow(std::string& text, const RecordedStep& row) {
  appendRow(text, row);
  text.back() = ',';
  if (!identity_written_) text += formats::encodedField(identity_.scene);
  text += ',';
  if (!identity_written_) text += formats::encodedField(identity_.settings);
  text += ',';
  if (row.touched < identity_.objects.size()) text += formats::encodedField(identity_.objects[row.touched]);
  text += ',';
  appendNumber(text, row.friction);
  appendNumber(text, row.slip);
  for (std::size_t k = 0; k < identity_.hinges; ++k) {
    appendNumber(text, row.hinges[k]);
    text.back() = ';';
  }
  if (identity_.hinges > 0) text.pop_back();
  if (identity_.has_tissue) {
    text += ',';
    appendNumber(text, row.tissue_states);
    text.pop_back();
  }
  if (identity_.has_passivity) {
    text += ',';
    for (const double value : {row.passivity_force, row.passivity_torque, row.passivity_debt}) appendNumber(text, value);
    text.pop_back();
  }
  if (!identity_.layers.empty()) {
    text += row.spins ? ",1," : ",0,";
    appendNumber(text, row.removed);
    if (row.layer < identity_.layers.size()) text += formats::encodedField(identity_.layers[row.layer]);
  }
  text += '\n';
}

void RecordingWriter::drain() {
  try {
    std::string text;
    for (;;) {
      const bool last = stop_.load(std::memory_order_acquire);  // read before the ring, so that rows pushed before the stop are in it
      text.clear();
      const std::size_t rows = ring_.drain([&](const RecordedStep& row) {
        appendFullRow(text, row);
        identity_written_ = true;
      });
      if (rows > 0) {
        file_.append(text);
        continue;
      }
      if (last) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  } catch (...) {
    error_ = std::current_exception();
    failed_.store(true);
  }
}

void RecordingWriter::stop() noexcept {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void RecordingWriter::finish() {
  stop();
  if (error_) std::rethrow_exception(error_);
  file_.commit();
}

}  // namespace spheretree::player
