// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_change.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/hull.h"

namespace spheretree::builder {

namespace {

constexpr double kWorse = 4;  // power of the cost of a hull in the energy

using Numbers = std::vector<std::uint32_t>;

bool contains(const Numbers& numbers, std::uint32_t i) { return std::ranges::find(numbers, i) != numbers.end(); }

class ChangeSearch {
 public:
  ChangeSearch(const HullComplex& complex, std::uint32_t from, double limit)
      : complex_(complex), limit_(limit), old_(complex.around(from)) {}

  HullChange run(std::uint32_t from, std::uint32_t to, const Ball& ball) {
    HullChange c{.from = from, .to = to, .ball = ball};
    c.made = madeBy(c);
    const Numbers near = nearOld();
    double cost = 0;
    for (const Simplex& s : c.made) offer(s), cost = std::max(cost, s.overhang);
    for (const std::uint32_t i : near) offer(complex_.simplices()[i]);
    for (const std::uint32_t i : old_)
      for (const std::uint32_t p : complex_.simplices()[i].samples) {
        const FitSample& sample = complex_.samples()[p];
        auto [best, least] = holderOf(sample.point);
        if (least > limit_ && sample.cost <= limit_) return c;
        if (least == kInfinity)
          least = sample.cost;
        else
          offers_[best].worst = std::max(offers_[best].worst, least);
        if (least > sample.cost) cost = std::max(cost, least);
        c.costs.push_back({p, least});
        if (best < c.made.size())
          c.made[best].samples.push_back(p);
        else
          c.kept.push_back({near[best - c.made.size()], p});
      }
    c.cost = cost;
    c.energy = 0;
    for (const Offer& o : offers_) c.energy += std::pow(o.worst / complex_.most(), kWorse);
    return c;
  }

 private:
  struct Offer {
    const Simplex* simplex;
    Eigen::AlignedBox3d box;  // around all points for which it costs at most the limit
    double worst;             // cost of its overhang and of the samples that it gets [mm]
  };
  void offer(const Simplex& s) { offers_.push_back({&s, boxOf(grownBy(s.hull, std::max(0.0, limit_ - s.overhang))), s.overhang}); }

  // The offer of least cost, and that.
  std::pair<std::size_t, double> holderOf(const Eigen::Vector3d& p) const {
    std::pair<std::size_t, double> best{0, kInfinity};
    for (std::size_t k = 0; k < offers_.size(); ++k) {
      if (!offers_[k].box.contains(p)) continue;
      if (const double cost = offers_[k].simplex->costOf(p); cost < best.second) best = {k, cost};
    }
    return best;
  }

  // The hulls that take the place of the old ones; none that lies in another.
  std::vector<Simplex> madeBy(const HullChange& c) const {
    const Numbers other = complex_.around(c.to);
    std::vector<Simplex> made;
    for (const std::uint32_t i : old_) {
      std::vector<NumberedBall> corners{{c.to, c.ball}};
      for (const std::uint32_t v : complex_.simplices()[i].corners())
        if (v != c.from && v != c.to) corners.push_back({v, complex_.balls()[v]});
      for (const Simplex& s : simplicesOf(complex_.task().field, corners, limit_)) {
        const auto holdsIt = [&](const Simplex& m) { return s.isIn(m); };
        if (std::ranges::any_of(made, holdsIt)) continue;
        if (std::ranges::any_of(other, [&](std::uint32_t k) { return !contains(old_, k) && holdsIt(complex_.simplices()[k]); })) continue;
        std::erase_if(made, [&](const Simplex& m) { return m.isIn(s); });
        made.push_back(s);
      }
    }
    return made;
  }

  // Simplices that share a ball with an old one.
  Numbers nearOld() const {
    Numbers near;
    for (const std::uint32_t i : old_)
      for (const std::uint32_t v : complex_.simplices()[i].corners())
        for (const std::uint32_t k : complex_.around(v))
          if (!contains(old_, k) && !contains(near, k)) near.push_back(k);
    return near;
  }

  const HullComplex& complex_;
  double limit_;
  Numbers old_;  // simplices that go
  std::vector<Offer> offers_{};
};

}  // namespace

HullChange collapseOf(const HullComplex& complex, std::uint32_t from, std::uint32_t to, double limit) {
  return ChangeSearch(complex, from, limit).run(from, to, complex.balls()[to]);
}

HullChange moveOf(const HullComplex& complex, std::uint32_t from, const Ball& ball, double limit) {
  return ChangeSearch(complex, from, limit).run(from, static_cast<std::uint32_t>(complex.balls().size()), ball);
}

}  // namespace spheretree::builder
