// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/pictures.h"

#include <charconv>
#include <cstdio>
#include <string_view>
#include <vector>

#include "program_end.h"
#include "run/servo_loop.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "view/run_panel.h"

namespace spheretree::player {
namespace {

/// Integers between dividers; empty if the text has anything else.
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
  constexpr std::uint64_t kMax = 86'400'000;  // a day
  if (n.size() == 1 && n[0] <= kMax) return {n[0], n[0], 1};
  if (n.size() == 3 && n[0] <= n[1] && n[1] <= kMax && n[2] > 0) return {n[0], n[1], n[2]};
  throw tool::UsageError("--at " + text + ": give a step, such as 2000, or FROM:TO:EVERY, such as 0:9900:100");
}

std::array<int, 2> pictureSize(const std::string& text) {
  if (const auto size = view::sizeOf(text)) return *size;
  throw tool::UsageError("--size " + text + ": give WIDTHxHEIGHT, each from 64 to 8192, such as 1280x800");
}

std::filesystem::path pictureName(const std::filesystem::path& out, const PictureSteps& steps, std::uint64_t step) {
  if (steps.isOne()) return out;
  char number[32];
  std::snprintf(number, sizeof number, ".%05llu", static_cast<unsigned long long>((step - steps.first) / steps.every));
  std::filesystem::path name = out;
  return name.replace_filename(out.stem().string() + number + out.extension().string());
}

void drawPicture(view::PictureMaker& maker, const PictureSettings& settings, std::uint64_t step) {
  const std::filesystem::path name = pictureName(settings.out, settings.steps, step);
  if (!settings.steps.isOne()) tool::RunFiles().willMake(name);
  formats::writeWhole(name, view::encodePng(maker.draw()));
}

void PictureObserver::onScene(const runtime::SceneDescription& scene) {
  shown_.setScene(scene, play_.scene);
  shown_.state.look = settings_.look;
  shown_.state.look.skin_contact = play_.contact == runtime::ContactSurface::Skin;
  shown_.state.panels = settings_.panels;
  shown_.state.follow = settings_.follow;
  maker_ = std::make_unique<view::PictureMaker>(settings_.width, settings_.height, settings_.scale, shown_.state);
}

bool PictureObserver::onTurn(device::Device& device, ServoLoop& loop) {
  const device::DeviceStatus status = device.status();
  if (status.ticks == 0) return true;
  const std::uint64_t step = status.ticks - 1;
  if (settings_.steps.has(step)) {
    shown_.update(loop.tissue());
    const std::vector<view::Lamp> safety = safetyLamps(status.safety, status.safety_so_far);
    shown_.pane().lamps.insert(shown_.pane().lamps.end(), safety.begin(), safety.end());
    if (count_++ == 0)
      shown_.state.camera = view::wishedCamera(shown_.stage(), shown_.pane().state.step.graphic, settings_.wish, maker_->layout().panes[0]);
    drawPicture(*maker_, settings_, step);
  } else {
    shown_.update(loop.tissue());
  }
  return step < settings_.steps.last;
}

}  // namespace spheretree::player
