// SPDX-License-Identifier: Apache-2.0
#include "search/find_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "state/step_memory.h"
#include "support/compiled_scene.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::compiled;
using test::Random;
using Triple = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // object, tool node, object node

std::uint32_t toolNode(const Scene& scene, std::uint32_t slot) {
  const CompiledScene& compiled = scene.compiled();
  return compiled.tool_nodes.at(compiled.tool.item.at(slot));
}
std::uint32_t objectNode(const Scene& scene, std::size_t object, std::uint32_t slot) {
  const CompiledShape& body = scene.compiled().shapeOf(object);
  return body.nodes.at(body.leaves.item.at(slot));
}

// The pairs as node numbers of the trees; also checks that no pair is reported twice.
std::set<Triple> triplesOf(const Scene& scene, const PairSet& set) {
  std::set<Triple> out;
  for (const PairRun& run : set.runs)
    for (std::uint32_t k = run.begin; k < run.begin + run.count; ++k) {
      const auto added = out.emplace(run.object, toolNode(scene, set.pairs[k] >> 16), objectNode(scene, run.object, set.pairs[k] & 0xffff));
      EXPECT_TRUE(added.second) << "pair " << k << " twice";
    }
  return out;
}

// Every leaf against every leaf, from the description alone.
std::set<Triple> bruteForce(const SceneDescription& d, const Configuration& pose, double margin) {
  std::set<Triple> out;
  const auto tool = test::placedLeaves(d.tool, pose, d.reference_point);
  for (std::uint32_t i = 0; i < d.objects.size(); ++i)
    for (const test::PlacedLeaf& b : test::placedLeaves(*d.objects[i].tree, d.objects[i].pose, Eigen::Vector3d::Zero()))
      for (const test::PlacedLeaf& a : tool)
        if ((a.centre - b.centre).norm() - (a.radius + b.radius) <= margin) out.emplace(i, a.node, b.node);
  return out;
}

SceneDescription randomScene(std::uint64_t seed) {
  Random random(seed);
  SceneDescription d;
  d.tool = test::randomTree(random.next(), 1 + static_cast<int>(random.below(5)), 4 + static_cast<int>(random.below(5)));
  d.tool.origin_mm = {random.between(-50, 50), random.between(-50, 50), random.between(-50, 50)};
  d.reference_point = Eigen::Vector3d(d.tool.origin_mm[0], d.tool.origin_mm[1], d.tool.origin_mm[2]) + test::randomPoint(random, 5);
  for (int i = 0; i < 3; ++i) {
    SphereTree tree = test::randomTree(random.next(), 1 + static_cast<int>(random.below(5)), 4 + static_cast<int>(random.below(5)));
    tree.origin_mm = {random.between(-1000, 1000), 0, 30};
    const Eigen::Vector3d origin(tree.origin_mm[0], 0, 30);
    Configuration pose{test::randomPoint(random, 12) - origin, Quaternion(1, 0, 0, 0)};
    if (i > 0) pose.orientation = test::randomRotation(random);
    if (i > 0) pose.position = test::randomPoint(random, 12) - pose.orientation * origin;
    d.objects.push_back({std::move(tree), pose});
  }
  d.step_limits.max_pairs = 1 << 18;
  return d;
}

TEST(FindPairs, FindsExactlyThePairsOfBruteForce) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const SceneDescription d = randomScene(seed);
    const Scene scene = compiled(d);
    Workspace workspace(scene);
    Random random(1000 + seed);
    for (int n = 0; n < 20; ++n) {
      const Configuration pose{test::randomPoint(random, 15), test::randomRotation(random)};
      const double margin = n % 3 == 0 ? 0 : random.between(0, 2);
      const PairSet set = findPairs(pose, margin, PairsOf::LeavesExactly, 1u << 30, workspace.memory());
      ASSERT_FALSE(set.coarse);
      const auto expected = bruteForce(d, pose, margin);
      ASSERT_EQ(triplesOf(scene, set), expected) << "seed " << seed << " pose " << n;
      pairs += expected.size();
    }
  }
  EXPECT_GT(pairs, 10000u);  // the poses do touch
}

