// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/sample_gltf.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::areaOf;
using test::has;
using test::kMeshes;
using test::volumeOf;

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const std::string kOff = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::filesystem::path write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

TEST(MeshFile, ReadsByContentWhereTheExtensionIsWrong) {
  const test::ScratchFolder scratch;
  const std::string glb = test::toGlb(test::tetrahedronJson(), test::tetrahedronBuffer());
  struct Case {
    const char *name, *format;
    std::string bytes;
  };
  const Case cases[] = {
      {"a.obj", "OBJ", kObj}, {"b.OBJ", "OBJ", kObj},          {"c.stl", "OBJ", kObj}, {"d.xyz", "OBJ", "# by hand\no x\n" + kObj},
      {"e.ply", "OFF", kOff}, {"f.off", "OFF", kOff},          {"g", "OFF", kOff},     {"h.obj", "GLB", glb},
      {"i.gltf", "GLB", glb}, {"j.off", "OFF", kOff.substr(4)}};
  for (const Case& c : cases) {
    const MeshFile file = readMesh(write(scratch.path() / c.name, c.bytes));
    EXPECT_EQ(file.format, c.format) << c.name;
    EXPECT_EQ(file.mesh.triangles.size(), 4u) << c.name;
  }
  EXPECT_TRUE(has(readMesh(scratch.path() / "c.stl").notes.back(), "holds OBJ"));
  EXPECT_TRUE(readMesh(scratch.path() / "a.obj").notes.empty());
  // glTF is in metres unless the caller gives another unit.
  const double in_metres = readMesh(scratch.path() / "i.gltf", 10).mesh.positions[1].norm();
  EXPECT_EQ(readMesh(scratch.path() / "i.gltf", 10).unit_mm, 1000);
  EXPECT_DOUBLE_EQ(readMesh(scratch.path() / "i.gltf", 1, 10).mesh.positions[1].norm() * 100, in_metres);
  EXPECT_EQ(readMesh(scratch.path() / "i.gltf", 1, 10).unit_mm, 10);
}

TEST(MeshFile, TellsTheFaceOfEachTriangle) {
  const test::ScratchFolder scratch;
  // A pentagon that is cut, a face that waits for its vertex, a face of two corners.
  const std::string text = "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\nf 1 2 6\nf 1 2\nf 1 3 2\nv 0 0 1\n";
  const MeshFile file = readMesh(write(scratch.path() / "a.obj", text));
  EXPECT_EQ(file.faces, 4u);
  EXPECT_EQ(file.face_of_triangle, (std::vector<std::uint32_t>{0, 0, 0, 3, 1}));
}

TEST(MeshFile, TellsTheFrameThatTheHeaderStates) {
  const test::ScratchFolder scratch;
  EXPECT_EQ(readMesh(write(scratch.path() / "a.obj", kObj)).space, "");
  for (const char* space : {"LPS", "RAS"})
    EXPECT_EQ(readMesh(write(scratch.path() / "a.obj", std::string("# 3D Slicer output. SPACE=") + space + "\n" + kObj)).space, space);
}

TEST(MeshFile, NamesOfPartsThatAreNotUtf8AreLatin1) {
  const test::ScratchFolder scratch;
  const MeshFile file = readMesh(write(scratch.path() / "a.obj",
                                       "g M\xfc"
                                       "ller\n" +
                                           kObj + "g \xe4\xb8\x8a\nf 1 2 3\n"));
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"M\xc3\xbc"
                                                            "ller",
                                                            "\xe4\xb8\x8a"}));
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST(MeshFile, ErrorsTellFilesFromContents) {
  const test::ScratchFolder scratch;
  EXPECT_THROW(readMesh(scratch.path() / "missing.obj"), FileError);
  EXPECT_THROW(readMesh(scratch.path()), FileError);
  EXPECT_THROW(readMesh(write(scratch.path() / "empty.stl", "")), FormatError);
  EXPECT_THROW(readMesh(write(scratch.path() / "a.obj", kObj), -1), std::invalid_argument);
  const std::string refusal = test::refusalOf<FormatError>([&] { readMesh(write(scratch.path() / "notes.txt", "Dear reader,\n")); });
  EXPECT_TRUE(has(refusal, "notes.txt") && has(refusal, ".ply")) << refusal;
}

