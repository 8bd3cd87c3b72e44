// SPDX-License-Identifier: Apache-2.0
// make_samples FOLDER: writes the sample meshes molar.obj and probe.obj, in millimetres. The same bytes on every machine.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "molar.h"
#include "probe.h"
#include "spheretree/formats/file_io.h"

namespace {

std::string objText(const spheretree::TriangleMesh& mesh, const std::string& title) {
  std::string text = "# " + title + ", millimetres\n";
  char line[128];
  for (const Eigen::Vector3d& p : mesh.positions) {
    text.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof line, "v %.5f %.5f %.5f\n", p.x(), p.y(), p.z())));
  }
  for (const spheretree::Triangle& t : mesh.triangles) {
    text.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1)));
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("Usage: make_samples FOLDER\nWrites molar.obj and probe.obj, sample meshes in millimetres, into FOLDER.\n", stderr);
    return 2;
  }
  const std::filesystem::path folder(argv[1]);
  std::filesystem::create_directories(folder);
  spheretree::formats::writeWhole(folder / "molar.obj", objText(spheretree::samples::makeMolar(), "Lower first molar"));
  spheretree::formats::writeWhole(folder / "probe.obj", objText(spheretree::samples::makeProbe(), "Dental probe, tip at the origin"));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_samples: %s\n", error.what());
  return 3;
}
