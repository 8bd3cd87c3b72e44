// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/stl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::charsOf;
using test::has;
using test::volumeOf;

constexpr float kCorners[4][3][3] = {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                     {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                     {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                     {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

std::string binary(const std::string& header = "", std::uint32_t count = 4) {
  std::string bytes = header;
  bytes.resize(80);
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& facet : kCorners) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(facet), sizeof facet);
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string ascii() {
  std::string text = "solid tooth 11\n";
  for (const auto& facet : kCorners) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const auto& p : facet) text += "  vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid tooth 11\n";
}

MeshFile readStlText(std::string_view bytes) { return readStl(charsOf(bytes), "test.stl"); }

std::string stlRefusal(std::string_view bytes) {
  return test::refusalOf<FormatError>([&] { readStlText(bytes); });
}

void expectTetrahedron(const MeshFile& file) {
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.triangles.size(), 4u);
  EXPECT_DOUBLE_EQ(volumeOf(file.mesh), 1.0 / 6);
}

TEST(Stl, BothKindsGiveTheSameWeldedMesh) {
  const MeshFile a = readStlText(ascii()), b = readStlText(binary());
  expectTetrahedron(a);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.format, "STL (ASCII)");
  EXPECT_EQ(b.format, "STL (binary)");
  EXPECT_EQ(a.mesh.part_names, std::vector<std::string>{"tooth 11"});
}

TEST(Stl, TheSizeTellsBinaryFromAscii) {
  for (const char* header : {"solid", "solid tooth\nfacet normal 0 0 0\n outer loop\n", "\xef\xbb\xbfsolid x"}) {
    const MeshFile file = readStlText(binary(header));
    EXPECT_EQ(file.format, "STL (binary)") << header;
    expectTetrahedron(file);
  }
  EXPECT_EQ(readStlText("\xef\xbb\xbf" + ascii()).format, "STL (ASCII)");
}

TEST(Stl, AWrongCountGivesWayToTheSize) {
  for (const std::uint32_t count : {0u, 3u, 5u, 4294967280u}) {
    const MeshFile file = readStlText(binary("", count));
    expectTetrahedron(file);
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_TRUE(has(file.notes[0], std::to_string(count)) && has(file.notes[0], "all 4 were read")) << file.notes[0];
  }
}

TEST(Stl, TrailingBytesAreIgnoredWithANote) {
  const MeshFile file = readStlText(binary() + "trailer");
  expectTetrahedron(file);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_TRUE(has(file.notes[0], "7 bytes")) << file.notes[0];
}

/// The tetrahedron with unit normals, and `payload(facet)` after each facet; `announces_length`: in its attribute.
template <class Payload>
std::string withPayload(Payload&& payload, bool announces_length, std::uint32_t count = 4) {
  const float third = 1 / std::sqrt(3.0f);
  const float normals[4][3] = {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}, {third, third, third}};
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (std::size_t facet = 0; facet < 4; ++facet) {
    const std::string more = payload(facet);
    const auto length = static_cast<std::uint16_t>(announces_length ? more.size() : 0);
    bytes.append(reinterpret_cast<const char*>(normals[facet]), 12).append(reinterpret_cast<const char*>(kCorners[facet]), 36);
    bytes.append(reinterpret_cast<const char*>(&length), 2).append(more);
  }
  return bytes;
}

TEST(Stl, BytesAfterEachFacetAreWalkedOver) {
  for (std::size_t size = 0; size <= 120; ++size) {  // 50: as long as a facet
    const auto filled = [&](char first) {
      return [size, first](std::size_t facet) {
        std::string more(size, first);
        for (std::size_t i = 0; i < size && first; ++i) more[i] = static_cast<char>(first + 31 * facet + 7 * i);
        return more;
      };
    };
    for (const char first : {'\0', 'a'}) {
      expectTetrahedron(readStlText(withPayload(filled(first), true)));
      expectTetrahedron(readStlText(withPayload(filled(first), false)));
    }
  }
  const MeshFile file = readStlText(withPayload([](std::size_t facet) { return std::string(7 * facet, 'x'); }, true));
  expectTetrahedron(file);
  EXPECT_EQ(file.notes, std::vector<std::string>{"The attributes after each facet, 42 bytes in all, were left out."});
}

