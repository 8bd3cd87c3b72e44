// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/inner_spheres.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace spheretree::player {
namespace {

constexpr double kPlaces = 60'000;  // grid points over the bounding box
constexpr double kSmallest = 1e-3;  // as a share of the diagonal
constexpr int kPrototypeSteps = 12;

class Packing {
 public:
  Packing(const Body& body, InnerSpheres& out) : field_(body.field), out_(out) {
    const Eigen::Vector3d size = field_.box().sizes();
    cell_ = std::cbrt(size.prod() / kPlaces);
    std::array<std::size_t, 3> n{};
    for (std::size_t k = 0; k < 3; ++k) n[k] = static_cast<std::size_t>(std::ceil(size[static_cast<Eigen::Index>(k)] / cell_));
    std::vector<double> depth(n[0] * n[1] * n[2]);
    const auto placeOf = [&](std::size_t i) -> Eigen::Vector3d {
      return field_.box().min() + cell_ * Eigen::Vector3d(static_cast<double>(i % n[0]) + 0.5, static_cast<double>(i / n[0] % n[1]) + 0.5,
                                                          static_cast<double>(i / n[0] / n[1]) + 0.5);
    };
    tbb::parallel_for(std::size_t{0}, depth.size(), [&](std::size_t i) { depth[i] = -field_.signedDistance(placeOf(i)); });
    for (std::size_t i = 0; i < depth.size(); ++i)
      if (depth[i] > 0) places_.push_back({placeOf(i), depth[i]});
  }

  void fill(std::size_t count) {
    const double smallest = kSmallest * field_.diagonal();
    while (out_.centre.size() < count && !places_.empty()) {
      const auto best = std::max_element(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.room < b.room; });
      if (best->room < smallest) return;
      place(*best);
    }
  }

 private:
  struct Place {
    Eigen::Vector3d at;
    double room;  // radius of the largest free sphere about it
  };

  /// The free radius at p, and the direction in which it grows: away from the nearest obstacle.
  double roomAt(const Eigen::Vector3d& p, Eigen::Vector3d& away) const {
    builder::NearestPoint nearest;
    double room = -field_.signedDistance(p, &nearest);
    away = p - nearest.point;
    for (std::size_t i = 0; i < out_.centre.size(); ++i)
      if (const Eigen::Vector3d from = p - out_.centre[i]; from.squaredNorm() < (room + out_.radius[i]) * (room + out_.radius[i])) {
        room = from.norm() - out_.radius[i];
        away = from;
      }
    return room;
  }

  void place(Place best) {
    Eigen::Vector3d away, at = best.at;
    double room = roomAt(at, away), step = cell_;
    for (int n = 0; n < kPrototypeSteps && away.norm() > 0; ++n) {
      const Eigen::Vector3d next = at + step * away.normalized();
      Eigen::Vector3d next_away;
      if (const double more = roomAt(next, next_away); more > room)
        at = next, room = more, away = next_away;
      else
        step *= 0.5;
    }
    if (room > 0) {
      out_.centre.push_back(at);
      out_.radius.push_back(room);
    }
    std::erase_if(places_, [&](Place& p) {
      p.room = room > 0 ? std::min(p.room, (p.at - at).norm() - room) : p.room;
      return p.room <= 0 || (room <= 0 && p.at == best.at);
    });
  }

  const builder::DistanceField& field_;
  InnerSpheres& out_;
  double cell_ = 0;
  std::vector<Place> places_;
};

}  // namespace

InnerSpheres::InnerSpheres(const Body& body, std::size_t count) {
  Packing(body, *this).fill(count);
  tree = BallTree(centre, radius);
}

}  // namespace spheretree::player
