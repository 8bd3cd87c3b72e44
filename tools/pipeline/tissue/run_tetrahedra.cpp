// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/run_tetrahedra.h"

#include <sys/wait.h>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "child_process.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;
using builder::BuildError;

constexpr std::chrono::milliseconds kPoll{5};                // interval between two checks of the child
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;  // limit of its output

std::string surfaceText(const TriangleMesh& surface) {
  std::string text = std::to_string(surface.positions.size()) + " " + std::to_string(surface.triangles.size()) + "\n";
  char line[128];
  for (const Eigen::Vector3d& p : surface.positions) {
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  for (const Triangle& t : surface.triangles) {
    std::snprintf(line, sizeof line, "%u %u %u\n", t[0], t[1], t[2]);
    text += line;
  }
  return text;
}

/// Reads numbers, one after the other.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}
  template <class T>
  T next() {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\n')) ++at_;
    T value{};
    const auto [end, error] = std::from_chars(at_, end_, value);
    if (error != std::errc()) throw BuildError("tetrahedra: spheretree-tetrahedra wrote a file that ends early or holds no numbers");
    at_ = end;
    return value;
  }
  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

 private:
  const char *at_, *end_;
};

TetrahedronList tetrahedraOf(std::string_view text) {
  Numbers numbers(text);
  const auto nodes = numbers.next<std::uint32_t>(), tetrahedra = numbers.next<std::uint32_t>();
  if ((std::size_t{nodes} + tetrahedra) * 6 > numbers.left() + 6)
    throw BuildError("tetrahedra: spheretree-tetrahedra wrote a file that ends early");
  TetrahedronList list;
  list.nodes.resize(nodes);
  list.corners.resize(tetrahedra);
  for (Eigen::Vector3d& p : list.nodes)
    for (int k = 0; k < 3; ++k) p[k] = numbers.next<double>();
  for (auto& corners : list.corners)
    for (std::uint32_t& corner : corners) corner = numbers.next<std::uint32_t>();
  return list;
}

std::string firstLine(const fs::path& path) {
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes, formats::FileRole::Working);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  text = text.substr(0, text.find('\n'));
  if (const std::size_t name = text.find(": "); name != std::string::npos) text = text.substr(name + 2);
  while (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

fs::path tetrahedraProgram() {
  if (const char* named = std::getenv("SPHERETREE_TETRAHEDRA"); named != nullptr && *named != 0) return named;
  std::error_code none;
  const fs::path self = fs::read_symlink("/proc/self/exe", none);
  const fs::path beside = self.parent_path() / "spheretree-tetrahedra";
  return !none && fs::exists(beside, none) ? beside : fs::path("spheretree-tetrahedra");
}

namespace {

// The child, started. @throws BuildError if it is not installed.
tool::ChildProcess start(const std::vector<std::string>& arguments, const fs::path& messages) try {
  return {tetrahedraProgram(), arguments, messages};
} catch (const std::system_error& error) {
  throw BuildError("soft tissue needs the program " + tetrahedraProgram().string() + ", which cannot be run (" + error.code().message() +
                   "). It is built where TetGen is installed (Debian: libtet1.5-dev)");
}

}  // namespace

TetrahedronList runTetrahedra(const TriangleMesh& surface, double max_volume, double seconds, builder::Progress& progress) {
  const tool::ScratchFolder folder;
  const fs::path in = folder / "surface.txt", out = folder / "tetrahedra.txt", messages = folder / "messages.txt";
  formats::writeWhole(in, surfaceText(surface), formats::FileRole::Working);
  tool::ChildProcess child = start({in.string(), out.string(), std::to_string(max_volume)}, messages);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!child.hasEnded()) {
    progress.check();
    if (std::chrono::steady_clock::now() > end) {
      char text[128];
      std::snprintf(text, sizeof text, "tetrahedra: TetGen did not end within %g s. Ask for fewer tetrahedra", seconds);
      throw BuildError(text);
    }
    std::this_thread::sleep_for(kPoll);
  }
  if (WIFSIGNALED(child.status()))
    throw BuildError("tetrahedra: TetGen crashed (signal " + std::to_string(WTERMSIG(child.status())) +
                     "), a known fault for surfaces that nearly touch");
  if (WEXITSTATUS(child.status()) != 0) throw BuildError("tetrahedra: " + firstLine(messages));
  const std::vector<std::byte> bytes = formats::readFile(out, kMaxBytes, formats::FileRole::Working);
  return tetrahedraOf({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace spheretree::pipeline
