// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/exact_tool.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
using Rows = std::span<const std::pair<Scaled, double>>;

constexpr double kLongest = 0.05;  // largest motion of a point in a move: linearised gaps are good to a few um [mm]
constexpr double kArrived = 1e-7;  // a shorter move is none [mm]
constexpr double kSmooth = 0.87;   // cosine of the angle between faces, below which their edge is sharp
constexpr int kAlongEdges = 10;    // points of a sharp edge for each spacing: something round would sink between fewer
constexpr int kMoves = 200, kCorrections = 12;

/// The combination of the columns of `e` with weights >= 0 that is nearest to `f`: NNLS.
Eigen::VectorXd nonNegativeLeastSquares(const Eigen::MatrixXd& e, const Eigen::VectorXd& f) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(e.cols());
  std::vector<Eigen::Index> in;
  for (int round = 0; round < 50 + 3 * static_cast<int>(e.cols()); ++round) {
    const Eigen::VectorXd slope = e.transpose() * (f - e * u);
    Eigen::Index best = -1;
    for (Eigen::Index k = 0; k < e.cols(); ++k)
      if (std::ranges::count(in, k) == 0 && slope[k] > 1e-12 && (best < 0 || slope[k] > slope[best])) best = k;
    if (best < 0) break;
    in.push_back(best);
    while (!in.empty()) {
      const Eigen::VectorXd z = e(Eigen::all, in).colPivHouseholderQr().solve(f);
      double share = 1;
      for (std::size_t i = 0; i < in.size(); ++i)
        if (const auto k = static_cast<Eigen::Index>(i); z[k] <= 0) share = std::min(share, u[in[i]] / (u[in[i]] - z[k]));
      for (std::size_t i = 0; i < in.size(); ++i) u[in[i]] += share * (z[static_cast<Eigen::Index>(i)] - u[in[i]]);
      const std::size_t before = in.size();
      std::erase_if(in, [&](Eigen::Index k) {
        if (u[k] > 1e-14) return false;
        u[k] = 0;
        return true;
      });
      if (in.size() == before) break;
    }
  }
  return u;
}

/// LDP for a few rows: the problem of the least distance is a problem of NNLS.
std::optional<Scaled> nearestOf(Rows rows, const std::vector<std::size_t>& chosen, const Scaled& target) {
  Eigen::MatrixXd e(7, static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const auto& [a, b] = rows[chosen[k]];
    e.col(static_cast<Eigen::Index>(k)) << a, b - a.dot(target);
  }
  Eigen::VectorXd f = Eigen::VectorXd::Zero(7);
  f[6] = 1;
  const Eigen::VectorXd rest = e * nonNegativeLeastSquares(e, f) - f;
  if (rest[6] > -1e-10) return std::nullopt;
  return Scaled(target - rest.head<6>() / rest[6]);
}

}  // namespace

SampledSolid::SampledSolid(const TriangleMesh& mesh, double spacing) : field(mesh) {
  std::set<std::array<long, 3>> taken;  // cells of half a spacing: a fine mesh has more vertices than are needed
  const auto add = [&](const Vector3d& p) {
    std::array<long, 3> cell;
    for (int k = 0; k < 3; ++k) cell[static_cast<std::size_t>(k)] = std::lround(2 * p[k] / spacing);
    if (taken.insert(cell).second) points.push_back(p);
  };
  const auto forInner = [](const Vector3d& a, const Vector3d& b, double step, const auto& visit) {
    const int n = static_cast<int>(std::ceil((b - a).norm() / step));
    for (int i = 1; i < n; ++i) visit(Vector3d(a + (b - a) * (static_cast<double>(i) / n)));
  };
  for (const Vector3d& p : mesh.positions) add(p);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d from = mesh.corner(t, static_cast<int>(k)), to = mesh.corner(t, static_cast<int>(k + 1) % 3);
      const std::uint32_t beyond = field.across(t, k);
      const bool is_sharp = beyond == builder::DistanceField::kNoTriangle || field.normal(t).dot(field.normal(beyond)) < kSmooth;
      if (is_sharp && t < beyond) forInner(from, to, spacing / kAlongEdges, [&](const Vector3d& p) { points.push_back(p); });
      if (!is_sharp) forInner(from, to, spacing, add);
    }
    forInner(a, b, spacing, [&](const Vector3d& p) {
      const Vector3d q = a + (c - a) * ((p - a).norm() / (b - a).norm());  // on the side from a to c, as far along it
      forInner(p, q, spacing, add);
    });
  }
}

ToolGaps::ToolGaps(const SampledSolid& tool, const SampledSolid& body, const Vector3d& reference)
    : tool_(tool), body_(body), reference_(reference), reached_(tool.points.size() + body.points.size(), 0) {
  for (const Vector3d& p : tool.points) reach_ = std::max(reach_, (p - reference).norm());
}

