// SPDX-License-Identifier: GPL-3.0-or-later
// What the programs say: results on stdout, messages on stderr, and one line of progress that never mixes with either.
#pragma once

#include <string>
#include <string_view>

namespace spheretree::tool {

/// `text` as it may go to a terminal: control characters as \n, \t or \x1b, so that a name from a file can neither
/// break a line nor send commands to the terminal. Bytes that are no UTF-8 stay as they are.
std::string plainText(std::string_view text);

/// "1 step", "2 steps"; `plural` where an s is not enough.
std::string counted(std::size_t count, std::string_view what, std::string_view plural = {});

/// As std::printf. Clears the line of progress first. What comes from outside has to go through plainText().
[[gnu::format(printf, 1, 2)]] void printResult(const char* format, ...);

/// Writes `text` to stdout as it is, after the line of progress was cleared.
void writeResult(std::string_view text);

/// One line on stderr, through plainText().
void say(std::string_view line);

/// Columns of the terminal that stderr is; 0 if it is none, or one that cannot go back in its line (TERM=dumb).
int terminalColumns();

/// Draws `text` in place of the line of progress before it, cut to `columns` - 1 characters of ASCII. Only one thread
/// may draw.
void drawProgressLine(std::string_view text, int columns);

/// Takes the line of progress away, if there is one.
void clearProgressLine();

}  // namespace spheretree::tool
