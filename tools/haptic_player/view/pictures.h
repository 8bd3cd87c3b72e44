// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of a run without a window: the same frame as in the window, drawn offscreen at chosen steps.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "view/live_view.h"
#include "window/picture_maker.h"

namespace spheretree::player {

/// The steps to draw: one, or several at equal intervals.
struct PictureSteps {
  std::uint64_t first = 0, last = 0, every = 1;
  bool has(std::uint64_t step) const { return step >= first && step <= last && (step - first) % every == 0; }
  bool isOne() const { return first == last; }
};
/// Parses "2000" or "FROM:TO:EVERY". @throws tool::UsageError
PictureSteps pictureSteps(const std::string& text);

/// Parses "1280x800", each from 64 to 8192. @throws tool::UsageError
std::array<int, 2> pictureSize(const std::string& text);

/// OUT.png for one picture; for several, for example OUT.00042.png for step 42.
std::filesystem::path pictureName(const std::filesystem::path& out, const PictureSteps& steps, std::uint64_t step);

struct PictureSettings : ViewSettings {
  std::filesystem::path out;
  PictureSteps steps;
};

/// Draws a picture to the file pictureName(). @throws formats::FileError
void drawPicture(view::PictureMaker& maker, const PictureSettings& settings, std::uint64_t step);

/// Draws pictures during a stepped run.
class PictureObserver final : public PlayObserver {
 public:
  /// Both arguments must outlive the object.
  PictureObserver(const PictureSettings& settings, const PlaySettings& play) : settings_(settings), play_(play) {}
  void onScene(const runtime::SceneDescription& scene) override;
  view::LiveStreams* streams() override { return &shown_.streams; }
  bool onTurn(device::Device& device, ServoLoop& loop) override;
  /// Number of pictures drawn.
  int count() const { return count_; }

 private:
  const PictureSettings& settings_;
  const PlaySettings& play_;
  RunShown shown_;
  std::unique_ptr<view::PictureMaker> maker_;
  int count_ = 0;
};

}  // namespace spheretree::player
