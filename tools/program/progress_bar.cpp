// SPDX-License-Identifier: GPL-3.0-or-later
#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "json_text.h"

namespace spheretree::tool {
namespace {

constexpr std::chrono::milliseconds kQuietStart{500}, kRedraw{100};

}  // namespace

ProgressBar::ProgressBar(const std::string& kind, bool quiet) {
  if (quiet || kind == "none")
    kind_ = Kind::None;
  else if (kind == "bar")
    kind_ = Kind::Bar;
  else if (kind == "plain")
    kind_ = Kind::Plain;
  else if (kind == "json")
    kind_ = Kind::Json;
  else
    kind_ = ::isatty(STDERR_FILENO) ? Kind::Bar : Kind::None;
}

ProgressBar::~ProgressBar() {
  if (bar_shown_) std::fprintf(stderr, "\r%79s\r", "");
}

void ProgressBar::stage(std::string_view name) {
  stage_ = name;
  stage_shown_ = false;
  stage_start_ = Clock::now();
  draw(0, true);
}

void ProgressBar::advance(double fraction) { draw(std::clamp(fraction, 0.0, 1.0), false); }

double ProgressBar::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

// Of a stage that is long, once enough of it is done to tell.
std::string ProgressBar::timeLeft(double fraction, Clock::time_point now) const {
  const double spent = std::chrono::duration<double>(now - stage_start_).count();
  if (spent < 3 || fraction < 0.02) return "";
  char text[32];
  std::snprintf(text, sizeof text, ", %.0f s left", spent * (1 - fraction) / fraction);
  return text;
}

void ProgressBar::draw(double fraction, bool new_stage) {
  if (kind_ == Kind::None) return;
  const Clock::time_point now = Clock::now();
  if (!new_stage && now - last_drawn_ < kRedraw) return;
  if (kind_ == Kind::Json) {
    last_drawn_ = now;
    const nlohmann::ordered_json line{{"stage", stage_}, {"fraction", fraction}, {"seconds", seconds()}};
    std::fprintf(stderr, "%s\n", jsonText(line, -1).c_str());
    return;
  }
  if (now - start_ < kQuietStart) return;
  last_drawn_ = now;
  if (kind_ == Kind::Plain) {
    if (!stage_shown_) std::fprintf(stderr, "%7.1f s  %s\n", seconds(), stage_.c_str());
    stage_shown_ = true;
    return;
  }
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(fraction * kWidth);
  std::fprintf(stderr, "\r%-30.30s [%.*s%*s] %3d %% %6.1f s%-14s", stage_.c_str(), filled, "##############################",
               kWidth - filled, "", static_cast<int>(fraction * 100), seconds(), timeLeft(fraction, now).c_str());
  std::fflush(stderr);
  bar_shown_ = true;
}

}  // namespace spheretree::tool