TEST(Stl, BytesAfterTheLastFacetAreNoFacets) {
  for (const std::size_t size : {1u, 50u, 100u, 350u, 1000u})
    for (const char filling : {'\0', 'x', '\xff'}) {
      const MeshFile file = readStlText(binary() + std::string(size, filling));
      expectTetrahedron(file);
      EXPECT_EQ(file.notes.size(), 1u);
    }
}

TEST(Stl, AnArrangementThatNothingExplainsIsRefused) {
  // Of various lengths after each facet, which the file does not tell.
  const std::string bytes = withPayload([](std::size_t facet) { return std::string(13 * facet + 5, 'x'); }, false);
  EXPECT_TRUE(has(stlRefusal(bytes), "4 facets") && has(stlRefusal(bytes), "plain binary STL")) << stlRefusal(bytes);
}

TEST(Stl, OldTextWritersAreRead) {
  const MeshFile expected = readStlText(ascii());
  const auto everywhere = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
    return text;
  };
  const std::string two_words =
      everywhere(everywhere(everywhere(ascii(), "endloop", "end loop"), "endfacet", "End Facet"), "endsolid", "END SOLID");
  const std::string one_line = everywhere(ascii(), "\n", " ");
  for (const std::string& text : {two_words, one_line, everywhere(ascii(), "normal 0 0 0\n", "normal nan nan nan ")}) {
    const MeshFile file = readStlText(text);
    expectTetrahedron(file);
    EXPECT_EQ(file.mesh.part_names, expected.mesh.part_names) << text;
    EXPECT_TRUE(file.notes.empty()) << file.notes[0];
  }
}

TEST(Stl, EveryCutWithinAFacetIsRefused) {
  const std::string whole = binary();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<char> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));  // own buffer: ASan sees an over-read
    const auto readCut = [&] { return readStl(cut, "test.stl"); };
    if (size >= 84 && (size - 84) % 50 == 0 && size > 84)
      EXPECT_FALSE(readCut().notes.empty()) << size;
    else
      EXPECT_THROW(readCut(), FormatError) << size;
  }
}

TEST(Stl, EveryCutOfAnAsciiFileIsRefusedOrNoted) {
  const std::string whole = ascii();
  for (std::size_t size = 0; size + 18 < whole.size(); ++size) {  // from there on only the endsolid line is missing
    const std::string cut = whole.substr(0, size);
    MeshFile file;
    try {
      file = readStlText(cut);
    } catch (const FormatError& error) {
      EXPECT_TRUE(has(error.what(), "test.stl")) << error.what();
      continue;
    }
    EXPECT_TRUE(!file.notes.empty() && has(file.notes[0], "no endsolid")) << size;
  }
}

TEST(Stl, RefusalsNameTheFacetAndTheValue) {
  std::string bytes = binary();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 2 * 50 + 12 + 12 + 4, &nan, 4);
  EXPECT_TRUE(has(stlRefusal(bytes), "facet 3, corner 2")) << stlRefusal(bytes);
  EXPECT_TRUE(has(stlRefusal("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid\n"), "line 5: facet 1 has 2 vertices"));
  EXPECT_TRUE(has(stlRefusal("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendfacet\nendsolid\n"), "line 6"));
  EXPECT_TRUE(has(stlRefusal("solid\nfacet\nvertex 0 zero 0\n"), "\"zero\""));
  EXPECT_TRUE(has(stlRefusal("solid\nfacet\nvertex 0 0 inf\nvertex 1 0 0\nvertex 1 1 0\nendfacet\nendsolid\n"), "line 3: vertex 0"));
  EXPECT_TRUE(has(stlRefusal("solid\nendsolid\n"), "no triangle"));
  EXPECT_TRUE(has(stlRefusal("neither"), "7 bytes"));
  EXPECT_TRUE(has(stlRefusal(""), "empty"));
}

TEST(Stl, SolidsAreParts) {
  const std::string facet = "facet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n";
  const MeshFile file = readStlText(
      "solid\n" + facet +
      "endsolid\nSOLID B\nFACET NORMAL nan nan nan\nOuter Loop\nVERTEX 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nENDFACET\nEndSolid B\n");
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"", "B"}));
  EXPECT_EQ(file.mesh.part, (std::vector<std::uint32_t>{0, 1}));
}

}  // namespace
}  // namespace spheretree::formats
