// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/scan_labels.h"

#include <gtest/gtest.h>

#include <array>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/obj.h"
#include "spheretree/formats/ply.h"
#include "support/random.h"

namespace spheretree::formats {
namespace {

constexpr const char* kLabels =
    R"({"id_patient": "01A", "jaw": "lower", "labels": [0, 44, 44, 75], "instances": [0, 1, 1, 2], "more": {}})";

std::string refusalOf(const std::string& text) {
  try {
    (void)parseScanLabels(text, "l.json");
  } catch (const FormatError& error) {
    return error.what();
  }
  return "";
}

TEST(ScanLabels, ReadsTheFormOfTeeth3DS) {
  const ScanLabels read = parseScanLabels(kLabels, "l.json");
  EXPECT_EQ(read.patient, "01A");
  EXPECT_EQ(read.jaw, "lower");
  EXPECT_EQ(read.labels, (std::vector<std::int32_t>{0, 44, 44, 75}));
  EXPECT_EQ(parseScanLabels(R"({"labels": [11]})", "l").jaw, "");
}

TEST(ScanLabels, TakesWhatProgramsWrite) {
  const ScanLabels read = parseScanLabels(R"({"jaw": "Lower", "labels": [0.0, 44.0, 4.4e1], "instances": [-1]})", "l.json");
  EXPECT_EQ(read.labels, (std::vector<std::int32_t>{0, 44, 44}));
  EXPECT_EQ(read.jaw, "lower");
  for (const auto& [word, jaw] : {std::pair{"UPPER", "upper"}, {"Maxilla", "upper"}, {" mandible ", "lower"}, {"L", "lower"}})
    EXPECT_EQ(parseScanLabels(R"({"labels": [11], "jaw": ")" + std::string(word) + "\"}", "l").jaw, jaw);
}

TEST(ScanLabels, RefusesEachMutationWithItsPlace) {
  const std::vector<std::array<std::string, 2>> cases{{R"({"labels": [0, -1]})", "labels[1]"},
                                                      {R"({"labels": [0, 1.5]})", "labels[1]"},
                                                      {R"({"labels": [0, 1000000000]})", "labels[1]"},
                                                      {R"({"labels": [0, "11"]})", "labels[1]"},
                                                      {R"({"labels": [0, null]})", "labels[1]"},
                                                      {R"({"labels": [0, [1]]})", "labels[1]"},
                                                      {R"({"labels": [0, NaN]})", "l.json"},
                                                      {R"({"labels": [0, 1e400]})", "l.json"},
                                                      {R"({"labels": []})", "labels is empty"},
                                                      {R"({"labels": 3})", "labels is not an array"},
                                                      {R"({"label": [1]})", "has no \"labels\""},
                                                      {R"([1, 2])", "is not an object"},
                                                      {R"({"labels": [0], "jaw": "left"})", "jaw is \"left\""},
                                                      {R"({"labels": [0], "jaw": 3})", "jaw is not a text"},
                                                      {R"({"labels": [0], "labels": [1]})", "labels"}};
  for (const auto& [text, place] : cases) EXPECT_NE(refusalOf(text).find(place), std::string::npos) << text << ": " << refusalOf(text);
}

TEST(ScanLabels, ReadsOrRefusesAnyDamage) {
  test::Random random(7);
  std::size_t refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string text = kLabels;
    const auto at = static_cast<std::size_t>(random.between(0, static_cast<double>(text.size()) - 0.01));
    if (i % 3 == 0)
      text.resize(at);
    else
      text[at] = static_cast<char>(random.between(1, 255));
    refused += !refusalOf(text).empty();  // and no other exception
  }
  EXPECT_GT(refused, 150u);
}

TEST(MeshFile, TellsWhereEachVertexOfTheFileWent) {
  const std::string text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 0 0 1\nf 2 3 4\nf 5 3 6\n";
  const MeshFile file = readObj(text, "a.obj", 1);
  EXPECT_EQ(file.vertex_of_file, (std::vector<std::uint32_t>{kNone, 0, 1, 2, 0, 3}));
}

TEST(PlyColumn, ReadsScalarsOfVerticesAndFacesAndColours) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty int label\nproperty float y\nproperty float z\n"
      "element face 1\nproperty uchar red\nproperty list uchar int vertex_indices\nproperty uchar green\nproperty uchar blue\n"
      "property short class\nend_header\n0 11 0 0\n1 12 0 0\n0 0 1 0\n1 3 0 1 2 2 3 7\n";
  EXPECT_EQ(readPlyColumns(text, "a", "label").at(0).values, (std::vector<double>{11, 12, 0}));
  EXPECT_FALSE(readPlyColumns(text, "a", "label").at(0).is_of_faces);
  EXPECT_EQ(readPlyColumns(text, "a", "class").at(0).values, (std::vector<double>{7}));
  EXPECT_EQ(readPlyColumns(text, "a", "colour").at(0).values, (std::vector<double>{65536 + 2 * 256 + 3}));
  EXPECT_TRUE(readPlyColumns(text, "a", "color").at(0).is_of_faces);
  try {
    (void)readPlyColumns(text, "a", "vertex_indices");
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_NE(std::string(error.what()).find("it has x, label, y, z, red, green, blue, class"), std::string::npos) << error.what();
  }
  EXPECT_THROW(readPlyColumns(text.substr(0, text.size() - 20), "a", "class"), FormatError);
}

}  // namespace
}  // namespace spheretree::formats