TEST(MeshFile, SelectPartKeepsTheTrianglesOfOnePart) {
  const test::ScratchFolder scratch;
  const std::string text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng a\nf 1 2 3\ng b\nf 2 4 3\nf 2 3 5\n";
  const TriangleMesh mesh = readMesh(write(scratch.path() / "a.obj", text)).mesh;
  const TriangleMesh part = selectPart(mesh, "b");
  EXPECT_EQ(part.positions.size(), 4u);
  EXPECT_EQ(part.positions[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(part.triangles, (std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}}));
  EXPECT_EQ(part.part_names, std::vector<std::string>{"b"});
  EXPECT_EQ(part.part, (std::vector<std::uint32_t>{0, 0}));
  const std::string refusal = test::refusalOf<FormatError>([&] { selectPart(mesh, "c"); });
  EXPECT_TRUE(has(refusal, "\"c\"") && has(refusal, "\"a\", \"b\"")) << refusal;
  EXPECT_THROW(selectPart(TriangleMesh{}, ""), FormatError);
}

long genusOf(const TriangleMesh& mesh) {  // of one closed manifold component
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
  return 1 - (static_cast<long>(mesh.positions.size()) - static_cast<long>(edges.size()) + static_cast<long>(mesh.triangles.size())) / 2;
}

TEST(MeshFile, BenchMeshesHaveTheirKnownVolumeAreaAndGenus) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  struct Case {
    const char* name;
    std::size_t triangles;
    double volume, area;  // in the unit of the file
    long genus;
  };
  const Case cases[] = {{"organic_spot.obj", 5856, 0.718258788, 5.70951879, 0},
                        {"organic_human_body.ply", 26756, 54.8953381, 161.378754, 0},
                        {"organic_hyoid_bone.obj", 6934, 2185.93711, 1785.5723, 0},
                        {"cad_fandisk.obj", 12946, 20.2433749, 60.6691092, 0},
                        {"cad_metacarpal_link.obj", 1488, 19978.5341, 6031.99096, 0},
                        {"cad_thin_plate.obj", 1952, 106232.952, 31538.5721, 0},
                        {"thin_tray_with_holes.stl", 4520, 347865.896, 224414.725, 23},
                        {"thin_mug.obj", 24544, 133.298422, 496.112223, 1},
                        {"genus_menger_sponge3.glb", 21598, 0.406442101, 24.7572017, 1409},
                        {"genus_torus.stl", 8700, 4.91754732, 19.7155093, 1},
                        {"scale_scallop_120k.glb", 120000, 41.2848103, 78.0987075, 0},
                        {"elongated_bottle.ply", 1000, 0.000606688762, 0.0447222602, 0},
                        {"elongated_cylinder.stl", 416, 25.0923875, 56.518395, 0}};
  for (const Case& c : cases) {
    const MeshFile file = readMesh(kMeshes / "bench" / c.name);
    const double unit = file.unit_mm;
    EXPECT_EQ(file.mesh.triangles.size(), c.triangles) << c.name;
    EXPECT_NEAR(volumeOf(file.mesh), c.volume * unit * unit * unit, 1e-6 * c.volume * unit * unit * unit) << c.name;
    EXPECT_NEAR(areaOf(file.mesh), c.area * unit * unit, 1e-6 * c.area * unit * unit) << c.name;
    EXPECT_EQ(genusOf(file.mesh), c.genus) << c.name;
  }
}

