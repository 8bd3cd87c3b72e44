// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "quantile.h"
#include "scenarios/parallel_jobs.h"
#include "scenarios/scenario_run.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 1;     // of the ball
constexpr double kPressed = 0.5;  // depth of the hand below the offset surface [mm]
constexpr double kPace = 0.02;    // motion in a step: 20 mm/s [mm]

struct Size {
  int levels;
  std::size_t leaves;  // at most
};
constexpr std::array<Size, 4> kSizes{{{2, 8}, {3, 64}, {4, 512}, {5, 4096}}};

struct Course {
  std::string name, body;
  Vector3d place;              // origin of the body's mesh frame
  std::vector<Vector3d> hand;  // world frame, one position for each step; the first is free
};

/// Appends positions up to `to`, one for each step.
void lineTo(std::vector<Vector3d>& path, const Vector3d& to) {
  const Vector3d from = path.back();
  const int steps = std::max(1, static_cast<int>((to - from).norm() / kPace));
  for (int n = 1; n <= steps; ++n) path.push_back(from + (to - from) * (static_cast<double>(n) / steps));
}

Course overEdge() {
  const double r = kRadius - kPressed;
  Course course{"edge", "cube", {-10, 0, -10}, {{-3, 0, kRadius + 0.2}}};
  lineTo(course.hand, {-3, 0, r});
  lineTo(course.hand, {0, 0, r});
  for (int n = 1; n <= 40; ++n) {
    const double a = std::numbers::pi / 2 * n / 40;
    course.hand.emplace_back(r * std::sin(a), 0, r * std::cos(a));
  }
  lineTo(course.hand, {r, 0, -3});
  return course;
}

Course alongGroove() {
  const double z = 2 * kRadius - kPressed;  // the walls, 30 degrees from the vertical, meet at z = 0
  Course course{"groove", "groove", {0, 0, 0}, {{0, -5, 2 * kRadius + 0.2}}};
  lineTo(course.hand, {0, -5, z});
  for (int n = 1; n <= 500; ++n) course.hand.emplace_back(0.4 * std::sin(4 * std::numbers::pi * n / 500), -5 + 0.02 * n, z);
  return course;
}

Course roundBowl() {  // a hollow of radius 15 about (0, 0, 7)
  const auto at = [](double radius, double turn) -> Vector3d {
    return Vector3d(0, 0, 7) + radius * Vector3d(std::sin(0.3) * std::cos(turn), std::sin(0.3) * std::sin(turn), -std::cos(0.3));
  };
  Course course{"bowl", "bowl", {0, 0, 0}, {at(15 - kRadius - 0.2, 0)}};
  lineTo(course.hand, at(15 - kRadius + kPressed, 0));
  for (int n = 1; n <= 1000; ++n) course.hand.push_back(at(15 - kRadius + kPressed, 2 * std::numbers::pi * n / 1000));
  return course;
}

/// Around the crown: where rays from outside towards the axis reach the distance of the hand.
Course roundMolar(const Body& molar) {
  const Eigen::AlignedBox3d& box = molar.field.box();
  const Vector3d middle = box.center() + Vector3d(0, 0, 0.2 * box.sizes().z());
  const auto at = [&](double turn, double distance) {
    const Vector3d inward(-std::cos(turn), -std::sin(turn), 0);
    Vector3d p = middle - box.diagonal().norm() * inward;
    for (int n = 0; n < 200; ++n) {
      const double gap = molar.field.signedDistance(p) - distance;
      if (gap < 1e-4) break;
      p += gap * inward;
    }
    return p;
  };
  Course course{"molar", "tooth_46", {0, 0, 0}, {at(0, kRadius + 0.2)}};
  lineTo(course.hand, at(0, kRadius - kPressed));
  for (int n = 1; n <= 1500; ++n) course.hand.push_back(at(2 * std::numbers::pi * n / 1500, kRadius - kPressed));
  return course;
}

const Body& bodyOf(const ScenarioContext& context, const std::string& body, int levels, std::size_t leaves) {
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  settings.levels = levels;
  return context.bodies.make(body + "_" + std::to_string(leaves), BodyLibrary::mesh(body), settings);
}

