// SPDX-License-Identifier: GPL-3.0-or-later
// Figures of soft tissue that need no file, as JSON: a ball pressed into a block, against a finer block; times of a
// state by the number of nodes, of a refit, and of a step. benchmarks/tissue.py makes a table of them.
//   tissue_benchmark
#include <time.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "quantile.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/soften_tree.h"
#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"
#include "support/shape_trees.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"

namespace {

using namespace spheretree;
using Eigen::Vector3d;
using Field = std::vector<Vector3d>;
using Cells = std::array<std::uint32_t, 3>;

const Vector3d kBlock(40, 40, 20);  // 15 kPa, Poisson's ratio 0.45, held below [mm]
constexpr double kBall = 8, kDepth = 5;

/// Processor time of this thread [us].
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

Tissue blockOf(const Cells& cells) {
  const TetrahedronList solid = test::boxTetrahedra(kBlock, cells);
  Tissue tissue;
  tissue.material = {15, 0.45, 1040};
  for (const Vector3d& p : solid.nodes) {
    if (p.z() < 1e-9) tissue.fixed.push_back(static_cast<std::uint32_t>(tissue.nodes.size()));
    tissue.nodes.push_back({p.x(), p.y(), p.z()});
  }
  tissue.tetrahedra = solid.corners;
  tissue.surface.push_back({tissue.nodes[0], 0, {1, 0, 0}});  // tissue must have a surface
  return tissue;
}

double volumeOf(const Tissue& tissue, std::span<const Vector3d> u) {
  double sum = 0;
  for (const auto& c : tissue.tetrahedra) {
    const auto p = [&](std::size_t k) { return Vector3d(Vector3d(tissue.nodes[c[k]].data()) + u[c[k]]); };
    sum += (p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) / 6;
  }
  return sum;
}

struct Pressed {
  double force = 0;         // [N]
  double depth_left = 0;    // of the node that is deepest in the ball [mm]
  double volume_ratio = 1;  // of the block
};

/// The ball, without friction, kDepth below the middle of the top; no node of the block is in it. Without trees, leaves
/// and compliances: the multipliers of the nodes by Uzawa's method, the shape under them by the solver.
Pressed pressNodes(const Cells& cells) {
  const Tissue tissue = blockOf(cells);
  std::string fault;
  const auto solver = tissue::TissueSolver::make(tissue, fault);
  if (!solver) std::fprintf(stderr, "%s\n", fault.c_str()), std::exit(1);
  Field forces(tissue.nodes.size(), Vector3d::Zero());
  std::vector<std::size_t> top;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Vector3d p(tissue.nodes[i].data());
    if (p.z() > kBlock.z() - 1e-9 && (p - Vector3d(20, 20, 20)).norm() < 1.6 * kBall) top.push_back(i);
  }
  std::vector<double> press(top.size(), 0);
  // Half of the resistance of a single node: rough patterns of forces need no more, and smooth ones converge with time.
  const double spacing = kBlock.x() / cells[0], step = 0.5 * 0.015 * spacing;
  Pressed out;
  constexpr int kRamp = 30, kRounds = 200;
  for (int round = 1; round <= kRounds; ++round) {
    const double depth = kDepth * std::min(1.0, static_cast<double>(round) / kRamp);
    const Vector3d centre(20, 20, kBlock.z() + kBall - depth);
    out = {};
    for (std::size_t k = 0; k < top.size(); ++k) {
      const Vector3d from = Vector3d(tissue.nodes[top[k]].data()) + solver->displacements()[top[k]] - centre;
      const double inside = kBall - from.norm();
      press[k] = std::max(0.0, press[k] + step * inside);
      forces[top[k]] = press[k] * from.normalized();
      out.force -= forces[top[k]].z();
      out.depth_left = std::max(out.depth_left, inside);
    }
    solver->advance(forces, 3);
  }
  out.force = std::abs(out.force);
  out.volume_ratio = volumeOf(tissue, solver->displacements()) / (kBlock.x() * kBlock.y() * kBlock.z());
  return out;
}