TEST(MeshFile, DamagedTeethHaveTheirKnownVolume) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  constexpr double kTooth = 1169.20992;  // [mm^3]; the glTF files hold it in metres
  const std::map<std::string, double> volumes = {{"tooth_clean.obj", 1},
                                                 {"tooth_all_flipped.obj", -1},
                                                 {"tooth_negative_indices_crlf.obj", 1},
                                                 {"tooth_quads_mixed.obj", 1},
                                                 {"tooth_big_endian_double.ply", 1},
                                                 {"tooth_binary_starts_with_solid.stl", 1},
                                                 {"tooth_absurd_count.stl", 1},
                                                 {"tooth_far_from_origin_text.obj", 1},
                                                 {"tooth_huge_1e9.obj", 1e27},
                                                 {"tooth_tiny_1e-6.obj", 1e-18},
                                                 {"tooth_squashed_flat.obj", 1e-4},
                                                 {"tooth_degenerate_faces.obj", 1},
                                                 {"tooth_t_junctions.obj", 1},
                                                 {"teeth_overlapping.stl", 2},
                                                 {"teeth_bowtie_vertex.obj", 2},
                                                 {"tooth_plain.glb", 1},
                                                 {"tooth_negative_scale.glb", 1},
                                                 {"tooth_nested_transforms.glb", 8},
                                                 {"tooth_no_indices.glb", 1},
                                                 {"tooth_quantised_int16.glb", 1},
                                                 {"tooth_sparse.gltf", 1},
                                                 {"tooth_two_scenes.glb", 1.125},
                                                 {"tooth_sparse_no_bufferview.gltf", 1},
                                                 {"tooth_interleaved.gltf", 1},
                                                 {"tooth_unreferenced_node.glb", 1},
                                                 {"tooth_with_points_and_lines.glb", 1},
                                                 {"tooth_no_scene.glb", 2},  // two root nodes
                                                 {"hostile_deep_nodes.glb", 1}};
  for (const auto& [name, factor] : volumes) {
    const TriangleMesh mesh = readMesh(kMeshes / "failure" / "tooth" / name).mesh;
    // 16-bit coordinates round the vertices of the tooth.
    const double tolerance = name == "tooth_quantised_int16.glb" ? 1e-5 : 1e-6;
    EXPECT_NEAR(volumeOf(mesh) / (kTooth * factor), 1, tolerance) << name;
    if (std::abs(factor) == 1 && name != "tooth_degenerate_faces.obj" && name != "tooth_t_junctions.obj") {
      EXPECT_EQ(mesh.positions.size(), 1538u) << name;
    }
  }
  const double cavity = volumeOf(readMesh(kMeshes / "failure/tooth/tooth_cavity.obj").mesh),
               shell = volumeOf(readMesh(kMeshes / "failure/tooth/tooth_inner_shell_same_winding.obj").mesh);
  EXPECT_NEAR((cavity + shell) / 2, kTooth, 1e-6 * kTooth);
  EXPECT_LT(cavity, kTooth - 20);
}

/// Words that the message must contain; empty: the file is read.
struct Outcome {
  const char* name;
  std::vector<const char*> words;
  std::size_t triangles = 0;
};

