// SPDX-License-Identifier: GPL-3.0-or-later
#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "json_text.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

constexpr std::chrono::milliseconds kQuietStart{500}, kRedraw{100};
constexpr std::chrono::seconds kPlainEvery{10};
constexpr int kColumnsOfNoTerminal = 80;

/// One column for each character: stages name files, whose letters may be of any width.
std::string asciiText(std::string_view text) {
  std::string ascii;
  for (const char c : plainText(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 128)
      ascii += c;
    else if (byte >= 0xc0)
      ascii += '?';
  }
  return ascii;
}

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
  else if (terminalColumns() > 0)
    kind_ = Kind::Bar;
  else
    kind_ = ::isatty(STDERR_FILENO) ? Kind::Plain : Kind::None;  // a terminal that cannot draw over its line
}

ProgressBar::~ProgressBar() { clearProgressLine(); }

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

// A stage that has not said how far it is has no bar: one that stays at 0 % would say that nothing happens.
std::string ProgressBar::barText(double fraction, Clock::time_point now, int columns) const {
  char time[64], percent[16] = "";
  std::snprintf(time, sizeof time, "%.1f s%s", seconds(), timeLeft(fraction, now).c_str());
  if (fraction > 0) std::snprintf(percent, sizeof percent, "%3d %%", static_cast<int>(fraction * 100));
  std::string name = asciiText(stage_).substr(0, 30);
  if (columns < 70) return name.substr(0, 16) + (fraction > 0 ? "  " : "") + percent + "  " + time;
  name.resize(30, ' ');
  constexpr int kWidth = 20;
  if (fraction <= 0) return name + "  " + time;
  std::string bar(kWidth, ' ');
  std::fill_n(bar.begin(), static_cast<int>(fraction * kWidth), '#');
  return name + " [" + bar + "] " + percent + "  " + time;
}

void ProgressBar::drawPlain(double fraction, Clock::time_point now) {
  if (stage_shown_ && now - last_plain_ < kPlainEvery) return;
  char percent[16] = "";
  if (fraction > 0) std::snprintf(percent, sizeof percent, "  %d %%", static_cast<int>(fraction * 100));
  std::fprintf(stderr, "%7.1f s  %s%s%s\n", seconds(), plainText(stage_).c_str(), percent, timeLeft(fraction, now).c_str());
  stage_shown_ = true;
  last_plain_ = now;
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
  if (kind_ == Kind::Plain) return drawPlain(fraction, now);
  const int columns = terminalColumns();
  drawProgressLine(barText(fraction, now, columns > 0 ? columns : kColumnsOfNoTerminal), columns > 0 ? columns : kColumnsOfNoTerminal);
}

}  // namespace spheretree::tool
