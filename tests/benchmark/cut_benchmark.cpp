// SPDX-License-Identifier: Apache-2.0
// cut_benchmark [MINUTES]: the time of a step while a burr of 1 mm drills a block, as drilling goes on. Prints times; a
// shared machine's times pass or fail nothing.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "spheretree/runtime/step.h"
#include "support/random.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

using namespace spheretree;
using namespace spheretree::runtime;
using Eigen::Vector3d;

int main(int argc, char** argv) {
  const int minutes = argc > 1 ? std::atoi(argv[1]) : 1;
  SceneDescription d;
  std::vector<Sphere> handpiece{test::ball(0, 0, 0, 0.5)};
  for (int k = 1; k < 8; ++k) handpiece.push_back(test::ball(0, 0, 0.5 + 0.25 * k, 0.3));
  d.tool = test::treeOfBalls(handpiece);
  d.burr = {{{0, 0, 0}, 0.5}};
  SceneObject block{test::withSkin(test::boxTree({6, 6, 3}, {8, 8, 4}, 1), test::boxSkin({6, 6, 3})), {}};
  std::string fault;
  block.cut = cutModel(block.tree, {3.0, {}, 0.4}, fault);
  d.objects.push_back(block);
  Scene scene;
  if (!block.cut || !compileScene(d, scene, fault)) {
    std::fprintf(stderr, "%s\n", fault.c_str());
    return 1;
  }
  Workspace workspace(scene);
  setSpindle(true, workspace);
  test::Random random(3);
  Vector3d hand(0, 0, 4), goal = hand;
  std::printf("minute  median  p99  p99.9 [us]  removed [mm^3]\n");
  for (int minute = 1; minute <= minutes; ++minute) {
    std::vector<double> us;
    for (int n = 0; n < 60'000; ++n) {  // to one place after the other, at 10 mm/s
      if (n % 300 == 0) goal = {random.between(-2, 2), random.between(-2, 2), random.between(2.2, 3.6)};
      const Vector3d way = goal - hand;
      hand += std::min(1.0, 0.01 / std::max(way.norm(), 1e-9)) * way;
      const auto begun = std::chrono::steady_clock::now();
      step(scene, {hand, {1, 0, 0, 0}}, Mode::Constrained, workspace);
      us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begun).count());
    }
    std::sort(us.begin(), us.end());
    std::printf("%6d  %6.1f  %.1f  %.1f  %.2f\n", minute, us[us.size() / 2], us[us.size() * 99 / 100], us[us.size() * 999 / 1000],
                cutState(0, workspace).removed[0]);
    std::fflush(stdout);
  }
}