ComparisonRow measure(const Body& ball, const Body& body, const Course& course, Mode mode, bool on_leaves, std::size_t leaves) {
  ScenarioRun::Options options;
  options.contact = on_leaves ? runtime::ContactSurface::Leaves : runtime::ContactSurface::Skin;
  ScenarioRun trial(ball, {{&body, {course.place, kUpright}}}, mode, options);
  ExactBall exact(body.field, kRadius, course.hand.front() - course.place);
  std::vector<double> errors, depths, angles, stand_offs;
  for (const Vector3d& hand : course.hand) {
    const runtime::StepResult result = trial.to({hand, kUpright});
    const Vector3d right = exact.follow(hand - course.place) + course.place;
    if ((right - hand).norm() < 1e-3) continue;  // not in contact
    errors.push_back((result.wrench.force - (right - hand) * runtime::Coupling{}.translation).norm());
    angles.push_back(degreesBetween(result.wrench.force, right - hand));
    const double gap = body.field.signedDistance(result.graphic.position - course.place) - kRadius;
    depths.push_back(std::max(0.0, -gap));
    stand_offs.push_back(std::abs(gap));
  }
  return {.mode = mode,
          .body = course.name,
          .on_leaves = on_leaves,
          .leaves = leaves,
          .bytes = trial.scene().byteCount(),
          .step_median = trial.times().quantile(0.5),
          .step_p99 = trial.times().quantile(0.99),
          .penetration = tool::quantile(depths, 0.99),
          .force_error = tool::quantile(errors, 0.5),
          .force_error_p99 = tool::quantile(errors, 0.99),
          .angle = tool::quantile(angles, 0.5),
          .angle_p99 = tool::quantile(angles, 0.99),
          .stand_off_p99 = tool::quantile(stand_offs, 0.99)};
}

}  // namespace

Vector3d ExactBall::outside(Vector3d p) const {
  for (int n = 0; n < 8; ++n) {
    builder::NearestPoint nearest;
    const double distance = field_.signedDistance(p, &nearest);
    if (distance >= radius_) break;
    const Vector3d way = p - nearest.point;
    const Vector3d out = way.norm() > 1e-9 ? Vector3d(way.normalized() * (distance < 0 ? -1 : 1)) : field_.pseudonormal(nearest);
    p += (radius_ - distance) * out;
  }
  return p;
}

const Vector3d& ExactBall::follow(const Vector3d& hand) {
  double step = 0.05;  // small, so that it cannot step through a wall
  for (int n = 0; n < 400 && step > 1e-6; ++n) {
    const Vector3d want = hand - at_;
    if (want.norm() < 1e-9) break;
    const Vector3d next = outside(at_ + want * std::min(1.0, step / want.norm()));
    if ((hand - next).norm() < want.norm() - 1e-9 && (next - at_).norm() < 3 * step)
      at_ = next;
    else
      step *= 0.5;
  }
  return at_;
}

std::vector<ComparisonRow> compareRenderers(const ScenarioContext& context, std::span<const Mode> modes, tool::WorkProgress& progress) {
  progress.stage("renderers");
  const std::vector<Course> courses{overEdge(), alongGroove(), roundBowl(), roundMolar(bodyOf(context, "tooth_46", 3, 64))};
  std::vector<Job> jobs;
  std::vector<std::vector<ComparisonRow>> rows_of(courses.size() * kSizes.size());
  for (std::size_t k = 0; k < rows_of.size(); ++k) {
    const Course& course = courses[k / kSizes.size()];
    const auto [levels, leaves] = kSizes[k % kSizes.size()];
    jobs.push_back({course.name + ", " + std::to_string(leaves) + " leaves",
                    [&course, levels, leaves, modes, &rows = rows_of[k]](ScenarioContext& own) {
                      const Body& ball = own.bodies.get("small_ball");
                      const Body& body = bodyOf(own, course.body, levels, leaves);
                      for (const Mode mode : modes) {
                        if (leaves < 64 && mode != Mode::Constrained) continue;
                        rows.push_back(measure(ball, body, course, mode, false, leaves));
                        if (mode == Mode::Constrained) rows.push_back(measure(ball, body, course, mode, true, leaves));
                        own.progress.check();
                      }
                    }});
  }
  runJobs(jobs, context, 1, progress);
  std::vector<ComparisonRow> rows;
  for (const std::vector<ComparisonRow>& more : rows_of) rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace spheretree::player
