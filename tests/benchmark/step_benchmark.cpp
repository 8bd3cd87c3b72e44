// SPDX-License-Identifier: Apache-2.0
// Time of one servo step in a mouth: 28 teeth, 2 jaws, tongue, cheek and a probe, 512 leaves each; teeth and tongue
// have a skin of 2,048 triangles. In the mode of the paper, and in constrained mode on the leaves and on the skins, at
// the same poses. Paced: one step each millisecond, as a servo loop runs (it sleeps in between, as the player does, and
// does not spin: caches and predictors go cold), each with a pose that was not seen before. Time on the clock, from
// call to return; steps in which the system took the processor away are left out and counted. In the end the longest of
// many steps of each kind: the first, after a reset, after a jump of the hand, in contact, free. Usage: step_benchmark
// [STEPS] [TREE_DIR]   TREE_DIR: probe.stree, tooth.stree, ... made by `spheretree` in place of the built-in shapes.
#include <sys/resource.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "benchmark/benchmark_scenes.h"
#include "quantile.h"
#include "scene/compiled_scene.h"
#include "search/find_pairs.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/runtime/step.h"

namespace {

using namespace spheretree;
using namespace spheretree::runtime;
using benchmark::compiled;
using benchmark::ellipsoid;
using Clock = std::chrono::steady_clock;

SphereTree treeFile(const std::string& folder, const char* name, SphereTree built_in) {
  if (folder.empty()) return built_in;
  std::ifstream in(folder + "/" + name + ".stree", std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  SphereTree tree;
  if (decodeSphereTree(std::as_bytes(std::span(bytes)), tree) != LoadStatus::Ok) {
    std::fprintf(stderr, "%s/%s.stree cannot be read; the built-in shape stands in\n", folder.c_str(), name);
    return built_in;
  }
  return tree;
}

// Half an ellipse of balls: a jaw.
SphereTree archTree(double width, double depth, double radius) {
  std::vector<Sphere> balls;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 8; ++j) {
      const double angle = M_PI * (i + 0.5) / 64, turn = 2 * M_PI * j / 8;
      balls.push_back(test::ball((width + 3 * std::cos(turn)) * std::cos(angle), (depth + 3 * std::cos(turn)) * std::sin(angle),
                                 3 * std::sin(turn), radius));
    }
  return test::withSearch(test::treeOfBalls(std::move(balls)));
}

SceneDescription mouth(const std::string& folder) {
  SceneDescription d;
  d.tool = treeFile(folder, "probe", test::withSearch(test::rodTree(35, 512, 0.5)));
  d.reference_point = {0, 0, 20};
  const SharedTree tooth(treeFile(folder, "tooth", ellipsoid({4.5, 4.5, 7}, 1.8)));
  for (int i = 0; i < 28; ++i) {
    const double angle = M_PI * (i % 14 + 0.5) / 14;
    const bool upper = i >= 14;
    d.objects.push_back(
        {tooth, {{28 * std::cos(angle), 40 * std::sin(angle), upper ? 80.0 : 0.0}, rotationOf({upper ? M_PI : 0, 0, angle})}});
  }
  d.objects.push_back({archTree(28, 40, 3), {{0, 0, -7}, Quaternion(1, 0, 0, 0)}});
  d.objects.push_back({archTree(28, 40, 3), {{0, 0, 87}, Quaternion(1, 0, 0, 0)}});
  d.objects.push_back({ellipsoid({14, 20, 7}, 4), {{0, 10, -6}, Quaternion(1, 0, 0, 0)}});
  d.objects.push_back({archTree(50, 64, 4), {{0, 0, 40}, Quaternion(1, 0, 0, 0)}});
  return d;
}

// Haptic poses with about `wanted` pairs each: down into one lower tooth after the other, with the depth found by
// search.
std::vector<Configuration> posesWith(const Scene& scene, std::uint32_t wanted, int count) {
  Workspace scratch(scene);
  std::vector<Configuration> poses;
  test::Random random(wanted);
  double phase[6];
  for (double& p : phase) p = random.between(0, 6.28);
  for (int n = 0; n < count; ++n) {
    const double t = 0.001 * (n % 500) + n / 500;
    const int tooth = 3 + n / 500 % 8;
    const Eigen::Vector3d over = scene.compiled().objects[static_cast<std::size_t>(tooth)].anchor +
                                 Eigen::Vector3d(1.5 * std::sin(3.1 * t + phase[0]), 1.5 * std::sin(2.3 * t + phase[1]), 0);
    const Eigen::Vector3d tilt(0.5 * std::sin(2.7 * t + phase[2]), 0.5 * std::sin(1.9 * t + phase[3]), 0.8 * std::sin(1.3 * t + phase[4]));
    const auto pairsAt = [&](double z) {
      return findPairs({over + Eigen::Vector3d(0, 0, z), rotationOf(tilt)}, 0, PairsOf::LeavesExactly, 1u << 30, scratch.memory())
          .pairs.size();
    };
    double high = 32;
    while (high > 10 && pairsAt(high - 0.5) < wanted) high -= 0.5;
    double low = high - 0.5;
    for (int k = 0; k < 16; ++k) {
      const double z = (low + high) / 2;
      (pairsAt(z) > wanted ? low : high) = z;
    }
    poses.push_back({over + Eigen::Vector3d(0, 0, high), rotationOf(tilt)});
  }
  return poses;
}

// Number of times that the system took the processor away from this thread.
long interruptions() {
  rusage usage;
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

void run(const char* name, const Scene& scene, const std::vector<Configuration>& poses, Mode mode, bool paced) {
  Workspace workspace(scene);
  std::vector<double> micros, pairs, rows, linearisations, searches;
  std::uint32_t faults = 0, interrupted = 0;
  double penetration = 0;
  auto next = Clock::now();
  for (std::size_t n = 0; n < poses.size(); ++n) {
    if (n % 500 == 0) resetTo({poses[n].position + Eigen::Vector3d(0, 0, 25), poses[n].orientation}, workspace);
    const long before = interruptions();
    if (paced) {
      next += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(next);
      if (Clock::now() - next > std::chrono::milliseconds(5)) next = Clock::now();
    }
    const auto start = Clock::now();
    const StepResult r = step(scene, poses[n], mode, workspace);
    const auto end = Clock::now();
    faults |= r.faults;
    if (n % 500 < 20) continue;  // the way down from above
    if (interruptions() != before)
      ++interrupted;
    else
      micros.push_back(std::chrono::duration<double, std::micro>(end - start).count());
    pairs.push_back(r.pairs);
    rows.push_back(r.rows);
    linearisations.push_back(r.linearisations);
    searches.push_back(r.searches);
    penetration = std::max(penetration, r.penetration);
  }
  std::printf("%-24s %6.0f %6.0f %5.0f %4.0f %4.0f | %7.1f %7.1f %7.1f %7.1f | %8.5f %2x %5u\n", name, tool::quantile(pairs, 0.5),
              tool::quantile(pairs, 1), tool::quantile(linearisations, 0.5), tool::quantile(linearisations, 0.99),
              tool::quantile(searches, 1), tool::quantile(micros, 0.5), tool::quantile(micros, 0.99), tool::quantile(micros, 0.999),
              tool::quantile(micros, 1), penetration, faults, interrupted);
}

// The longest of all steps of a kind, with the largest work of any: a hand that goes on, and in between a new
// workspace, a reset, a jump of the hand.
void printLongest(const Scene& scene, const std::vector<Configuration>& poses, int steps) {
  enum Kind { kFirst, kAfterReset, kAfterJump, kInContact, kFree };
  struct {
    const char* name;
    std::uint32_t count = 0, work = 0;
    double micros = 0;
  } kinds[] = {{"first"}, {"after a reset"}, {"after a jump"}, {"in contact"}, {"free"}};
  auto workspace = std::make_unique<Workspace>(scene);
  std::size_t at = 0;
  for (int n = 0; n < steps; ++n) {
    Kind kind = n == 0 ? kFirst : kFree;
    at = (at + 1) % poses.size();
    if (n % 1000 == 0) workspace = std::make_unique<Workspace>(scene), kind = kFirst;
    if (n % 100 == 25) reset(*workspace), kind = kAfterReset;
    if (n % 100 == 50) at = (at + 500) % poses.size(), kind = kAfterJump;
    Configuration pose = poses[at];
    if (n % 100 >= 75) pose.position.z() += 40;
    const long before = interruptions();
    const auto start = Clock::now();
    const StepResult r = step(scene, pose, Mode::Constrained, *workspace);
    const double micros = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    if (kind == kFree && r.active > 0) kind = kInContact;
    ++kinds[kind].count;
    kinds[kind].work = std::max(kinds[kind].work, r.work);
    if (interruptions() == before) kinds[kind].micros = std::max(kinds[kind].micros, micros);
  }
  std::printf("\n%-24s %8s %10s %10s\n", "longest, on the skins", "steps", "most work", "max us");
  for (const auto& kind : kinds) std::printf("%-24s %8u %10u %10.1f\n", kind.name, kind.count, kind.work, kind.micros);
}

}  // namespace

int main(int argc, char** argv) {
  const int steps = argc > 1 ? std::max(100, std::atoi(argv[1])) : 4000;
  SceneDescription description = mouth(argc > 2 ? argv[2] : "");
  const Scene skins = compiled(description);
  description.contact = ContactSurface::Leaves;
  const Scene leaves = compiled(description);
  std::printf("%-24s %6s %6s %5s %4s %4s | %7s %7s %7s %7s | %8s %s %s\n", "case", "pairs", "most", "lin.", "p99", "srch", "median", "p99",
              "p99.9", "max us", "deep mm", "faults", "left out");
  for (const bool paced : {false, true})
    for (const std::uint32_t wanted : {1u, 150u, 2000u, 5000u}) {
      const std::vector<Configuration> poses = posesWith(leaves, wanted, steps);
      const std::string count = std::to_string(wanted) + (paced ? " paced" : " back to back");
      run(("paper " + count).c_str(), leaves, poses, Mode::Published, paced);
      run(("leaves " + count).c_str(), leaves, poses, Mode::Constrained, paced);
      run(("skin " + count).c_str(), skins, poses, Mode::Constrained, paced);
    }
  printLongest(skins, posesWith(leaves, 2000, steps), 50 * steps);
  return 0;
}
