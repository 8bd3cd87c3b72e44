// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_uris.h"

#include <gtest/gtest.h>

#include <fstream>

#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::has;

std::string open(const std::string& uri, const std::filesystem::path& folder) {
  const MeshAssembly assembly("test.gltf", 1000);
  const std::vector<unsigned char> bytes = GltfUris(folder, assembly).open(uri, "buffers[3]");
  return {bytes.begin(), bytes.end()};
}

std::string uriRefusal(const std::string& uri, const std::filesystem::path& folder = {}) {
  return test::refusalOf<FormatError>([&] { open(uri, folder); });
}

TEST(GltfUris, Base64IsThatOfRfc4648) {
  for (const auto& [text, bytes] :
       {std::pair<std::string, std::string>{"Zg==", "f"}, {"Zm8=", "fo"}, {"Zm9v", "foo"}, {"Zm9vYmFy", "foobar"}, {"+/8=", "\xfb\xff"}})
    EXPECT_EQ(open("data:application/octet-stream;base64," + text, {}), bytes) << text;
  EXPECT_TRUE(has(uriRefusal("data:;base64,Z*=="), "buffers[3].uri has \"*\" in its base64 data")) << uriRefusal("data:;base64,Z*==");
  EXPECT_TRUE(has(uriRefusal("data:text/plain,abc"), "not of base64"));
}

TEST(GltfUris, FilesLieInTheFolderOrBelow) {
  const test::ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path() / "model";
  std::filesystem::create_directories(folder / "data");
  std::ofstream(folder / "data" / "a b.bin", std::ios::binary) << "within";
  std::ofstream(scratch.path() / "outside.bin", std::ios::binary) << "outside";
  std::error_code no_links;  // libstdc++ makes none on Windows
  std::filesystem::create_symlink(scratch.path() / "outside.bin", folder / "link.bin", no_links);
  std::filesystem::create_symlink(folder / "data", folder / "inner", no_links);
  for (const char* uri : {"data/a%20b.bin", "./data/a b.bin", "data\\a%20b.bin", ".\\data\\a b.bin"})
    EXPECT_EQ(open(uri, folder), "within") << uri;
  EXPECT_TRUE(has(uriRefusal("../outside.bin", folder), "within the folder"));
  EXPECT_TRUE(has(uriRefusal("..\\outside.bin", folder), "within the folder"));
  EXPECT_TRUE(has(uriRefusal("data/../../outside.bin", folder), "within the folder"));
  EXPECT_TRUE(has(uriRefusal("%2e%2e/outside.bin", folder), "within the folder"));
  EXPECT_TRUE(has(uriRefusal((scratch.path() / "outside.bin").string(), folder), "within the folder"));
  if (!no_links) {
    EXPECT_EQ(open("inner/a b.bin", folder), "within");
    EXPECT_TRUE(has(uriRefusal("link.bin", folder), "through a link"));
  }
  EXPECT_TRUE(has(uriRefusal("https://example.com/a.bin", folder), "on this machine"));
  EXPECT_TRUE(has(uriRefusal("data", folder), "plain file"));
  EXPECT_TRUE(has(uriRefusal(std::string("a\0b", 3), folder), "zero character"));
  EXPECT_THROW(open("missing.bin", folder), FileError);
  EXPECT_TRUE(has(uriRefusal("data/a b.bin"), "which is not read here")) << "no folder, no files";
}

}  // namespace
}  // namespace spheretree::formats