/// A point of a face of the top that the ball may press on, with its multiplier.
struct FacePoint {
  std::array<std::uint32_t, 3> corner;
  Vector3d weight;
  double press = 0;
};

std::vector<FacePoint> pointsOfTop(const Tissue& tissue, std::vector<std::array<std::uint32_t, 3>>& top) {
  std::vector<FacePoint> points;
  for (const std::array<std::uint32_t, 3>& face : outerFaces(tissue)) {
    const auto isTop = [&](std::uint32_t v) { return tissue.nodes[v][2] > kBlock.z() - 1e-9; };
    if (!std::all_of(face.begin(), face.end(), isTop)) continue;
    top.push_back(face);
    Vector3d middle = Vector3d::Zero();
    for (const std::uint32_t v : face) middle += Vector3d(tissue.nodes[v].data()) / 3;
    if ((middle - Vector3d(20, 20, 20)).norm() > 1.6 * kBall) continue;
    points.push_back({face, Vector3d::Constant(1.0 / 3)});  // and towards each corner: the middles of its four quarters
    for (int k = 0; k < 3; ++k) points.push_back({face, Vector3d::Constant(1.0 / 6) + 0.5 * Vector3d::Unit(k)});
  }
  return points;
}

/// Like pressNodes(), but the ball also presses between the nodes: on four points of each face, which bulges according
/// to the normals at its corners.
Pressed pressFaces(const Cells& cells) {
  const Tissue tissue = blockOf(cells);
  std::string fault;
  const auto solver = tissue::TissueSolver::make(tissue, fault);
  if (!solver) std::fprintf(stderr, "%s\n", fault.c_str()), std::exit(1);
  std::vector<std::array<std::uint32_t, 3>> top;
  std::vector<FacePoint> points = pointsOfTop(tissue, top);
  Field forces(tissue.nodes.size()), normals(tissue.nodes.size());
  const double spacing = kBlock.x() / cells[0], step = 0.5 * 0.015 * spacing / 8;  // of pressNodes(), for eight points a node
  const auto placeOf = [&](std::uint32_t v) { return Vector3d(Vector3d(tissue.nodes[v].data()) + solver->displacements()[v]); };
  Pressed out;
  constexpr int kRamp = 30, kRounds = 400;
  for (int round = 1; round <= kRounds; ++round) {
    const double depth = kDepth * std::min(1.0, static_cast<double>(round) / kRamp);
    const Vector3d centre(20, 20, kBlock.z() + kBall - depth);
    std::fill(normals.begin(), normals.end(), Vector3d::Zero());
    std::fill(forces.begin(), forces.end(), Vector3d::Zero());
    for (const auto& f : top)
      for (const std::uint32_t v : f) normals[v] += (placeOf(f[1]) - placeOf(f[0])).cross(placeOf(f[2]) - placeOf(f[0]));
    for (Vector3d& n : normals) n.normalize();
    out = {};
    for (FacePoint& p : points) {
      Vector3d at = Vector3d::Zero(), normal = Vector3d::Zero();
      double bulge = 0;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = p.corner[static_cast<std::size_t>(k)], b = p.corner[static_cast<std::size_t>((k + 1) % 3)];
        at += p.weight[k] * placeOf(a);
        normal += p.weight[k] * normals[a];
        bulge += 0.5 * p.weight[k] * p.weight[(k + 1) % 3] * (placeOf(b) - placeOf(a)).dot(normals[b] - normals[a]);
      }
      const Vector3d from = at + bulge * normal.normalized() - centre;
      p.press = std::max(0.0, p.press + step * (kBall - from.norm()));
      if (p.press > 0) out.depth_left = std::max(out.depth_left, kBall - from.norm());
      const Vector3d force = p.press * from.normalized();
      out.force -= force.z();
      for (int k = 0; k < 3; ++k) forces[p.corner[static_cast<std::size_t>(k)]] += p.weight[k] * force;
    }
    solver->advance(forces, 3);
  }
  out.force = std::abs(out.force);
  out.volume_ratio = volumeOf(tissue, solver->displacements()) / (kBlock.x() * kBlock.y() * kBlock.z());
  return out;
}

