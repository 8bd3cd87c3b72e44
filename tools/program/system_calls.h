// SPDX-License-Identifier: GPL-3.0-or-later
// What the programs ask of the system: system_calls_posix.cpp and system_calls_windows.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::tool {

/// The words of the command line after the name of the program, in UTF-8.
std::vector<std::string> commandLine(int argc, char** argv);

/// To be called first: writing beyond a limit or to a closed pipe then fails with an error, which is reported and
/// leaves no incomplete file, and what is printed arrives with the same bytes on every system.
void prepareStreams();

enum class Stream { Output = 1, Error = 2 };
bool isTerminal(Stream stream);
/// Of the terminal on stderr; 0 if it does not say.
int terminalWidth();
/// Whether the reader of stdout has closed the pipe, as `head` does after its lines.
bool readerHasGone();

/// Calls `handler` for Ctrl-C, for a request to end, and for a terminal that is closed, unless the program was started
/// with nohup.
void catchInterrupts(void (*handler)(int));
void releaseInterrupts(void (*handler)(int));

/// Appends by one write, so that programs that share the file do not mix their lines. Returns whether it succeeded.
bool appendToFile(const std::filesystem::path& path, std::string_view text);

}  // namespace spheretree::tool
