// SPDX-License-Identifier: Apache-2.0
// What the tests of reading and writing whole files share.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "support/texts.h"

namespace spheretree::test {

inline std::string textOf(const std::vector<std::byte>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// Message of the FileError that `call` throws; "" if it throws none.
template <class Call>
std::string fileError(Call&& call) {
  return refusalOf<formats::FileError>(call);
}

inline std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// Makes `path` look as if it was last written `age` seconds ago.
inline void makeOlder(const std::filesystem::path& path, int age) {
  std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - std::chrono::seconds(age));
}

struct Told : formats::FileObserver {
  std::vector<std::string> lines;
  std::atomic<bool> interrupted = false;
  void onRead(const std::filesystem::path& path, const formats::FileId&) override { lines.push_back("read " + path.filename().string()); }
  void onWrite(const std::filesystem::path& path, const std::filesystem::path& target, const std::optional<formats::FileId>& id,
               formats::FileRole) override {
    lines.push_back("write " + path.filename().string() + " as " + target.filename().string() + (id ? " over it" : ""));
    if (path.filename() == "refused") throw std::logic_error("refused");
  }
  void onComplete(const std::filesystem::path& path, const std::filesystem::path& target, const std::filesystem::path& complete,
                  formats::FileRole) override {
    const std::vector<std::byte> bytes = formats::readFile(complete, 10, formats::FileRole::Working);
    lines.push_back("complete " + path.filename().string() + (complete == target ? " there already: " : ": ") +
                    std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  void onWritten(const std::filesystem::path& target, formats::FileRole) override {
    lines.push_back("written " + target.filename().string());
  }
  void checkInterrupted() override {
    if (interrupted) throw std::runtime_error("interrupted");
  }
};

/// Sets an observer during its own lifetime.
struct Observing {
  explicit Observing(formats::FileObserver& observer) : before(formats::setFileObserver(&observer)) {}
  ~Observing() { formats::setFileObserver(before); }
  formats::FileObserver* before;
};

}  // namespace spheretree::test