/// The block of a player: a tree with a skin, and its tissue.
struct SoftBlock {
  runtime::SharedTree tree;
  std::shared_ptr<const Tissue> tissue;

  SoftBlock(const Cells& cells, int leaves) {
    const TriangleMesh boundary = test::boxMesh(Vector3d::Zero(), kBlock);
    const TriangleMesh mesh = test::quartered(test::quartered(test::quartered(test::quartered(boundary))));
    builder::Progress progress;
    builder::BuildSettings settings;
    settings.levels = 5;
    settings.max_leaves = leaves;
    settings.quality = builder::Quality::Quick;
    settings.soft_share = 0.5;
    SphereTree built = builder::buildSphereTree(mesh, settings, progress).tree;
    tissue = std::make_shared<const Tissue>(builder::softenTree(
        mesh, built, boundary, test::boxTetrahedra(kBlock, cells), {15, 0.45, 1040}, [](const Vector3d& p) { return p.z() < 1e-6; },
        progress));
    tree = std::move(built);
  }
};

/// The same with the runtime, as in a player.
struct FeltBlock {
  runtime::SharedTree shared;
  std::shared_ptr<const Tissue> tissue;
  runtime::Scene scene;
  std::unique_ptr<runtime::Workspace> workspace;
  std::unique_ptr<tissue::MovingTissue> motion;
  tissue::TissueState states[2];
  int steps = 0;

  explicit FeltBlock(const SoftBlock& block, double friction = 0) : shared(block.tree), tissue(block.tissue) {
    std::string fault;
    runtime::SceneDescription d;
    d.tool = test::oneBallTree(kBall);
    d.objects.push_back({});
    d.objects[0].tree = shared;
    d.objects[0].friction = friction;
    d.objects[0].tissue = runtime::tissueModel(shared, tissue, fault);
    if (!fault.empty() || !compileScene(d, scene, fault)) std::fprintf(stderr, "%s\n", fault.c_str()), std::exit(1);
    workspace = std::make_unique<runtime::Workspace>(scene);
    motion = tissue::MovingTissue::make(*tissue, fault);
    states[0] = states[1] = motion->restState();
  }
  /// With the solver, in every tenth step.
  void exchange() {
    if (steps++ % 10 != 0) return;
    std::swap(states[0], states[1]);
    aimTissue(0, states[0].surface, states[0].is_frozen, *workspace);
    motion->advance(tissueForces(0, *workspace), states[1]);
  }
  runtime::StepResult step(const Vector3d& p) { return runtime::step(scene, {p, {1, 0, 0, 0}}, runtime::Mode::Constrained, *workspace); }
  runtime::StepResult to(const Vector3d& p) {
    exchange();
    return step(p);
  }
  /// Down until the tool is kDepth below the top, and until the force is constant.
  runtime::StepResult press() {
    const double wanted = kBlock.z() + kBall - kDepth;
    Vector3d hand(20.3, 19.8, kBlock.z() + kBall + 1);
    runtime::StepResult r = to(hand);
    for (; r.graphic.position.z() > wanted; r = to(hand)) hand.z() -= 0.02;
    for (int i = 0; i < 600; ++i) {
      hand.z() += 0.03 * (wanted - r.graphic.position.z());
      r = to(hand);
    }
    return r;
  }
};

struct Times {
  double median, p99;
};

template <class Work>
Times timesOf(int rounds, const Work& work) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const double start = now();
    work(i);
    times.push_back(now() - start);
  }
  return {tool::quantile(times, 0.5), tool::quantile(times, 0.99)};
}

void printTimes(const char* name, const Times& t, const char* end = ",\n") {
  std::printf("  \"%s\": {\"median_us\": %.1f, \"p99_us\": %.1f}%s", name, t.median, t.p99, end);
}

