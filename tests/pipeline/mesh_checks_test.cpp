// SPDX-License-Identifier: GPL-3.0-or-later
// The readers and the checks together, on every shared mesh whose defects are known.
#include "spheretree/builder/mesh_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "support/mesh_measures.h"

namespace spheretree {
namespace {

using builder::checkMesh;
using builder::DefectKind;
using builder::MeshReport;
using test::kMeshes;

using Counts = std::map<DefectKind, std::size_t>;

Counts countsOf(const MeshReport& report) {
  Counts counts;
  for (const builder::Defect& d : report.defects) counts[d.kind] = d.count;
  return counts;
}

TEST(MeshChecksOnFiles, SoundMeshesAreClean) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  std::size_t checked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kMeshes / "bench")) {
    const MeshReport report = checkMesh(formats::readMesh(entry.path()).mesh);
    EXPECT_TRUE(report.clean()) << entry.path() << "\n" << report.summary();
    EXPECT_TRUE(report.not_checked.empty());
    ++checked;
  }
  EXPECT_EQ(checked, 13u);
  for (const char* name :
       {"dental/molar_with_pulp.obj", "dental/handpiece_with_bur.obj", "dental/mandible_with_teeth.ply", "dental/tongue_scan.ply",
        "dental/soft_palate.obj", "dental/tongue_coarse.glb", "dental/tooth_FDI36_molar.stl", "failure/mesh/7_8ths_cube.stl",
        "failure/mesh/hull-body.obj", "failure/mesh/Havocglass8_right.obj", "failure/stl/wrongHeader.bin.stl"}) {
    const MeshReport report = checkMesh(formats::readMesh(kMeshes / name).mesh);
    EXPECT_TRUE(report.clean()) << name << "\n" << report.summary();
  }
}

TEST(MeshChecksOnFiles, KnownDefectsAreCounted) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  using enum DefectKind;
  const std::map<std::string, Counts> known = {
      {"failure/tooth/tooth_clean.obj", {}},
      {"failure/tooth/tooth_far_from_origin.stl", {}},
      {"failure/tooth/tooth_far_from_origin_text.obj", {}},
      {"failure/tooth/tooth_huge_1e9.obj", {}},
      {"failure/tooth/tooth_tiny_1e-6.obj", {}},
      {"failure/tooth/tooth_squashed_flat.obj", {}},
      {"failure/tooth/tooth_thin_shell_0.02mm.obj", {}},
      {"failure/tooth/tooth_cavity.obj", {}},
      {"failure/tooth/tooth_inner_shell_same_winding.obj", {}},
      {"failure/tooth/tooth_all_flipped.obj", {{InsideOut, 1}}},
      {"failure/tooth/tooth_half_flipped.stl", {{ClashingWinding, 2291}}},
      {"failure/tooth/teeth_bowtie_vertex.obj", {{NonManifoldVertex, 1}}},
      {"failure/tooth/teeth_overlapping.stl", {{SelfIntersection, 366}}},
      {"failure/tooth/tooth_cracks_1e-5.stl", {{Border, 9216}, {SelfIntersection, 1492}}},
      {"failure/tooth/tooth_nonmanifold_fins.obj", {{NonManifoldEdge, 30}, {Border, 60}}},
      {"failure/tooth/tooth_one_hole.obj", {{Border, 34}}},
      {"failure/tooth/tooth_open_crown_scan.stl", {{Border, 57}}},
      {"failure/tooth/tooth_scattered_holes.stl", {{NonManifoldVertex, 15}, {Border, 235}}},
      {"failure/tooth/tooth_duplicated_faces.obj", {{DuplicateFace, 1075}, {NonManifoldEdge, 2520}}},
      {"failure/tooth/tooth_zero_thickness.obj", {{DuplicateFace, 2101}, {NonManifoldEdge, 3123}}},
      {"failure/mesh/capsule.obj", {{DegenerateFace, 200}}},
      {"failure/mesh/soup.stl", {{Border, 300}, {SelfIntersection, 1248}}},
      {"failure/mesh/multibody.stl", {{ClashingWinding, 12}}},
      {"failure/mesh/featuretype.STL", {{Border, 576}, {SelfIntersection, 1216}}},
      {"failure/mesh/self_intersectA.obj", {{SelfIntersection, 338}}},
      {"failure/mesh/boxNotManifold.obj", {{Border, 4}}},
      {"failure/mesh/moebius.obj", {{ClashingWinding, 4}, {Border, 112}}},
      {"failure/mesh/hourglass_ico.obj", {{NonManifoldVertex, 1}}},
      {"failure/mesh/fan3.obj", {{NonManifoldEdge, 1}, {Border, 6}}},
      {"dental/upper_arch_with_gum.obj", {{SelfIntersection, 2036}}},
      {"dental/full_dentition_32.obj", {{SelfIntersection, 342}}},
      {"dental/upper_cast.obj", {{Border, 164}, {SelfIntersection, 64}}},
      {"dental/head_neck_open.ply", {{Border, 54}, {SelfIntersection, 128}}},
      {"dental/gums_and_tongue_open.obj", {{Border, 146}}},
  };
  for (const auto& [name, counts] : known) {
    const MeshReport report = checkMesh(formats::readMesh(kMeshes / name).mesh);
    EXPECT_EQ(countsOf(report), counts) << name << "\n" << report.summary();
  }
}

