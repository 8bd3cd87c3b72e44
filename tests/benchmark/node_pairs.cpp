// SPDX-License-Identifier: Apache-2.0
// Sphere pairs that a tree-tree query tests, at random touching poses of a tool on an object: what a builder costs at
// run time, whatever the machine. Once by the bounding spheres of the files and once by their search trees over the
// same leaves. The same poses for every pair of trees: the tool is turned at random and moved along a random line until
// the leaves of the first pair of trees just touch, all of it in double. Usage: node_pairs POSES TOOL.stree
// OBJECT.stree [TOOL.stree OBJECT.stree ...]   e.g. 10000 poses: 10 s of one core for two pairs
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "scene/compiled_tree.h"
#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "support/random.h"

namespace {

using namespace spheretree;
using Eigen::Vector3d;

struct Query {
  std::uint64_t tested = 0, opened = 0, touching = 0;  // node pairs; node pairs of which one was opened; leaf pairs that overlap
};

struct Node {
  Vector3d centre;
  double radius;
  float open_priority;  // 0 for a leaf
  std::uint32_t first_child, child_count;
};
using Nodes = std::vector<Node>;

Node nodeOf(const Sphere& s, std::uint32_t first_child, std::uint32_t child_count) {
  const float open_priority = child_count > 0 ? s.radius / static_cast<float>(child_count) : 0;  // as BlockLinks::open_priority
  return {{s.x, s.y, s.z}, static_cast<double>(s.radius), open_priority, first_child, child_count};
}

Nodes boundsOf(const SphereTree& tree) {
  Nodes nodes;
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i)
    nodes.push_back(nodeOf(sphereOf(tree, i, SphereKind::Bound), tree.first_child[i], tree.child_count[i]));
  return nodes;
}

// As the runtime lays it out: inner node n of the search tree has its children from 8 n on.
Nodes searchNodesOf(const SphereTree& tree) {
  std::vector<Sphere> leaves;
  for (const std::uint32_t i : levelSet(tree, tree.levelCount() - 1)) leaves.push_back(tree.cover[i]);
  const runtime::CompiledTree compiled =
      runtime::compileTree(runtime::searchTreeOf(tree), leaves, Vector3d::Zero(), runtime::TreeOver::Leaves);
  Nodes nodes;
  for (std::uint32_t slot = 0; slot < compiled.item.size(); ++slot) {
    std::uint32_t first_child = 0, child_count = 0;
    if (compiled.isInner(slot)) {
      first_child = 8 * (compiled.links[slot / 8].first_child + slot % 8);
      while (child_count < 8 && compiled.spheres[first_child + child_count].radius > 0) ++child_count;
    }
    nodes.push_back(nodeOf(compiled.spheres[slot], first_child, child_count));
  }
  return nodes;
}

// Both trees from the root down; of two nodes that overlap, the one of higher open priority is opened, as at run time.
class Traversal {
 public:
  Traversal(Nodes tool, Nodes object) : tool_(std::move(tool)), object_(std::move(object)), centre_(tool_.size()) {}

  Query run(const Configuration& pose, bool first_hit_ends) {
    const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
    for (std::size_t i = 0; i < centre_.size(); ++i) centre_[i] = turn * tool_[i].centre + pose.position;
    Query query;
    open_.assign(1, {0, 0});
    while (!open_.empty()) {
      const auto [a, b] = open_.back();
      open_.pop_back();
      const Node &s = tool_[a], &t = object_[b];
      const double reach = s.radius + t.radius;
      ++query.tested;
      if ((centre_[a] - t.centre).squaredNorm() > reach * reach) continue;
      if (s.child_count == 0 && t.child_count == 0) {
        ++query.touching;
        if (first_hit_ends) return query;
        continue;
      }
      ++query.opened;
      if (s.open_priority > t.open_priority) {
        for (std::uint32_t k = 0; k < s.child_count; ++k) open_.push_back({s.first_child + k, b});
      } else {
        for (std::uint32_t k = 0; k < t.child_count; ++k) open_.push_back({a, t.first_child + k});
      }
    }
    return query;
  }

