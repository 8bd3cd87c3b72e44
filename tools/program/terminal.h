// SPDX-License-Identifier: GPL-3.0-or-later
// The output of the programs: results on stdout, messages on stderr, and one progress line that never mixes with
// either.
#pragma once

#include <string>
#include <string_view>

namespace spheretree::tool {

/// `text` in a form that is safe for a terminal: control characters as \n, \t or \x1b, so that a name from a file can
/// neither break a line nor send commands to the terminal. Bytes that are not valid UTF-8 are kept.
std::string plainText(std::string_view text);

/// "1 step", "2 steps"; `plural` for irregular plurals.
std::string counted(std::size_t count, std::string_view what, std::string_view plural = {});

/// Like std::printf, but clears the progress line first. Text from outside must be passed through plainText().
[[gnu::format(printf, 1, 2)]] void printResult(const char* format, ...);

/// Clears the progress line and writes `text` to stdout unchanged.
void writeResult(std::string_view text);

/// Prints one line on stderr, passed through plainText().
void say(std::string_view line);

/// The number of columns if stderr is a terminal; 0 if it is none, or one that cannot overwrite its line (TERM=dumb).
int terminalColumns();

/// Replaces the progress line by `text`, cut to `columns` - 1 characters of ASCII. Only one thread may draw.
void drawProgressLine(std::string_view text, int columns);

/// Clears the progress line, if there is one.
void clearProgressLine();

}  // namespace spheretree::tool
