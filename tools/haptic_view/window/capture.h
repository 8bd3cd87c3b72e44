// SPDX-License-Identifier: GPL-3.0-or-later
// Screenshots and films of a window, as PNG files under names that are free.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "draw/offscreen.h"

namespace spheretree::view {

/// `base` without its ending, then -N and `ending`, with the smallest N >= 1 that no file has.
std::filesystem::path freeName(const std::filesystem::path& base, const std::string& ending);

/// Writes the frames of a film into a folder of its own, in a thread of its own.
class FilmWriter {
 public:
  static constexpr double kRate = 25;  // frames a second, if the window draws as many
  /// @throws formats::FileError if the folder cannot be made.
  explicit FilmWriter(const std::filesystem::path& folder);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// Whether the film has room for a frame at this time [s], since its beginning. A frame is left out while the disk
  /// is behind.
  bool wants(double time) const;
  void add(double time, Picture picture);
  /// Waits for the last frame. Returns a sentence: how many frames, where, and the command that makes a film of them;
  /// or what failed.
  std::string finish();
  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct Work;
  std::filesystem::path folder_;
  std::unique_ptr<Work> work_;
  std::size_t frames_ = 0;
  double first_ = 0, last_ = 0;  // times of frames [s]
};

/// What the keys of a window ask for.
class Capture {
 public:
  /// `base`: a path that names are made of, for example that of the recording.
  explicit Capture(std::filesystem::path base) : base_(std::move(base)) {}
  ~Capture();

  /// Call it after each frame, before the window shows it; reads the bound framebuffer of this size. Takes the requests
  /// and returns a message for the user; empty if there is none.
  std::string take(const Gl& gl, int width, int height, bool wants_picture, bool wants_film);
  /// Ends the film, if there is one, and returns its sentence.
  std::string end();
  /// The folder of the film that is being made; empty: none.
  std::string film() const { return film_ ? film_->folder().string() : ""; }

 private:
  std::filesystem::path base_;
  std::unique_ptr<FilmWriter> film_;
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace spheretree::view