TEST(MeshChecksOnFiles, PartsWithinPartsAreFoundAndLeftOut) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  const TriangleMesh molar = formats::readMesh(kMeshes / "dental/molar_with_pulp.obj").mesh;
  const MeshReport report = checkMesh(molar);
  ASSERT_EQ(report.components.size(), 2u);
  EXPECT_EQ(report.buriedComponents(), 1u);
  const TriangleMesh solid = builder::withoutBuried(molar, report);
  const TriangleMesh tooth = formats::selectPart(molar, "Tooth0");
  EXPECT_EQ(solid.positions, tooth.positions);
  EXPECT_EQ(solid.triangles, tooth.triangles);

  const TriangleMesh shell = formats::readMesh(kMeshes / "failure/tooth/tooth_inner_shell_same_winding.obj").mesh,
                     cavity = formats::readMesh(kMeshes / "failure/tooth/tooth_cavity.obj").mesh;
  const MeshReport of_shell = checkMesh(shell), of_cavity = checkMesh(cavity);
  EXPECT_EQ(of_shell.buriedComponents(), 1u);
  EXPECT_EQ(of_cavity.buriedComponents(), 0u);
  EXPECT_TRUE(of_cavity.components[1].cavity);
  EXPECT_NEAR(test::volumeOf(builder::withoutBuried(shell, of_shell)), 1169.20992, 1e-3);
}

TEST(MeshChecksOnFiles, TheInsideOutToothIsTurned) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  const TriangleMesh mesh = formats::readMesh(kMeshes / "failure/tooth/tooth_all_flipped.obj").mesh;
  const TriangleMesh turned = builder::orientOutward(mesh, checkMesh(mesh));
  EXPECT_TRUE(checkMesh(turned).clean());
  EXPECT_NEAR(test::volumeOf(turned), 1169.20992, 1e-3);
}

TEST(MeshChecksOnFiles, EveryFileThatIsReadIsChecked) {
  if (!std::filesystem::exists(kMeshes)) GTEST_SKIP() << "no " << kMeshes;
  std::size_t checked = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kMeshes)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".md" || entry.path().extension() == ".txt") continue;
    TriangleMesh mesh;
    try {
      mesh = formats::readMesh(entry.path()).mesh;
    } catch (const std::runtime_error&) {
      continue;
    }
    const MeshReport report = checkMesh(mesh);
    ++checked;
    EXPECT_EQ(report.clean(), report.defects.empty());
    if (report.clean()) {
      EXPECT_GT(report.volume, 0) << entry.path();  // a mesh that a build accepts is wound outward
      EXPECT_TRUE(report.not_checked.empty());
    } else {
      EXPECT_FALSE(report.summary().empty());
    }
    for (const builder::Defect& d : report.defects) {
      EXPECT_GT(d.count, 0u);
      EXPECT_LE(d.first.size(), builder::kPlacesListed);
      for (const builder::Place& place : d.first)
        for (const std::uint32_t t : place.triangles) EXPECT_LT(t, mesh.triangles.size()) << entry.path();
    }
  }
  EXPECT_GT(checked, 110u);
}

}  // namespace
}  // namespace spheretree
