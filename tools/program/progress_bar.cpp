// SPDX-License-Identifier: GPL-3.0-or-later
#include "progress_bar.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "json_text.h"
#include "system_calls.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

constexpr std::chrono::milliseconds kQuietStart{500}, kRedraw{100};
constexpr std::chrono::seconds kPlainEvery{10};
constexpr int kColumnsOfNoTerminal = 80;

/// One column for each character: the names of stages contain file names, whose letters may have any width.
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
    kind_ = isTerminal(Stream::Error) ? Kind::Plain : Kind::None;  // a terminal that cannot overwrite its line
}

ProgressBar::~ProgressBar() { clearProgressLine(); }

void ProgressBar::stage(std::string_view name) {
  stage_ = name;
  stage_shown_ = false;
  stage_start_ = Clock::now();
  objects_.reset();
  draw(0, true);
}

void ProgressBar::advance(double fraction) { draw(std::clamp(fraction, 0.0, 1.0), false); }

void ProgressBar::share(double begin, double end) { share_ = Share{begin, end}; }

void ProgressBar::advance(double fraction, const Objects& objects) {
  objects_ = objects;
  advance(fraction);
}

void ProgressBar::finished(const Finished& object) {
  if (kind_ == Kind::Json) {
    nlohmann::ordered_json line{{"object", object.name}, {"built", object.is_built}, {"seconds", object.seconds}};
    if (object.is_built) line.update({{"leaves", object.leaves}, {"overhang_bound_mm", object.overhang_bound_mm}});
    std::fprintf(stderr, "%s\n", jsonText(line, -1).c_str());
  }
  if ((kind_ != Kind::Bar && kind_ != Kind::Plain) || Clock::now() - start_ < kQuietStart) return;
  constexpr int kFigureColumns = 33, kNameColumns = 32;
  const int columns = terminalColumns();
  const int name_columns = columns > 0 ? std::clamp(columns - kFigureColumns, 8, kNameColumns) : kNameColumns;
  char line[128];
  if (!header_shown_) {
    std::snprintf(line, sizeof line, "%-*s %7s %12s %10s", name_columns, "object", "leaves", "bound [mm]", "time [s]");
    say(line);
    header_shown_ = true;
  }
  std::string name = asciiText(object.name);
  if (name.size() > static_cast<std::size_t>(name_columns)) name = name.substr(0, static_cast<std::size_t>(name_columns) - 3) + "...";
  if (object.is_built)
    std::snprintf(line, sizeof line, "%-*s %7zu %12.3g %10.1f", name_columns, name.c_str(), object.leaves, object.overhang_bound_mm,
                  object.seconds);
  else
    std::snprintf(line, sizeof line, "%-*s %7s %12s %10.1f", name_columns, name.c_str(), "failed", "", object.seconds);
  say(line);
}

double ProgressBar::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

// Estimates the remaining time of a long stage, after a sufficient part of it is done.
std::optional<double> ProgressBar::secondsLeft(double fraction, Clock::time_point now) const {
  const double spent = std::chrono::duration<double>(now - stage_start_).count();
  if (spent < 3 || fraction < 0.02) return std::nullopt;
  return spent * (1 - fraction) / fraction;
}

std::string ProgressBar::timeLeft(double fraction, Clock::time_point now) const {
  const std::optional<double> left = secondsLeft(fraction, now);
  if (!left) return "";
  char text[32];
  std::snprintf(text, sizeof text, ", %.0f s left", *left);
  return text;
}

/// For example "12 of 33: tooth_11, tooth_12".
std::string ProgressBar::objectsText() const {
  std::string text = std::to_string(objects_->done) + " of " + std::to_string(objects_->count);
  for (std::size_t i = 0; i < objects_->running.size(); ++i) text += (i ? ", " : ": ") + asciiText(objects_->running[i]);
  return text;
}

// A stage without a known fraction has no bar, since a bar at 0 % would suggest that nothing happens.
std::string ProgressBar::barText(double fraction, Clock::time_point now, int columns) const {
  char time[64], percent[16] = "";
  std::snprintf(time, sizeof time, "%.1f s%s", seconds(), timeLeft(fraction, now).c_str());
  const double shown = whole(fraction);
  if (shown > 0) std::snprintf(percent, sizeof percent, "%3d %%", static_cast<int>(shown * 100));
  std::string name = (objects_ ? objectsText() : asciiText(stage_)).substr(0, 30);
  if (columns < 70) return name.substr(0, 16) + (shown > 0 ? "  " : "") + percent + "  " + time;
  name.resize(30, ' ');
  constexpr int kWidth = 20;
  if (shown <= 0) return name + "  " + time;
  std::string bar(kWidth, ' ');
  std::fill_n(bar.begin(), static_cast<int>(shown * kWidth), '#');
  return name + " [" + bar + "] " + percent + "  " + time;
}

void ProgressBar::drawPlain(double fraction, Clock::time_point now) {
  if (stage_shown_ && now - last_plain_ < kPlainEvery) return;
  char percent[16] = "";
  if (whole(fraction) > 0) std::snprintf(percent, sizeof percent, "  %d %%", static_cast<int>(whole(fraction) * 100));
  const std::string text = objects_ ? plainText(stage_) + ", " + objectsText() : plainText(stage_);
  std::fprintf(stderr, "%7.1f s  %s%s%s\n", seconds(), text.c_str(), percent, timeLeft(fraction, now).c_str());
  stage_shown_ = true;
  last_plain_ = now;
}

void ProgressBar::draw(double fraction, bool new_stage) {
  if (kind_ == Kind::None) return;
  const Clock::time_point now = Clock::now();
  if (!new_stage && fraction < 1 && now - last_drawn_ < kRedraw) return;
  if (kind_ == Kind::Json) {
    last_drawn_ = now;
    nlohmann::ordered_json line{{"stage", stage_}, {"fraction", fraction}, {"seconds", seconds()}};
    if (share_) line["overall"] = whole(fraction);
    if (objects_) line.update({{"done", objects_->done}, {"of", objects_->count}, {"running", objects_->running}});
    if (const std::optional<double> left = secondsLeft(fraction, now)) line["seconds_left"] = *left;
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
