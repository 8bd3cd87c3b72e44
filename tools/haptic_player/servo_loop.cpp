// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo_loop.h"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <chrono>

namespace spheretree::player {

ServoLoop::ServoLoop(const runtime::Scene& scene, RecordingWriter* recording, const Options& options)
    : scene_(scene), recording_(recording), options_(options), workspace_(scene) {}

device::Rendered ServoLoop::render(const device::DeviceState& state) noexcept {
  using Clock = std::chrono::steady_clock;
  if (options_.real_time_thread && ticks_ == 0) {
    sched_param priority{};
    priority.sched_priority = 80;  // above ordinary programs, below the kernel's own threads
    priority_error_.store(::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority), std::memory_order_relaxed);
  }
  runtime::StageTimes times;
  const double processor_start = threadTime();
  const Clock::time_point start = Clock::now();
  const runtime::StepResult result = runtime::step(scene_, state.tool, options_.mode, workspace_, &times);
  const double total_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  const RecordedStep row = recordedStep(ticks_++, state.tool, result, times, total_us);
  statistics_.add(row, result.penetration, threadTime() - processor_start);
  force_.store(row.wrench.force.norm(), std::memory_order_relaxed);
  time_.store(total_us, std::memory_order_relaxed);
  if (recording_ && options_.wait) recording_->pushWaiting(row);
  if (recording_ && !options_.wait) recording_->push(row);
  return {result.wrench, 0, (result.faults & runtime::kBadInput) != 0};
}

double threadTime() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

RecordedStep recordedStep(std::uint64_t tick, const Configuration& haptic, const runtime::StepResult& result,
                          const runtime::StageTimes& times, double total_us) noexcept {
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) / 1000; };
  return {tick,
          static_cast<double>(tick) / 1000,
          haptic,
          result.graphic,
          result.wrench,
          result.pairs,
          result.rows,
          result.active,
          result.qp_iterations,
          result.faults,
          us(times.find),
          us(times.rows),
          us(times.qp),
          total_us};
}

}  // namespace spheretree::player