void stateTimes() {
  std::printf("  \"states\": [");
  const char* comma = "";
  for (const Cells& cells : {Cells{6, 6, 4}, Cells{9, 9, 6}, Cells{12, 12, 7}, Cells{15, 15, 8}}) {
    const Tissue tissue = blockOf(cells);
    std::string fault;
    const auto solver = tissue::TissueSolver::make(tissue, fault);
    Field forces(tissue.nodes.size(), Vector3d::Zero());
    const Times t = timesOf(20, [&](int round) {
      for (std::size_t i = 0; i < forces.size(); ++i)
        if ((Vector3d(tissue.nodes[i].data()) - Vector3d(20, 20, 20)).norm() < 6) forces[i].z() = -0.002 * round;
      solver->advance(forces, tissue::kIterations);
    });
    std::printf("%s\n    {\"nodes\": %zu, \"tetrahedra\": %zu, \"median_ms\": %.2f, \"p99_ms\": %.2f}", comma, tissue.nodes.size(),
                tissue.tetrahedra.size(), t.median / 1000, t.p99 / 1000);
    comma = ",";
  }
  std::printf("],\n");
}

void leafTimes(FeltBlock& felt) {
  const Tissue& tissue = *felt.tissue;
  const tissue::TissueState state = felt.motion->restState();
  Field positions(tissue.surface.size());
  std::vector<Sphere> leaves(tissue.leaves.anchors.size());
  printTimes("refit", timesOf(2000, [&](int) {
               moveSurface(tissue, state.displacements, positions);
               moveLeaves(tissue, state.displacements, positions, leaves);
             }));
  // Far away from the tool: the cost in a step of a surface at rest, and of a moving one.
  reset(*felt.workspace);
  const Vector3d away(20, 20, 60);
  printTimes("step_free_at_rest", timesOf(2000, [&](int) { felt.step(away); }));
  std::vector<float> other = state.surface;
  for (std::size_t i = 2; i < other.size(); i += 3) other[i] += 5;
  printTimes("step_free_on_the_way",
             timesOf(2000,
                     [&](int i) {
                       if (i % 20 == 0) aimTissue(0, i % 40 == 0 ? other : state.surface, false, *felt.workspace);
                       felt.step(away);
                     }),
             "\n");
}

/// Pressed by 1 to 4 mm, and dragged.
void stepTimes(const SoftBlock& block, double friction, const char* name) {
  FeltBlock felt(block, friction);
  std::vector<double> times;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d p(20 + 8 * std::sin(0.004 * i), 20, kBlock.z() + kBall - 2 + 2 * std::cos(0.003 * i));
    felt.exchange();
    const double start = now();
    felt.step(p);
    times.push_back(now() - start);
  }
  std::printf("  \"%s\": {\"median_us\": %.1f, \"p99_us\": %.1f, \"p999_us\": %.1f},\n", name, tool::quantile(times, 0.5),
              tool::quantile(times, 0.99), tool::quantile(times, 0.999));
}

}  // namespace

int main() {
  const Cells usual{10, 10, 5}, fine{22, 22, 14};
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  std::printf("{\n");
  const SoftBlock block(usual, 2304);
  stepTimes(block, 0, "step_in_contact");
  stepTimes(block, 0.3, "step_with_friction");
  FeltBlock felt(block);
  std::printf("  \"leaves\": %zu,\n  \"nodes\": %zu,\n", felt.tissue->leaves.anchors.size(), felt.tissue->nodes.size());
  const runtime::StepResult r = felt.press();
  const Tissue& tissue = *felt.tissue;
  const double felt_volume = volumeOf(tissue, felt.motion->solver().displacements()) / (kBlock.x() * kBlock.y() * kBlock.z());
  std::printf("  \"felt_force_n\": %.4f,\n  \"felt_depth_mm\": %.4f,\n  \"felt_volume\": %.5f,\n", r.wrench.force.z(),
              kBlock.z() + kBall - r.graphic.position.z(), felt_volume);
  const auto print = [](const char* name, const Pressed& p) {
    std::printf("  \"%s_force_n\": %.4f,\n  \"%s_inside_mm\": %.4f,\n  \"%s_volume\": %.5f,\n", name, p.force, name, p.depth_left, name,
                p.volume_ratio);
  };
  print("nodes", pressNodes(usual));
  print("faces", pressFaces(usual));
  print("nodes_reference", pressNodes(fine));
  print("reference", pressFaces(fine));
  stateTimes();
  leafTimes(felt);
  std::printf("}\n");
  return 0;
}
