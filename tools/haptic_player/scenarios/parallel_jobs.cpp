// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenarios/parallel_jobs.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace spheretree::player {
namespace {

constexpr std::chrono::milliseconds kLookInterval{100};  // how soon Ctrl-C reaches the threads, and how often the bar moves

class JobRun {
 public:
  JobRun(std::span<const Job> jobs, const ScenarioContext& context, std::size_t threads)
      : jobs_(jobs), context_(context), has_ended_(jobs.size(), false), progress_of_(threads) {}

  void run(tool::WorkProgress& progress, const std::function<void(std::size_t)>& done) {
    {
      std::vector<std::jthread> threads;
      for (builder::Progress& own : progress_of_) threads.emplace_back([this, &own] { work(own); });
      std::size_t told = 0;
      std::unique_lock lock(mutex_);
      while (told < jobs_.size() && !error_) {
        job_ended_.wait_for(lock, kLookInterval);
        if (progress.cancelled()) fail(std::make_exception_ptr(builder::Cancelled()));
        for (; told < jobs_.size() && has_ended_[told] && !error_; ++told) {
          lock.unlock();
          std::exception_ptr thrown;
          try {
            if (done) done(told);
          } catch (...) {
            thrown = std::current_exception();
          }
          lock.lock();
          if (thrown) fail(thrown);
        }
        show(progress);
      }
    }  // waits for the threads
    if (error_) std::rethrow_exception(error_);
  }

 private:
  /// A thread: takes jobs until there are none.
  void work(builder::Progress& own) {
    BodyLibrary bodies = context_.bodies.sharing(own);
    ScenarioContext context{bodies, context_.settings, own};
    std::unique_lock lock(mutex_);
    while (begun_ < jobs_.size() && !error_) {
      const std::size_t job = begun_++;
      running_.push_back(job);
      lock.unlock();
      std::exception_ptr thrown;
      try {
        jobs_[job].run(context);
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      std::erase(running_, job);
      ++ended_;
      has_ended_[job] = !thrown;
      if (thrown) fail(thrown);
      job_ended_.notify_one();
    }
  }

  /// Keeps the first error. The lock is held.
  void fail(const std::exception_ptr& error) {
    if (!error_) error_ = error;
    for (builder::Progress& own : progress_of_) own.cancel();
  }

  /// The lock is held.
  void show(tool::WorkProgress& progress) const {
    tool::WorkProgress::Objects objects{ended_, jobs_.size(), {}};
    for (const std::size_t job : running_) objects.running.push_back(jobs_[job].name);
    progress.advance(static_cast<double>(ended_) / static_cast<double>(jobs_.size()), objects);
  }

  std::span<const Job> jobs_;
  const ScenarioContext& context_;
  std::mutex mutex_;  // protects everything below
  std::condition_variable job_ended_;
  std::vector<bool> has_ended_;  // without an exception
  std::vector<std::size_t> running_;
  std::size_t begun_ = 0, ended_ = 0;
  std::exception_ptr error_;
  std::vector<builder::Progress> progress_of_;  // of each thread; they show nothing, and pass Ctrl-C on
};

}  // namespace

void runJobs(std::span<const Job> jobs, const ScenarioContext& context, int threads, tool::WorkProgress& progress,
             const std::function<void(std::size_t)>& done) {
  if (jobs.empty()) return;
  JobRun(jobs, context, std::clamp<std::size_t>(static_cast<std::size_t>(std::max(1, threads)), 1, jobs.size())).run(progress, done);
}

}  // namespace spheretree::player