// Leaves of one tree in the world, sorted by x: every leaf is tested against those with a close x. In double, without
// the tree.
struct LeafList {
  struct Leaf {
    double x, y, z, r;
    std::uint32_t node;
  };
  std::vector<Leaf> leaves;
  double largest = 0;
  Eigen::AlignedBox3d box;

  LeafList(const SphereTree& tree, const Configuration& pose, const Eigen::Vector3d& reference) {
    for (std::uint32_t n = 0; n < tree.nodeCount(); ++n) {
      if (!tree.isLeaf(n)) continue;
      const Sphere& s = tree.cover[n];
      const Eigen::Vector3d c = pose.orientation * (Eigen::Vector3d(s.x, s.y, s.z) - reference) + pose.position;
      leaves.push_back({c.x(), c.y(), c.z(), static_cast<double>(s.radius), n});
      largest = std::max(largest, static_cast<double>(s.radius));
      box.extend(c);
    }
    std::sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) { return a.x < b.x; });
  }
};

/// Tool node << 32 | object node, ascending.
std::vector<std::uint64_t> touching(const LeafList& tool, const LeafList& object) {
  std::vector<std::uint64_t> out;
  for (const LeafList::Leaf& a : tool.leaves) {
    const double far = a.r + object.largest;
    if (object.box.exteriorDistance(Eigen::Vector3d(a.x, a.y, a.z)) > far) continue;
    auto b =
        std::lower_bound(object.leaves.begin(), object.leaves.end(), a.x - far, [](const LeafList::Leaf& l, double x) { return l.x < x; });
    for (; b != object.leaves.end() && b->x <= a.x + far; ++b) {
      const double dx = a.x - b->x, dy = a.y - b->y, dz = a.z - b->z, reach = a.r + b->r;
      if (dx * dx + dy * dy + dz * dz <= reach * reach) out.push_back(std::uint64_t{a.node} << 32 | b->node);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST(FindPairs, TwentyPairsOfObjectsAtRandomPoses) {
  // F10. 100 poses for each pair; SPHERETREE_LONG=1: 10^5 (about 2 minutes of one core).
  const int poses = std::getenv("SPHERETREE_LONG") ? 100000 : 100;
  const std::array tools{test::rodTree(35, 512, 0.5), test::boxTree({5, 5, 5}, {8, 8, 8}, 0.9), test::ellipsoidTree({3, 4, 9}, 512, 0.7),
                         test::randomTree(11, 4, 8), test::rodTree(60, 100, 1.5)};
  const std::array objects{test::ellipsoidTree({4.5, 4.5, 7}, 512, 0.6), test::boxTree({10, 10, 1}, {16, 16, 2}, 0.9),
                           test::randomTree(12, 5, 7), test::ellipsoidTree({14, 20, 7}, 512, 1.6)};
  std::uint64_t missed = 0, extra = 0, found = 0, touched = 0;
  for (std::size_t t = 0; t < tools.size(); ++t)
    for (std::size_t o = 0; o < objects.size(); ++o) {
      Random random(10 * t + o);
      SceneDescription d;
      d.tool = tools[t];
      d.reference_point = test::randomPoint(random, 5);
      d.objects.push_back({objects[o], {test::randomPoint(random, 50), test::randomRotation(random)}});
      d.step_limits.max_pairs = 1 << 18;
      const Scene scene = compiled(d);
      Workspace workspace(scene);
      const LeafList object(*d.objects[0].tree, d.objects[0].pose, Eigen::Vector3d::Zero()), unmoved(d.tool, {}, d.reference_point);
      for (int n = 0; n < poses; ++n) {
        // Some leaf of the tool near some leaf of the object.
        Configuration pose{{}, test::randomRotation(random)};
        const LeafList::Leaf &a = unmoved.leaves[random.below(unmoved.leaves.size())],
                             &b = object.leaves[random.below(object.leaves.size())];
        const Eigen::Vector3d apart = test::randomRotation(random) * Eigen::Vector3d((a.r + b.r) * random.between(0.2, 1.3), 0, 0);
        pose.position = Eigen::Vector3d(b.x, b.y, b.z) + apart - pose.orientation * Eigen::Vector3d(a.x, a.y, a.z);
        const PairSet set = findPairs(pose, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory());
        ASSERT_FALSE(set.coarse);
        std::vector<std::uint64_t> pairs;
        for (const std::uint32_t pair : set.pairs)
          pairs.push_back(std::uint64_t{toolNode(scene, pair >> 16)} << 32 | objectNode(scene, 0, pair & 0xffff));
        std::sort(pairs.begin(), pairs.end());
        const std::vector<std::uint64_t> expected = touching(LeafList(d.tool, pose, d.reference_point), object);
        if (n < 2) {
          ASSERT_EQ(expected.size(), bruteForce(d, pose, 0).size());  // the preselection by x loses no pair
        }
        std::vector<std::uint64_t> odd;
        std::set_difference(expected.begin(), expected.end(), pairs.begin(), pairs.end(), std::back_inserter(odd));
        missed += odd.size();
        extra += pairs.size() + odd.size() - expected.size();
        found += pairs.size();
        touched += !expected.empty();
      }
      if (poses > 100) {
        std::printf("tool %zu, object %zu: %d poses, so far %llu pairs, %llu missed, %llu extra\n", t, o, poses,
                    static_cast<unsigned long long>(found), static_cast<unsigned long long>(missed),
                    static_cast<unsigned long long>(extra));
        std::fflush(stdout);
      }
    }
  EXPECT_EQ(missed, 0u);
  EXPECT_EQ(extra, 0u);
  EXPECT_GT(touched, static_cast<std::uint64_t>(10 * poses));
  RecordProperty("pairs", std::to_string(found));
}

TEST(FindPairs, DecidesTouchingPairsAsDoubleDoes) {
  // Balls that touch exactly or miss by one part in 1e12: float cannot tell, the pair set must be right.
  SceneDescription d;
  d.tool = test::boxTree({8, 8, 8}, {5, 5, 5}, 1);
  d.objects.push_back({test::boxTree({8, 8, 8}, {5, 5, 5}, 1), {}});
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  for (const double shift : {0.0, 1e-12, -1e-12, 1e-7, -1e-7}) {
    for (const double step : {2.0, 6.0}) {
      const Configuration pose{{step + shift, 0, 0}, Quaternion(1, 0, 0, 0)};
      EXPECT_EQ(triplesOf(scene, findPairs(pose, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory())), bruteForce(d, pose, 0))
          << shift;
    }
  }
  const Configuration touching{{2, 0, 0}, Quaternion(1, 0, 0, 0)}, apart{{2 + 1e-12, 0, 0}, Quaternion(1, 0, 0, 0)};
  EXPECT_GT(findPairs(touching, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory()).pairs.size(),
            findPairs(apart, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory()).pairs.size());
}

TEST(FindPairs, AFastSearchMissesNothing) {
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    const SceneDescription d = randomScene(seed);
    const Scene scene = compiled(d);
    Workspace workspace(scene);
    Random random(seed);
    const Configuration pose{test::randomPoint(random, 20), test::randomRotation(random)};
    const auto found = triplesOf(scene, findPairs(pose, 0.5, PairsOf::ContactSurface, 1u << 30, workspace.memory()));
    const auto smallest = bruteForce(d, pose, 0.5), largest = bruteForce(d, pose, 0.51);
    EXPECT_TRUE(std::includes(found.begin(), found.end(), smallest.begin(), smallest.end())) << seed;
    EXPECT_TRUE(std::includes(largest.begin(), largest.end(), found.begin(), found.end())) << seed;
  }
}

TEST(FindPairs, KernelsGiveTheSamePairsInTheSameOrder) {
  if (!isAvailable(Kernel::Avx2)) GTEST_SKIP() << "no AVX2 here";
  for (std::uint64_t seed = 200; seed < 230; ++seed) {
    const Scene scene = compiled(randomScene(seed));
    Workspace scalar(scene, Kernel::Scalar), avx2(scene, Kernel::Avx2);
    ASSERT_NE(scalar.memory().kernel, avx2.memory().kernel);
    Random random(seed);
    for (int n = 0; n < 10; ++n) {
      const Configuration pose{test::randomPoint(random, 20), test::randomRotation(random)};
      const PairsOf of = n % 2 == 0 ? PairsOf::LeavesExactly : PairsOf::ContactSurface;
      const PairSet a = findPairs(pose, 0.3, of, 1u << 30, scalar.memory()), b = findPairs(pose, 0.3, of, 1u << 30, avx2.memory());
      ASSERT_TRUE(std::equal(a.pairs.begin(), a.pairs.end(), b.pairs.begin(), b.pairs.end()));
      ASSERT_EQ(a.work, b.work);
    }
  }
}

TEST(FindPairs, ASearchTreeFindsThePairsThatTheTreeItselfFinds) {
  std::size_t pairs = 0, work = 0, work_without = 0;
  for (std::uint64_t seed = 300; seed < 320; ++seed) {
    SceneDescription without = randomScene(seed), with = without;
    Random random(seed);
    with.tool = test::withSearch(without.tool, 2 + random.below(7));
    for (SceneObject& object : with.objects) object.tree = test::withSearch(*object.tree, 2 + random.below(7));
    const Scene a = compiled(with), b = compiled(without);
    Workspace wa(a), wb(b);
    for (int n = 0; n < 10; ++n) {
      const Configuration pose{test::randomPoint(random, 15), test::randomRotation(random)};
      for (const PairsOf of : {PairsOf::LeavesExactly, PairsOf::ContactSurface}) {
        const PairSet x = findPairs(pose, 0.4, of, 1u << 30, wa.memory()), y = findPairs(pose, 0.4, of, 1u << 30, wb.memory());
        if (of == PairsOf::LeavesExactly) {
          ASSERT_EQ(triplesOf(a, x), triplesOf(b, y)) << seed << ' ' << n;
        }
        pairs += x.pairs.size();
        work += x.work;
        work_without += y.work;
      }
    }
  }
  EXPECT_GT(pairs, 1000u);        // the number depends on the order in which a compiler evaluates arguments
  EXPECT_LT(work, work_without);  // random trees enclose loosely
}

TEST(FindPairs, FindsEveryTriangleThatIsNear) {
  SceneDescription d;
  d.tool = test::rodTree(8, 20, 0.4);
  const Skin skin = test::randomSkin(3);
  d.objects.push_back({test::withSkin(test::oneBallTree(6), skin), {{30, 4, -2}, rotationOf({1, 0.3, -2})}});
  d.step_limits.max_pairs = 1 << 18;
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  Random random(4);
  std::size_t found = 0;
  for (int n = 0; n < 100; ++n) {
    const Configuration& at = d.objects[0].pose;
    const Configuration pose{at.position + test::randomPoint(random, 6), test::randomRotation(random)};
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;  // tool node, triangle
    const PairSet set = findPairs(pose, 0.3, PairsOf::ContactSurface, 1u << 30, workspace.memory());
    for (const std::uint32_t pair : set.pairs)
      EXPECT_TRUE(pairs.emplace(toolNode(scene, pair >> 16), scene.compiled().shapeOf(0).skin.tree.item.at(pair & 0xffff)).second);
    found += pairs.size();
    for (std::uint32_t leaf = 0; leaf < d.tool.nodeCount(); ++leaf) {
      if (!d.tool.isLeaf(leaf)) continue;
      const Sphere& s = d.tool.cover[leaf];
      const Eigen::Vector3d c =
          at.orientation.conjugate() * (pose.orientation * Eigen::Vector3d(s.x, s.y, s.z) + pose.position - at.position);
      for (std::uint32_t t = 0; t < skin.triangles.size(); ++t) {
        const SkinPatch patch = patchOf(skin, t);
        double nearest = 1e9;  // of some points of the patch
        for (const Eigen::Vector3f& p : patch.position) nearest = std::min(nearest, (p.cast<double>() - c).norm());
        if (nearest < static_cast<double>(s.radius) + 0.3) {
          ASSERT_TRUE(pairs.count({leaf, t})) << n << ' ' << leaf << ' ' << t;
        }
      }
    }
  }
  EXPECT_GT(found, 300u);
}

TEST(FindPairs, AFullListStillRepresentsEveryPair) {
  SceneDescription d;
  d.tool = test::boxTree({6, 6, 6}, {8, 8, 8}, 1);
  for (int i = 0; i < 3; ++i) d.objects.push_back({test::boxTree({6, 6, 6}, {8, 8, 8}, 1), {{2.0 * i, 0, 0}, Quaternion(1, 0, 0, 0)}});
  const Configuration pose{{1, 1, 1}, Quaternion(1, 0, 0, 0)};
  for (const auto& [max_pairs, max_work] :
       {std::pair{192u, 1u << 30}, {1000u, 1u << 30}, {5000u, 1u << 30}, {1u << 18, 200u}, {1u << 18, 2000u}}) {
    d.step_limits.max_pairs = max_pairs;
    const Scene scene = compiled(d);
    Workspace workspace(scene);
    const PairSet set = findPairs(pose, 0, PairsOf::LeavesExactly, max_work, workspace.memory());
    EXPECT_TRUE(set.coarse);
    EXPECT_LE(set.pairs.size(), max_pairs);
    EXPECT_LE(set.work, max_work + 200);
    // For every leaf pair of brute force, the set contains it or a pair of ancestors.
    std::set<Triple> found;  // by slots
    for (const PairRun& run : set.runs)
      for (std::uint32_t k = run.begin; k < run.begin + run.count; ++k)
        EXPECT_TRUE(found.emplace(run.object, set.pairs[k] >> 16, set.pairs[k] & 0xffff).second);
    // By node of the file: the slots from its own up to the root.
    const auto linesOf = [](const CompiledTree& tree, const std::vector<std::uint32_t>& nodes) {
      std::vector<std::uint32_t> parent(tree.item.size(), 0);
      std::map<std::uint32_t, std::vector<std::uint32_t>> lines;
      for (std::uint32_t slot = 0; slot < tree.item.size(); ++slot) {
        if (tree.isInner(slot))
          for (std::uint32_t k = 0; k < 8; ++k) parent[8 * (tree.links[slot / 8].first_child + slot % 8) + k] = slot;
        if (tree.item[slot] == kNoItem) continue;
        std::vector<std::uint32_t>& line = lines[nodes[tree.item[slot]]];
        for (line = {slot}; line.back() != 0;) line.push_back(parent[line.back()]);
      }
      return lines;
    };
    const auto tool_lines = linesOf(scene.compiled().tool, scene.compiled().tool_nodes),
               object_lines = linesOf(scene.compiled().shapeOf(0).leaves, scene.compiled().shapeOf(0).nodes);
    for (const auto& [object, t, o] : bruteForce(d, pose, 0)) {
      bool stands = false;
      for (const std::uint32_t a : tool_lines.at(t))
        for (const std::uint32_t b : object_lines.at(o)) stands |= found.count({object, a, b}) > 0;
      ASSERT_TRUE(stands) << object << ' ' << t << ' ' << o;
    }
  }
}

TEST(FindPairs, FarObjectsCostOneTest) {
  SceneDescription d;
  d.tool = test::rodTree(30, 64, 0.5);
  for (int i = 0; i < 33; ++i) d.objects.push_back({test::boxTree({2, 2, 2}, {4, 4, 4}, 0.5), {{100.0 * i, 0, 0}, Quaternion(1, 0, 0, 0)}});
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  EXPECT_LE(findPairs({{50, 500, 0}, Quaternion(1, 0, 0, 0)}, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory()).work, 5u);
}

}  // namespace
}  // namespace spheretree::runtime
