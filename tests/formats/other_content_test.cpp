// SPDX-License-Identifier: Apache-2.0
#include "text/other_content.h"

#include <gtest/gtest.h>

#include <fstream>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using namespace std::string_literals;

TEST(OtherContent, IsNamedForWhatItIsWithANextStep) {
  struct Case {
    std::string bytes, what, next;
  };
  const Case cases[] = {
      {"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 482684\n", "a pointer of Git LFS", "git lfs pull"},
      {"\n<!DOCTYPE html>\n<html><body>v 0 0 0</body></html>", "a web page (HTML)", "Download raw file"},
      {"<HTML>\n", "a web page (HTML)", "Download"},
      {"\x1f\x8b\x08\0\0"s, "compressed by gzip", "gunzip < F > mesh"},
      {"PK\x03\x04 tooth.stl", "a zip archive", "unzip F"},
      {"PK\x03\x04 3D/3dmodel.model", "a 3MF file", "spheretree-import F"},
      {"# vtk DataFile Version 3.0\n", "a VTK file", "ParaView"},
      {"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">", "a VTK file", "ParaView"},
      {std::string(128, '\0') + "DICM", "a DICOM file", "Segment it"},
      {"ISO-10303-21;\nHEADER;\n", "a STEP file", "gmsh -2 F"},
      {std::string(72, ' ') + "S      1\n", "an IGES file", "gmsh"},
      {"<?xml version=\"1.0\"?><COLLADA xmlns=\"\">", "a Collada file (DAE)", "spheretree-import F"},
      {"<?xml version=\"1.0\"?><Error><Code>AccessDenied</Code></Error>", "an XML file", ".stl"},
      {"Kaydara FBX Binary  \0"s, "an FBX file", "spheretree-import"},
      {"<HPS version=\"1.1\">", "a scan of 3Shape (DCM)", "STL or PLY"},
      {"\0\x05\x16\x07 Mac OS X"s, "a companion file of macOS", "._"},
      {"\x89PNG\r\n", "a picture (PNG)", "mesh"}};
  const test::ScratchFolder scratch;
  for (const Case& c : cases) {
    const std::optional<OtherContent> found = otherContentOf(test::charsOf(c.bytes), "F");
    ASSERT_TRUE(found) << c.what;
    EXPECT_TRUE(test::has(found->what, c.what)) << found->what;
    EXPECT_TRUE(test::has(found->next, c.next)) << found->next;
    // Whatever the file is called.
    for (const char* name : {"a.stl", "a.obj", "a.ply", "a.gltf", "a"}) {
      std::ofstream(scratch.path() / name, std::ios::binary) << c.bytes;
      const std::string refusal = test::refusalOf<FormatError>([&] { readMesh(scratch.path() / name); });
      EXPECT_TRUE(test::has(refusal, std::string(name) + ": is " + c.what)) << name << ": " << refusal;
    }
  }
}

TEST(OtherContent, SaysNothingOfMeshes) {
  for (const std::string& bytes :
       {""s, "solid x\nfacet"s, "v 0 0 0\n"s, "ply\n"s, "OFF\n"s, "glTF"s, "{\"asset\": 1}"s, std::string(600, '\0')})
    EXPECT_FALSE(otherContentOf(test::charsOf(bytes), "F")) << bytes;
}

}  // namespace
}  // namespace spheretree::formats
