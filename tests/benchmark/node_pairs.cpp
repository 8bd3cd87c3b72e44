// SPDX-License-Identifier: Apache-2.0
// Sphere pairs that a tree-tree query tests, at random touching poses of a tool on an object: what a builder costs at run time, whatever
// the machine. The same poses for every pair of trees: the tool is turned at random and moved along a random line until the leaves of the
// first pair of trees just touch, all of it in double.
// Usage: node_pairs POSES TOOL.stree OBJECT.stree [TOOL.stree OBJECT.stree ...]   e.g. 10000 poses: 10 s of one core for two pairs
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "support/random.h"

namespace {

using namespace spheretree;
using Eigen::Vector3d;

struct Query {
  std::uint64_t tested = 0, touching = 0;  // node pairs; leaf pairs that overlap
};

Vector3d centreOf(const Sphere& s) { return {s.x, s.y, s.z}; }

// Both trees from the root down; of two spheres that overlap, the larger one with children is opened.
class Traversal {
 public:
  Traversal(const SphereTree& tool, const SphereTree& object) : tool_(tool), object_(object), centre_(tool.nodeCount()) {}

  Query run(const Configuration& pose, bool first_hit_ends) {
    const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
    for (std::size_t i = 0; i < centre_.size(); ++i) centre_[i] = turn * centreOf(sphereOf(tool_, i, SphereKind::Bound)) + pose.position;
    Query query;
    open_.assign(1, {0, 0});
    while (!open_.empty()) {
      const auto [a, b] = open_.back();
      open_.pop_back();
      const Sphere &s = sphereOf(tool_, a, SphereKind::Bound), &t = sphereOf(object_, b, SphereKind::Bound);
      const double reach = static_cast<double>(s.radius) + static_cast<double>(t.radius);
      ++query.tested;
      if ((centre_[a] - centreOf(t)).squaredNorm() > reach * reach) continue;
      if (tool_.isLeaf(a) && object_.isLeaf(b)) {
        ++query.touching;
        if (first_hit_ends) return query;
      } else if (object_.isLeaf(b) || (!tool_.isLeaf(a) && s.radius > t.radius)) {
        for (std::uint32_t k = 0; k < tool_.child_count[a]; ++k) open_.push_back({tool_.first_child[a] + k, b});
      } else {
        for (std::uint32_t k = 0; k < object_.child_count[b]; ++k) open_.push_back({a, object_.first_child[b] + k});
      }
    }
    return query;
  }

 private:
  const SphereTree &tool_, &object_;
  std::vector<Vector3d> centre_;  // of the tool's spheres, in the frame of the object
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open_;
};

// A turn at random, and along a line at random through the middle of the object the last place that touches.
Configuration touchingPose(Traversal& traversal, const SphereTree& tool, const SphereTree& object, test::Random& random) {
  Configuration pose;
  pose.orientation = rotationOf(M_PI * std::cbrt(random.unit()) * random.direction());
  const Sphere &a = tool.bound[0], &b = object.bound[0];
  const Vector3d direction = random.direction();
  // A leaf of the tool, so that the tool's thin parts meet the object too, not always its middle.
  const std::vector<std::uint32_t> leaves = levelSet(tool, tool.levelCount() - 1);
  const std::uint32_t leaf = leaves[random.below(leaves.size())];
  const Vector3d aimed = centreOf(b) - pose.orientation * centreOf(tool.cover[leaf]);
  double near = 0, far = 2 * (static_cast<double>(a.radius) + static_cast<double>(b.radius));
  while (far - near > 1e-6 * static_cast<double>(b.radius)) {
    const double middle = 0.5 * (near + far);
    pose.position = aimed + middle * direction;
    (traversal.run(pose, true).touching > 0 ? near : far) = middle;
  }
  pose.position = aimed + near * direction;
  return pose;
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
  Traversal first(trees[0], trees[1]);
  for (int i = 0; i < poses; ++i) at.push_back(touchingPose(first, trees[0], trees[1], random));
  double reference = 0;
  for (std::size_t pair = 0; pair < trees.size(); pair += 2) {
    Traversal traversal(trees[pair], trees[pair + 1]);
    Query sum;
    for (const Configuration& pose : at) {
      const Query query = traversal.run(pose, false);
      sum.tested += query.tested;
      sum.touching += query.touching;
    }
    const double mean = static_cast<double>(sum.tested) / poses;
    if (pair == 0) reference = mean;
    std::printf("%s on %s: %.1f node pairs tested, %.2f leaf pairs touching, a pose; %.2f of the first\n", words[2 + pair], words[3 + pair],
                mean, static_cast<double>(sum.touching) / poses, mean / reference);
  }
  return 0;
}
