// SPDX-License-Identifier: GPL-3.0-or-later
#include "recording.h"

#include <charconv>
#include <chrono>

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
         "active,qp_iterations,faults,find_us,rows_us,qp_us,total_us\n";
}

void appendRow(std::string& text, const RecordedStep& row) {
  appendNumber(text, row.tick);
  appendNumber(text, row.time);
  appendPose(text, row.haptic);
  appendPose(text, row.graphic);
  for (int k = 0; k < 3; ++k) appendNumber(text, row.wrench.force[k]);
  for (int k = 0; k < 3; ++k) appendNumber(text, row.wrench.torque[k]);
  for (const std::uint32_t count : {row.pairs, row.rows, row.active, row.qp_iterations, row.faults}) appendNumber(text, count);
  for (const double us : {row.find_us, row.rows_us, row.qp_us, row.total_us}) appendNumber(text, us);
  text.back() = '\n';
}

RecordingWriter::RecordingWriter(const std::filesystem::path& path, std::size_t capacity) : ring_(capacity), file_(path) {
  file_.append(recordingHeader());
  thread_ = std::thread([this] { drain(); });
}

RecordingWriter::~RecordingWriter() { stop(); }

bool RecordingWriter::push(const RecordedStep& row) noexcept {
  const std::uint64_t at = written_.load(std::memory_order_relaxed);
  if (at - read_.load(std::memory_order_acquire) == ring_.size()) {
    ++lost_;
    return false;
  }
  ring_[at & (ring_.size() - 1)] = row;
  written_.store(at + 1, std::memory_order_release);
  return true;
}

void RecordingWriter::pushWaiting(const RecordedStep& row) noexcept {
  const std::uint64_t at = written_.load(std::memory_order_relaxed);
  while (at - read_.load(std::memory_order_acquire) == ring_.size() && !failed_.load(std::memory_order_relaxed)) std::this_thread::yield();
  push(row);
}

void RecordingWriter::drain() {
  try {
    std::string text;
    for (;;) {
      const bool last = stop_.load(std::memory_order_acquire);  // before the look at the ring: rows pushed before stop are in it
      const std::uint64_t end = written_.load(std::memory_order_acquire);
      std::uint64_t at = read_.load(std::memory_order_relaxed);
      if (at == end) {
        if (last) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      text.clear();
      for (; at != end; ++at) appendRow(text, ring_[at & (ring_.size() - 1)]);
      read_.store(at, std::memory_order_release);
      file_.append(text);
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