std::span<const NearPlace> ToolGaps::near(const Configuration& pose, double margin) {
  if (last_) {
    const Displacement way = displacementBetween(*last_, pose);
    travelled_ += way.translation.norm() + reach_ * way.rotation.norm();
  }
  last_ = pose;
  places_.clear();
  const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
  // The distance of `p` from the surface of `field`, and the unit vector from there to `p`.
  const auto test = [&](std::size_t at, const builder::DistanceField& field, const Vector3d& p, Vector3d& out) {
    builder::NearestPoint nearest;
    const double gap = field.signedDistance(p, &nearest);
    reached_[at] = travelled_ + gap;
    if (gap > margin) return gap;
    out = nearest.distance > 1e-6 ? Vector3d((p - nearest.point) / gap) : field.pseudonormal(nearest);
    return gap;
  };
  Vector3d normal;
  for (std::size_t i = 0; i < tool_.points.size(); ++i) {
    if (reached_[i] > travelled_ + margin) continue;
    const Vector3d p = pose.position + turn * (tool_.points[i] - reference_);
    if (const double gap = test(i, body_.field, p, normal); gap <= margin) places_.push_back({p, normal, gap});
  }
  for (std::size_t i = 0; i < body_.points.size(); ++i) {
    const std::size_t at = tool_.points.size() + i;
    if (reached_[at] > travelled_ + margin) continue;
    if (const double least = (body_.points[i] - pose.position).norm() - reach_; least > margin) {  // no need to know more
      reached_[at] = travelled_ + least;
      continue;
    }
    const Vector3d p = reference_ + turn.transpose() * (body_.points[i] - pose.position);
    if (const double gap = test(at, tool_.field, p, normal); gap <= margin) places_.push_back({body_.points[i], -(turn * normal), gap});
  }
  return places_;
}

double ToolGaps::smallest(const Configuration& pose, double margin) {
  double least = margin;
  for (const NearPlace& place : near(pose, margin)) least = std::min(least, place.gap);
  return least;
}

std::optional<Scaled> nearestWithin(Rows rows, const Scaled& target) {
  std::vector<std::size_t> chosen;
  Scaled y = target;
  for (;;) {
    std::size_t worst = 0;
    double violation = 1e-10;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (const double v = rows[i].second - rows[i].first.dot(y); v > violation) violation = v, worst = i;
    if (violation == 1e-10 || std::ranges::count(chosen, worst) > 0) return y;
    chosen.push_back(worst);
    const std::optional<Scaled> next = nearestOf(rows, chosen, target);
    if (!next) return std::nullopt;
    y = *next;
  }
}

ExactTool::ExactTool(const SampledSolid& tool, const SampledSolid& body, const Vector3d& reference, const runtime::Coupling& coupling,
                     const Configuration& start)
    : gaps_(tool, body, reference), angle_length_(std::sqrt(coupling.rotation / coupling.translation)), at_(start) {}

// A move of at most `longest` along `way`, as far as the rows allow, then corrections until nothing penetrates.
// `moved`: how far the first would be without the limit.
std::optional<Configuration> ExactTool::moveBy(const Scaled& way, double longest, double& moved) {
  Configuration pose = at_;
  std::vector<std::pair<Scaled, double>> rows;
  for (int n = 0; n < kCorrections; ++n) {
    rows.clear();
    double deepest = 0;
    for (const NearPlace& place : gaps_.near(pose, 3 * kLongest)) {
      Scaled a;
      a << place.normal, (place.point - pose.position).cross(place.normal) / angle_length_;
      rows.emplace_back(a, kExactGap - place.gap);
      deepest = std::max(deepest, kExactGap - place.gap);
    }
    if (n > 0 && deepest < 1e-6) return pose;
    std::optional<Scaled> y = nearestWithin(rows, n == 0 ? way : Scaled(Scaled::Zero()));
    if (!y) return std::nullopt;
    const double reach = y->head<3>().norm() + gaps_.reach() * y->tail<3>().norm() / angle_length_;
    if (n > 0 && reach > kLongest) return std::nullopt;
    if (n == 0) moved = y->norm(), *y *= std::min(1.0, longest / reach);  // the rows hold for a part of it as well
    pose = spheretree::moved(pose, {y->head<3>(), y->tail<3>() / angle_length_});
  }
  return std::nullopt;
}

const Configuration& ExactTool::follow(const Configuration& hand) {
  double longest = kLongest;
  const auto wayFrom = [&](const Configuration& pose) {
    const Displacement d = displacementBetween(pose, hand);
    Scaled way;
    way << d.translation, angle_length_ * d.rotation;
    return way;
  };
  for (int n = 0; n < kMoves && longest > kArrived; ++n) {
    const Scaled way = wayFrom(at_);
    double moved = 0;
    const std::optional<Configuration> next = moveBy(way, longest, moved);
    if (next && wayFrom(*next).norm() < way.norm() - 1e-10) {
      at_ = *next;
      if (moved < 1e-6) break;
    } else {
      if (next && moved < kArrived) break;
      longest /= 2;
    }
  }
  return at_;
}

}  // namespace spheretree::player
