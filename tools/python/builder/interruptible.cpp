// SPDX-License-Identifier: GPL-3.0-or-later
#include "interruptible.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace spheretree::python {
namespace {

namespace py = pybind11;

constexpr std::chrono::milliseconds kTurn(50);  // interval between two checks of Python's signals: Ctrl-C seems immediate

/// Collects the reports of the computing thread until Python's thread takes them.
class QueuedProgress : public builder::Progress {
 public:
  struct Event {
    std::string stage;
    double fraction;
  };
  void stage(std::string_view name) override {
    const std::lock_guard lock(mutex_);
    events_.push_back({std::string(name), 0});
    stage_ = name;
  }
  void advance(double fraction) override {
    const std::lock_guard lock(mutex_);
    if (events_.empty()) events_.push_back({stage_, fraction});
    events_.back().fraction = fraction;
  }
  void end() {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    ended_.notify_one();
  }
  /// Waits for the end of the work or of the interval. True after the work has ended.
  bool wait(std::vector<Event>& events) {
    std::unique_lock lock(mutex_);
    ended_.wait_for(lock, kTurn, [&] { return has_ended_; });
    events = std::exchange(events_, {});
    return has_ended_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  std::string stage_;
  std::vector<Event> events_;
  bool has_ended_ = false;
};

}  // namespace

void runInterruptibly(const py::object& callback, const std::function<void(builder::Progress&)>& work) {
  QueuedProgress progress;
  std::exception_ptr of_work, of_python;
  std::thread worker([&] {
    try {
      work(progress);
    } catch (...) {
      of_work = std::current_exception();
    }
    progress.end();
  });
  for (bool has_ended = false; !has_ended;) {
    std::vector<QueuedProgress::Event> events;
    {
      const py::gil_scoped_release release;
      has_ended = progress.wait(events);
    }
    if (of_python) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!callback.is_none())
        for (const QueuedProgress::Event& event : events) callback(event.stage, event.fraction);
    } catch (...) {
      of_python = std::current_exception();
      progress.cancel();
    }
  }
  worker.join();
  if (of_python) std::rethrow_exception(of_python);
  if (of_work) std::rethrow_exception(of_work);
}

}  // namespace spheretree::python
