// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <io.h>
#include <windows.h>
// After windows.h:
#include <shellapi.h>

#include <atomic>
#include <csignal>
#include <cstdlib>

#include "system_calls.h"

namespace spheretree::tool {
namespace {

constexpr int kInterrupts[] = {SIGINT, SIGTERM, SIGBREAK};  // SIGBREAK: also a console that is closed

std::atomic<void (*)(int)> interrupt_handler{nullptr};

/// The system takes a handler away before it calls it.
extern "C" void onInterrupt(int signal) {
  std::signal(signal, onInterrupt);
  if (void (*const handler)(int) = interrupt_handler.load()) handler(signal);
}

}  // namespace

std::vector<std::string> commandLine(int, char**) {  // argv is not in UTF-8
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  std::vector<std::string> utf8;
  for (int k = 1; words && k < count; ++k) {
    std::string word(static_cast<std::size_t>(::WideCharToMultiByte(CP_UTF8, 0, words[k], -1, nullptr, 0, nullptr, nullptr)), '\0');
    ::WideCharToMultiByte(CP_UTF8, 0, words[k], -1, word.data(), static_cast<int>(word.size()), nullptr, nullptr);
    word.resize(word.size() - 1);  // the zero at its end
    utf8.push_back(std::move(word));
  }
  ::LocalFree(words);
  return utf8;
}

void prepareStreams() {
  for (const int stream : {0, 1, 2}) ::_setmode(stream, _O_BINARY);
  if (isTerminal(Stream::Output) || isTerminal(Stream::Error)) ::SetConsoleOutputCP(CP_UTF8);
}

bool isTerminal(Stream stream) {
  DWORD mode = 0;
  return ::GetConsoleMode(reinterpret_cast<HANDLE>(::_get_osfhandle(static_cast<int>(stream))), &mode);
}

int terminalWidth() {
  CONSOLE_SCREEN_BUFFER_INFO screen{};
  return ::GetConsoleScreenBufferInfo(::GetStdHandle(STD_ERROR_HANDLE), &screen) ? screen.dwSize.X : 0;
}

bool readerHasGone() { return _doserrno == ERROR_NO_DATA || _doserrno == ERROR_BROKEN_PIPE; }  // of the write that failed

void catchInterrupts(void (*handler)(int)) {
  interrupt_handler.store(handler);
  for (const int signal : kInterrupts) std::signal(signal, onInterrupt);
}

void releaseInterrupts(void (*)(int)) {
  for (const int signal : kInterrupts) std::signal(signal, SIG_DFL);
  interrupt_handler.store(nullptr);
}

bool appendToFile(const std::filesystem::path& path, std::string_view text) {
  const HANDLE file = ::CreateFileW(path.c_str(), FILE_APPEND_DATA, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
                                    OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) return false;
  DWORD written = 0;
  const bool is_written = ::WriteFile(file, text.data(), static_cast<DWORD>(text.size()), &written, nullptr) && written == text.size();
  ::CloseHandle(file);
  return is_written;
}

}  // namespace spheretree::tool
