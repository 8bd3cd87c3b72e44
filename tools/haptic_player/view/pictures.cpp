// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/pictures.h"

#include <charconv>
#include <cstdio>
#include <string_view>
#include <vector>

#include "program_end.h"
#include "spheretree/formats/file_io.h"
#include "view/run_panel.h"

namespace spheretree::player {
namespace {

constexpr int kSamples = 4;  // of a pixel, in each direction

/// Whole numbers between dividers; empty if anything else stands there.
std::vector<std::uint64_t> numbersIn(std::string_view text, char divider) {
  std::vector<std::uint64_t> out;
  for (;;) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return {};
    out.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return out;
    if (text.front() != divider) return {};
    text.remove_prefix(1);
  }
}

}  // namespace

PictureSteps pictureSteps(const std::string& text) {
  const std::vector<std::uint64_t> n = numbersIn(text, ':');
  constexpr std::uint64_t kMost = 86'400'000;  // a day
  if (n.size() == 1 && n[0] <= kMost) return {n[0], n[0], 1};
  if (n.size() == 3 && n[0] <= n[1] && n[1] <= kMost && n[2] > 0) return {n[0], n[1], n[2]};
  throw tool::UsageError("--at " + text + ": give a step, as 2000, or FROM:TO:EVERY, as 0:9900:100");
}

std::array<int, 2> pictureSize(const std::string& text) {
  const std::vector<std::uint64_t> n = numbersIn(text, 'x');
  if (n.size() != 2 || n[0] < 64 || n[1] < 64 || n[0] > 8192 || n[1] > 8192)
    throw tool::UsageError("--size " + text + ": give WIDTHxHEIGHT, each from 64 to 8192, as 1280x800");
  return {static_cast<int>(n[0]), static_cast<int>(n[1])};
}

std::filesystem::path pictureName(const std::filesystem::path& out, const PictureSteps& steps, std::uint64_t step) {
  if (steps.isOne()) return out;
  char number[32];
  std::snprintf(number, sizeof number, ".%05llu", static_cast<unsigned long long>((step - steps.first) / steps.every));
  std::filesystem::path name = out;
  return name.replace_filename(out.stem().string() + number + out.extension().string());
}

PictureMaker::PictureMaker(const PictureSettings& settings, view::ViewerState& state)
    : settings_(settings),
      state_(state),
      interface_(settings.scale),
      viewer_(context_.gl(), interface_, state),
      canvas_(context_.gl(), settings.width, settings.height) {}

const view::Layout PictureMaker::layout() const { return view::layoutOf(state_, settings_.width, settings_.height, settings_.scale); }

void PictureMaker::draw(std::uint64_t step) {
  // Windows of the interface find their size in their first frame and show it in the second.
  for (int n = 0; n < 2; ++n) {
    interface_.begin(settings_.width, settings_.height, 1.0 / 60);
    viewer_.frame(settings_.width, settings_.height, n == 0 ? 1 : kSamples, 0, canvas_.id());
  }
  formats::writeWhole(pictureName(settings_.out, settings_.steps, step), view::encodePng(view::readPixels(context_.gl(), canvas_)));
}

void PictureObserver::onScene(const runtime::SceneDescription& scene) {
  shown_.setScene(scene, play_.scene);
  shown_.state.look = look_;
  shown_.state.panels = panels_;
  maker_ = std::make_unique<PictureMaker>(settings_, shown_.state);
}

bool PictureObserver::onTurn(const device::DeviceStatus& status, ServoLoop&) {
  if (status.ticks == 0) return true;
  const std::uint64_t step = status.ticks - 1;
  if (settings_.steps.has(step)) {
    shown_.update();
    const std::vector<view::Lamp> safety = safetyLamps(status.safety, status.safety_so_far);
    shown_.pane().lamps.insert(shown_.pane().lamps.end(), safety.begin(), safety.end());
    if (count_++ == 0)
      shown_.state.camera = view::firstCamera(shown_.stage(), shown_.pane().state.step.graphic.position, maker_->layout().panes[0]);
    maker_->draw(step);
  } else {
    shown_.update();
  }
  return step < settings_.steps.last;
}

}  // namespace spheretree::player
