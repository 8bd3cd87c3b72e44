// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/mesh_search.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "robot/sample_urdf.h"
#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::robot {
namespace {

namespace fs = std::filesystem;
using test::has;

class MeshSearchTest : public testing::Test {
 protected:
  MeshSearchTest() {
    unsetenv("ROS_PACKAGE_PATH");
    unsetenv("AMENT_PREFIX_PATH");
  }
  fs::path file(const std::string& name, const std::string& text = "") { return test::written(folder_.path() / name, text); }
  static std::string packageXml(const std::string& name) {
    return "<?xml version=\"1.0\"?>\n<package><name>\n " + name + "\n</name></package>";
  }
  fs::path urdf() const { return folder_.path() / "ws/robot/urdf/arm.urdf"; }

  /// The path of the file that is found, relative to the scratch folder; "" if none is.
  std::string find(const std::string& name, const std::vector<std::string>& words = {}) {
    const PackagePaths packages = packagePaths(words);
    MeshSearch search(urdf(), packages);
    std::string found;
    refusal_ = test::refusalOf<formats::FileError>([&] {
      found = fs::canonical(search.find(name, "arm.urdf:7: <mesh> of link tool")).lexically_relative(fs::canonical(folder_.path()));
    });
    notes_ = search.notes();
    return found;
  }

  test::ScratchFolder folder_;
  std::vector<std::string> notes_;
  std::string refusal_;
};

TEST_F(MeshSearchTest, AFolderIsThePackageThatItsNameOrItsPackageXmlSays) {
  file("ws/robot/package.xml", packageXml("arm_description"));
  file("ws/robot/meshes/a.stl");
  file("ws/other_name/package.xml", packageXml("hand"));
  file("ws/other_name/meshes/a.stl");
  file("ws/plain/meshes/a.stl");
  EXPECT_EQ(find("package://arm_description/meshes/a.stl"), "ws/robot/meshes/a.stl");
  EXPECT_EQ(find("model://arm_description/meshes/a.stl"), "ws/robot/meshes/a.stl");
  EXPECT_EQ(find("package://robot/meshes/a.stl"), "ws/robot/meshes/a.stl");
  EXPECT_EQ(find("package://hand/meshes/a.stl"), "ws/other_name/meshes/a.stl");
  EXPECT_EQ(find("package://plain/meshes/a.stl"), "ws/plain/meshes/a.stl");
  EXPECT_TRUE(notes_.empty());
}

TEST_F(MeshSearchTest, OptionsAndTheEnvironmentNameFolders) {
  file("far/hand_ros/package.xml", packageXml("hand"));
  file("far/hand_ros/meshes/a.stl");
  file("far/share/foot/a.stl");
  const std::string far = folder_.path() / "far";
  EXPECT_EQ(find("package://hand/meshes/a.stl"), "");
  EXPECT_TRUE(has(refusal_, "arm.urdf:7: <mesh> of link tool: package://hand/meshes/a.stl")) << refusal_;
  EXPECT_TRUE(has(refusal_, "--package hand=FOLDER")) << refusal_;
  EXPECT_EQ(find("package://hand/meshes/a.stl", {far}), "far/hand_ros/meshes/a.stl");
  EXPECT_EQ(find("package://hand/meshes/a.stl", {far + "/hand_ros/"}), "far/hand_ros/meshes/a.stl");
  EXPECT_EQ(find("package://x/meshes/a.stl", {"x=" + far + "/hand_ros"}), "far/hand_ros/meshes/a.stl");
  EXPECT_TRUE(notes_.empty());
  EXPECT_EQ(find("package://x/meshes/a.stl", {"x=" + far}), "");
  EXPECT_TRUE(has(refusal_, "/far of --package")) << refusal_;
  setenv("ROS_PACKAGE_PATH", ("/none:" + far).c_str(), 1);
  EXPECT_EQ(find("package://hand/meshes/a.stl"), "far/hand_ros/meshes/a.stl");
  setenv("AMENT_PREFIX_PATH", far.c_str(), 1);
  EXPECT_EQ(find("package://foot/a.stl"), "far/share/foot/a.stl");
}

TEST_F(MeshSearchTest, AFolderAboveThatHasTheRestOfThePathIsTakenWithANote) {
  file("ws/robot/meshes/a.stl");
  file("ws/robot/meshes/b.stl");
  const PackagePaths none;
  MeshSearch search(urdf(), none);
  for (const char* name : {"package://arm/meshes/a.stl", "package://arm/meshes/b.stl", "meshes/b.stl"}) (void)search.find(name, "P");
  ASSERT_EQ(search.notes().size(), 2u);  // one for each package
  EXPECT_TRUE(has(search.notes()[0], "P: the package arm is taken to be ")) << search.notes()[0];
  EXPECT_TRUE(has(search.notes()[0], "--package arm=FOLDER")) << search.notes()[0];
  EXPECT_TRUE(has(search.notes()[1], "/ws/robot, which holds meshes/b.stl.")) << search.notes()[1];
}

TEST_F(MeshSearchTest, PathsAreRelativeToTheUrdf) {
  file("ws/robot/urdf/a b.stl");
  file("ws/robot/meshes/a.stl");
  EXPECT_EQ(find("a b.stl"), "ws/robot/urdf/a b.stl");
  EXPECT_EQ(find("a%20b.stl"), "ws/robot/urdf/a b.stl");
  EXPECT_EQ(find("../meshes/a.stl"), "ws/robot/meshes/a.stl");
  EXPECT_EQ(find("..\\meshes\\a.stl"), "ws/robot/meshes/a.stl");
  EXPECT_EQ(find("file://../meshes/a.stl"), "ws/robot/meshes/a.stl");
  for (const char* scheme : {"", "file:", "file://", "file://localhost"})
    EXPECT_EQ(find(scheme + (folder_.path() / "ws/robot/meshes/a.stl").string()), "ws/robot/meshes/a.stl") << scheme;
  EXPECT_TRUE(notes_.empty());
  EXPECT_EQ(find("none.stl"), "");
  EXPECT_TRUE(has(refusal_, "arm.urdf:7: <mesh> of link tool: the mesh ")) << refusal_;
  EXPECT_EQ(find("package://"), "");
  EXPECT_EQ(find("package://a"), "");
  EXPECT_EQ(find(""), "");
}

TEST_F(MeshSearchTest, APackageThatIsNoFolderIsAnError) {
  for (const char* word : {"nodir", "a=nodir", "=nodir", ""})
    EXPECT_TRUE(has(test::refusalOf<formats::FileError>([&] { (void)packagePaths({word}); }), "NAME=FOLDER")) << word;
  const std::string odd = folder_.path() / "a=b";
  fs::create_directories(odd);
  EXPECT_EQ(packagePaths({odd}).folders, std::vector{fs::absolute(odd)});
}

}  // namespace
}  // namespace spheretree::robot