const std::vector<Outcome> kOutcomes = {
    {"tooth/hostile_accessor_count.glb", {"accessors[0]", "2147483648"}},
    {"tooth/hostile_index_out_of_range.glb", {"names vertex", "1538"}},
    {"tooth/hostile_node_cycle.glb", {"nodes[0]", "cycles"}},
    {"tooth/hostile_offset_overflow.glb", {"bufferViews[1]", "4294967280"}},
    {"tooth/hostile_path_escape.gltf", {"outside_the_folder.bin", "within the folder"}},
    {"tooth/hostile_truncated.glb", {"27986", "cut off"}},
    {"tooth/hostile_unknown_required_extension.glb", {"VENDOR_unknown_geometry"}},
    {"tooth/tooth_draco.glb", {}, 3072},
    {"tooth/tooth_meshopt.glb", {}, 3072},
    {"tooth/tooth_index_out_of_range.obj", {"line 3075", "face 1537", "2038"}},
    {"tooth/tooth_index_zero.obj", {"line 3075", "vertex 0"}},
    {"tooth/tooth_nan_inf.obj", {"line 18", "nan"}},
    {"tooth/tooth_truncated.stl", {"facet 1843 of 3072", "cut off"}},
    {"obj/box_UTF16BE.obj", {"UTF-16"}},
    {"obj/malformed.obj", {"line 28", "vertex 0"}},
    {"obj/number_formats.obj", {"line 11", "3.1+e2"}},
    {"obj/obj_points.obj", {"no triangle"}},
    {"obj/obj_wireframe.obj", {"no triangle"}},
    {"obj/point_cloud.obj", {"no triangle"}},
    {"obj/concave_polygon.obj", {}, 64},
    {"obj/notenoughindices.obj", {}, 1},
    {"obj/polygonfaces.obj", {}, 3},
    {"obj/box_longline.obj", {}, 944},
    {"off/OutOfMemory.off", {"353535235358"}},
    {"off/invalid.off", {"line 7", "\"20\""}},
    {"off/comments.off", {}, 12},
    {"off/whitespace.off", {}, 12},
    {"ply/empty.ply", {"empty"}},
    {"ply/issue623.ply", {"no element \"face\""}},
    {"ply/ply_empty_bin.ply", {"no triangle"}},
    {"ply/ply_empty_header.ply", {"no element \"vertex\""}},
    {"ply/points_emptyface.ply", {"no triangle"}},
    {"mesh/fuze_ascii.ply", {}, 1000},
    {"stl/empty.stl", {"empty"}},
    {"stl/faceless.ascii.stl", {"no triangle"}},
    {"stl/fourVertices.ascii.stl", {"facet 1", "more than three"}},
    {"stl/quad.ascii.stl", {"facet 1", "more than three"}},
    {"stl/twoVertices.ascii.stl", {"facet 1", "2 vertices"}},
    {"stl/incorrectFaceCounter.bin.stl", {}, 4},
    {"stl/tetrahedronMinusZero.bin.stl", {}, 4},
    {"stl/wrongHeader.bin.stl", {}, 12},
    {"stl/triangle_with_empty_solid.stl", {}, 1},
    {"gltf/AllIndicesOutOfRange.gltf", {"names vertex 65535"}},
    {"gltf/Mesh_PrimitiveMode_00.gltf", {"no triangle"}},
    {"gltf/Mesh_PrimitiveMode_02.gltf", {"no triangle"}},
    {"gltf/Mesh_PrimitiveMode_04.gltf", {}, 2},
    {"gltf/Mesh_PrimitiveMode_05.gltf", {}, 2},
    {"gltf/Mesh_PrimitiveMode_06.gltf", {}, 2},
    {"gltf/Mesh_PrimitiveMode_11.gltf", {}, 2},
    {"gltf/Mesh_PrimitiveMode_13.gltf", {}, 2},
    {"gltf/RecursiveNodes.gltf", {"nodes[0]", "cycles"}},
    {"gltf/SceneWithoutNodes.gltf", {"no node of its scene"}},
    {"gltf/badArray.gltf", {"meshes[0]", "primitives"}},
    {"gltf/empty_nodes.glb", {"no node of its scene"}},
    {"gltf/sceneWrongType.gltf", {"scene", "whole number"}},
    {"gltf/missing_bin/BoxTextured.gltf", {"BoxTextured0.bin", "cannot be read"}},
    {"gltf/khronos/json__invalid_syntax.gltf", {"is not JSON"}},
    {"gltf/khronos/node__infinite_transform.gltf", {"1e309"}},
    {"gltf/khronos/node__rotation_non_unit.gltf", {"unit quaternion"}},
    {"gltf/khronos/glb__only_header.glb", {"12 bytes"}},
};

TEST(MeshFile, EveryFailureFileEndsInAMeshOrANamedRefusal) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  std::size_t read_count = 0, refused = 0;
  std::map<std::string, std::string> refusals;
  std::map<std::string, std::size_t> triangles;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kMeshes / "failure")) {
    if (!entry.is_regular_file() || entry.path().extension() == ".bin") continue;
    const std::string name = std::filesystem::relative(entry.path(), kMeshes / "failure").generic_string();
    try {
      const MeshFile file = readMesh(entry.path());
      ++read_count;
      triangles[name] = file.mesh.triangles.size();
      EXPECT_FALSE(file.mesh.triangles.empty()) << name;
      for (const Eigen::Vector3d& p : file.mesh.positions) EXPECT_TRUE(p.allFinite()) << name;
      for (const Triangle& t : file.mesh.triangles) EXPECT_LT(*std::max_element(t.begin(), t.end()), file.mesh.positions.size()) << name;
    } catch (const FormatError& error) {
      ++refused;
      refusals[name] = error.what();
      EXPECT_TRUE(has(error.what(), entry.path().filename().string())) << error.what();
    } catch (const FileError& error) {
      ++refused;
      refusals[name] = error.what();
    }
  }
  EXPECT_GT(read_count, 80u);
  EXPECT_GT(refused, 60u);
  for (const Outcome& outcome : kOutcomes) {
    if (outcome.words.empty()) {
      EXPECT_EQ(triangles[outcome.name], outcome.triangles) << outcome.name << ": " << refusals[outcome.name];
      continue;
    }
    EXPECT_TRUE(refusals.contains(outcome.name)) << outcome.name;
    for (const char* word : outcome.words) EXPECT_TRUE(has(refusals[outcome.name], word)) << refusals[outcome.name];
  }
}

}  // namespace
}  // namespace spheretree::formats
