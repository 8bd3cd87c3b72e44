// SPDX-License-Identifier: Apache-2.0
// What friction and bodies that move cost: each case is a hand's path in a scene without them and in the same scene
// with them. Prints processor times of both, interleaved in one run (median over rounds of the mean of a step), their
// ratio, and the share of steps with forces that miss the law of friction. Instructions: run one case in one variant
// under callgrind,
//   valgrind --tool=callgrind --toggle-collect='spheretree::runtime::step(*' contact_benchmark CASE plain|with
// Usage: contact_benchmark [CASE [plain|with]]
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "benchmark/benchmark_scenes.h"
#include "quantile.h"
#include "spheretree/runtime/step.h"

namespace {

using namespace spheretree;
using namespace spheretree::runtime;
using benchmark::compiled;
using benchmark::ellipsoid;
using Eigen::Vector3d;
const Quaternion kUpright(1, 0, 0, 0);
constexpr int kRounds = 15;  // of the clock

/// A path of the hand in a scene, and of the bodies in it.
struct Case {
  const char* name;
  std::function<SceneDescription(bool with)> scene;
  std::function<Configuration(int n)> hand;
  int steps;
  bool bodies_move = false;
};

SphereTree flatFoot() {
  return test::treeOfBalls({test::ball(-2, -2, 0, 1), test::ball(2, -2, 0, 1), test::ball(-2, 2, 0, 1), test::ball(2, 2, 0, 1)});
}

SceneDescription onPlate(SphereTree tool, double friction) {
  SceneDescription d;
  d.tool = std::move(tool);
  d.tool_friction = friction;
  d.objects.push_back({test::withSkin(test::boxTree({30, 30, 0}, {40, 40, 1}, 1.2), test::boxSkin({30, 30, 1})), {{0, 0, -1}, kUpright}});
  return d;
}

SceneDescription onTooth(SphereTree tool, double friction) {
  SceneDescription d;
  d.tool = std::move(tool);
  d.tool_friction = friction;
  d.objects.push_back({ellipsoid({4.5, 4.5, 7}, 1.8), {}});
  return d;
}

SceneDescription roughLeaves(double friction) {
  SceneDescription d;
  d.tool = test::rodTree(40, 60, 0.6);
  d.reference_point = {0, 0, 25};
  d.tool_friction = friction;
  d.objects.push_back({test::withSkin(test::oneBallTree(6.5), test::cuspedSkin(3)), {}});
  d.objects.push_back({test::ellipsoidTree({5, 5, 7}, 400, 0.7), {{11.5, 0, 0}, kUpright}});
  return d;
}

// 32 teeth in two arches, which stand still, or each a body of its own, or those of each arch together.
SceneDescription mouth(bool moves, bool is_jaw) {
  SceneDescription d;
  d.tool = test::withSearch(test::rodTree(35, 512, 0.5));
  d.reference_point = {0, 0, 20};
  const SharedTree tooth(ellipsoid({4.5, 4.5, 7}, 1.8));
  for (int i = 0; i < 32; ++i) {
    const double angle = M_PI * (i % 16 + 0.5) / 16;
    const bool upper = i >= 16;
    SceneObject object{tooth, {{28 * std::cos(angle), 40 * std::sin(angle), upper ? 80.0 : 0.0}, rotationOf({upper ? M_PI : 0, 0, angle})}};
    if (moves) object.body = static_cast<std::uint32_t>(is_jaw ? i / 16 + 1 : i + 1);
    d.objects.push_back(object);
  }
  return d;
}

// A hand that wanders about, by a seed.
std::vector<Configuration> wander(int steps) {
  test::Random random(1);
  Configuration hand{{0, 20, 0}, kUpright};
  Displacement velocity;
  std::vector<Configuration> path;
  for (int n = 0; n < steps; ++n) {
    velocity.translation = 0.95 * velocity.translation + test::randomPoint(random, 0.05) - 0.002 * hand.position;
    velocity.rotation = 0.95 * velocity.rotation + test::randomPoint(random, 0.003);
    hand = moved(hand, velocity);
    path.push_back(hand);
  }
  return path;
}

std::vector<Case> cases() {
  const auto slide = [](int n) { return Configuration{{0.01 * n, 0.004 * n, std::max(0.0, 1.5 - 0.05 * n)}, kUpright}; };
  const auto stick = [](int n) {
    return Configuration{{0.05 * std::sin(0.01 * n), 0.05 * std::sin(0.013 * n), std::max(0.0, 1.5 - 0.05 * n)}, kUpright};
  };
  const auto crown = [](int n) {
    const double t = 0.002 * n;
    return Configuration{{3 * std::sin(1.3 * t), 3 * std::sin(t), std::max(6.5, 9 - 0.05 * n)},
                         rotationOf({0.2 * std::sin(t), 0.1 * t, 0})};
  };
  const auto path = wander(1000);
  const auto wandering = [path](int n) { return path[static_cast<std::size_t>(n)]; };
  const auto probing = [](int n) {  // down to a tooth at the side, then along it
    const double t = 0.002 * n;
    return Configuration{{0.5 * std::sin(t), 39 + std::sin(1.3 * t), std::max(26.0, 34 - 0.05 * n)},
                         rotationOf({0.3 * std::sin(t), 0.2, 0})};
  };
  const auto above = [](int n) { return Configuration{{0.01 * n, 0, 60}, kUpright}; };
  const double mu = 0.3;
  std::vector<Case> all;
  all.push_back({"slide_ball", [=](bool with) { return onPlate(test::oneBallTree(1), with ? mu : 0); }, slide, 1000});
  all.push_back({"stick_ball", [=](bool with) { return onPlate(test::oneBallTree(1), with ? mu : 0); }, stick, 1000});
  all.push_back({"slide_foot", [=](bool with) { return onPlate(flatFoot(), with ? mu : 0); }, slide, 1000});
  all.push_back({"stick_foot", [=](bool with) { return onPlate(flatFoot(), with ? mu : 0); }, stick, 1000});
  all.push_back({"ball_on_tooth", [=](bool with) { return onTooth(test::oneBallTree(1), with ? mu : 0); }, crown, 2000});
  all.push_back({"foot_on_tooth", [=](bool with) { return onTooth(flatFoot(), with ? mu : 0); }, crown, 2000});
  all.push_back({"rough_leaves", [=](bool with) { return roughLeaves(with ? mu : 0); }, wandering, 1000});
  for (const bool is_jaw : {false, true}) {
    all.push_back({is_jaw ? "jaws_touched" : "bodies_touched", [=](bool with) { return mouth(with, is_jaw); }, probing, 2000, true});
    all.push_back({is_jaw ? "jaws_apart" : "bodies_apart", [=](bool with) { return mouth(with, is_jaw); }, above, 2000, true});
  }
  return all;
}

// Bodies sway by some micrometres a step, each in its way.
void moveBodies(int n, const Scene& scene, Workspace& workspace) {
  for (std::uint32_t body = 1; body < scene.bodyCount(); ++body) {
    const double t = 0.01 * n;
    const Vector3d way(0.2 * std::sin(t + body), 0.2 * std::cos(t + body), 0.1 * std::sin(2 * t + body));
    moveBody(body, {way, rotationOf(0.002 * way)}, workspace);
  }
}

struct Run {
  double seconds = 0;
  int unsolved = 0;  // steps
  std::uint64_t linearisations = 0, iterations = 0;
};

Run play(const Case& c, const Scene& scene, bool with) {
  Run run;
  Workspace workspace(scene);
  const auto now = [] {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  for (int n = 0; n < c.steps; ++n) {
    if (with && c.bodies_move) moveBodies(n, scene, workspace);
    const Configuration hand = c.hand(n);
    const double start = now();
    const StepResult r = step(scene, hand, Mode::Constrained, workspace);
    run.seconds += now() - start;
    run.unsolved += r.unsolved > 0;
    run.linearisations += r.linearisations;
    run.iterations += r.qp_iterations;
  }
  return run;
}

}  // namespace

int main(int argc, char** argv) {
  for (const Case& c : cases()) {
    if (argc > 1 && std::strcmp(argv[1], c.name) != 0) continue;
    const Scene plain = compiled(c.scene(false)), with = compiled(c.scene(true));
    if (argc > 2) {
      const bool is_with = std::strcmp(argv[2], "with") == 0;
      std::printf("%d steps, %.3f s\n", c.steps, play(c, is_with ? with : plain, is_with).seconds);
      continue;
    }
    std::vector<double> plain_us, with_us;
    Run a, b;
    for (int round = 0; round < kRounds; ++round) {
      a = play(c, plain, false);
      b = play(c, with, true);
      plain_us.push_back(1e6 * a.seconds / c.steps);
      with_us.push_back(1e6 * b.seconds / c.steps);
    }
    std::printf("%-16s %7.2f us %7.2f us  x %.2f  pieces %.2f %.2f  iterations %.2f %.2f  unsolved %.1f%%\n", c.name,
                tool::quantile(plain_us, 0.5), tool::quantile(with_us, 0.5), tool::quantile(with_us, 0.5) / tool::quantile(plain_us, 0.5),
                static_cast<double>(a.linearisations) / c.steps, static_cast<double>(b.linearisations) / c.steps,
                static_cast<double>(a.iterations) / c.steps, static_cast<double>(b.iterations) / c.steps, 100.0 * b.unsolved / c.steps);
  }
  return 0;
}
