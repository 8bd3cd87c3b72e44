// SPDX-License-Identifier: GPL-3.0-or-later
#include "window/capture.h"

#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>
#include <thread>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::view {

std::filesystem::path freeName(const std::filesystem::path& base, const std::string& ending) {
  for (int n = 1;; ++n) {
    std::filesystem::path name = base;
    name.replace_filename(base.stem().string() + "-" + std::to_string(n) + ending);
    if (std::error_code none; !std::filesystem::exists(std::filesystem::symlink_status(name, none))) return name;
  }
}

struct FilmWriter::Work {
  static constexpr std::size_t kWaiting = 12;  // frames that wait for the disk: half a second
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::pair<std::filesystem::path, Picture>> queue;
  std::string fault;
  bool is_ended = false;
  std::thread thread;

  void run() {
    for (;;) {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return is_ended || !queue.empty(); });
      if (queue.empty()) return;
      const auto [name, picture] = std::move(queue.front());
      lock.unlock();
      std::string why;
      try {
        formats::writeWhole(name, encodePng(picture));
      } catch (const std::exception& error) {
        why = error.what();
      }
      lock.lock();
      queue.pop_front();
      if (fault.empty()) fault = why;
    }
  }
};

FilmWriter::FilmWriter(const std::filesystem::path& folder) : folder_(folder), work_(std::make_unique<Work>()) {
  std::error_code error;
  if (!std::filesystem::create_directory(folder, error))
    throw formats::FileError(folder.string() + ": the folder of the film cannot be made: " + error.message());
  work_->thread = std::thread([work = work_.get()] { work->run(); });
}

FilmWriter::~FilmWriter() { (void)finish(); }

bool FilmWriter::wants(double time) const {
  const std::lock_guard lock(work_->mutex);
  return work_->fault.empty() && work_->queue.size() < Work::kWaiting &&
         (frames_ == 0 || time >= first_ + static_cast<double>(frames_) / kRate);
}

void FilmWriter::add(double time, Picture picture) {
  char number[32];
  std::snprintf(number, sizeof number, "%05zu.png", ++frames_);
  if (frames_ == 1) first_ = time;
  last_ = time;
  const std::lock_guard lock(work_->mutex);
  work_->queue.emplace_back(folder_ / number, std::move(picture));
  work_->changed.notify_one();
}

std::string FilmWriter::finish() {
  if (work_->thread.joinable()) {
    {
      const std::lock_guard lock(work_->mutex);
      work_->is_ended = true;
      work_->changed.notify_one();
    }
    work_->thread.join();
  }
  if (!work_->fault.empty()) return "the film ended: " + work_->fault;
  const double rate = frames_ > 1 && last_ > first_ ? static_cast<double>(frames_ - 1) / (last_ - first_) : kRate;
  char text[64];
  std::snprintf(text, sizeof text, "%zu frames: ffmpeg -framerate %.1f -i '", frames_, rate);
  return text + (folder_ / "%05d.png").string() + "' -pix_fmt yuv420p '" + folder_.string() + ".mp4'";
}

Capture::~Capture() { (void)end(); }

std::string Capture::take(const Gl& gl, int width, int height, bool wants_picture, bool wants_film) try {
  std::string message;
  if (wants_film) {
    if (film_) {
      message = end();
    } else {
      film_ = std::make_unique<FilmWriter>(freeName(base_, "-film"));
      begun_ = std::chrono::steady_clock::now();
    }
  }
  if (wants_picture) {
    const std::filesystem::path name = freeName(base_, ".png");
    formats::writeWhole(name, encodePng(readPixels(gl, width, height)));
    message = "written: " + name.string();
  }
  const double time = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
  if (film_ && film_->wants(time)) film_->add(time, readPixels(gl, width & ~1, height & ~1));  // films have even sizes
  return message;
} catch (const std::exception& error) {
  film_.reset();
  return error.what();
}

std::string Capture::end() {
  if (!film_) return "";
  const std::string sentence = film_->finish();
  film_.reset();
  return sentence;
}

}  // namespace spheretree::view