 private:
  Nodes tool_, object_;
  std::vector<Vector3d> centre_;  // of the tool's spheres, in the frame of the object
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open_;
};

// Rotates at random, and finds the last touching place along a random line through the middle of the object.
Configuration touchingPose(Traversal& traversal, const SphereTree& tool, const SphereTree& object, test::Random& random) {
  Configuration pose;
  pose.orientation = rotationOf(M_PI * std::cbrt(random.unit()) * random.direction());
  const Node a = nodeOf(tool.bound[0], 0, 0), b = nodeOf(object.bound[0], 0, 0);
  const Vector3d direction = random.direction();
  // Through a leaf of the tool, so that the tool's thin parts also meet the object, not always its middle.
  const std::vector<std::uint32_t> leaves = levelSet(tool, tool.levelCount() - 1);
  const Vector3d aimed = b.centre - pose.orientation * nodeOf(tool.cover[leaves[random.below(leaves.size())]], 0, 0).centre;
  double near = 0, far = 2 * (a.radius + b.radius);
  while (far - near > 1e-6 * b.radius) {
    const double middle = 0.5 * (near + far);
    pose.position = aimed + middle * direction;
    (traversal.run(pose, true).touching > 0 ? near : far) = middle;
  }
  pose.position = aimed + near * direction;
  return pose;
}

// Prints the cost of the poses; returns the pairs tested for each pose.
double report(const char* with, Traversal traversal, const std::vector<Configuration>& poses, double reference) {
  Query sum;
  for (const Configuration& pose : poses) {
    const Query query = traversal.run(pose, false);
    sum.tested += query.tested;
    sum.opened += query.opened;
    sum.touching += query.touching;
  }
  const auto count = static_cast<double>(poses.size());
  const double tested = static_cast<double>(sum.tested) / count;
  std::printf("  %s: %.1f node pairs tested (%.1f opened), %.2f leaf pairs touching, a pose; %.2f of the first\n", with, tested,
              static_cast<double>(sum.opened) / count, static_cast<double>(sum.touching) / count, reference > 0 ? tested / reference : 1);
  return tested;
}

SphereTree read(const char* path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  SphereTree tree;
  if (decodeSphereTree(std::as_bytes(std::span(bytes)), tree) != LoadStatus::Ok || tree.bound.empty()) {
    std::fprintf(stderr, "node_pairs: %s is not a readable sphere-tree with children; make it with spheretree build\n", path);
    std::exit(4);
  }
  return tree;
}

}  // namespace

int main(int count, char** words) {
  const int poses = count > 1 ? std::atoi(words[1]) : 0;
  if (count < 4 || count % 2 != 0 || poses < 1) {
    std::fprintf(stderr, "usage: node_pairs POSES TOOL.stree OBJECT.stree [TOOL.stree OBJECT.stree ...]\n");
    return 2;
  }
  std::vector<SphereTree> trees;
  for (int i = 2; i < count; ++i) trees.push_back(read(words[i]));
  std::vector<Configuration> at;
  test::Random random(1);
  Traversal first(boundsOf(trees[0]), boundsOf(trees[1]));
  for (int i = 0; i < poses; ++i) at.push_back(touchingPose(first, trees[0], trees[1], random));
  double reference = 0;
  for (std::size_t pair = 0; pair < trees.size(); pair += 2) {
    const SphereTree &tool = trees[pair], &object = trees[pair + 1];
    std::printf("%s on %s\n", words[2 + pair], words[3 + pair]);
    const double tested = report("bounding spheres of the files", {boundsOf(tool), boundsOf(object)}, at, reference);
    if (pair == 0) reference = tested;
    report("search trees", {searchNodesOf(tool), searchNodesOf(object)}, at, reference);
  }
  return 0;
}
