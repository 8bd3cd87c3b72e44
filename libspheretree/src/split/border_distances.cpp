// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/border_distances.h"

#include <algorithm>
#include <array>
#include <queue>
#include <utility>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kAlone = 0.35;   // a vertex stands alone if at most this share of its neighbours has its label
constexpr double kJagged = 0.08;  // labels of a region are jagged if more than this share of the vertices at its border stands alone

/// Vertices and their distances [mm].
using Seeds = std::vector<std::pair<std::uint32_t, double>>;

double distanceToSegment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d way = b - a;
  const double length2 = way.squaredNorm(), t = length2 > 0 ? std::clamp((p - a).dot(way) / length2, 0.0, 1.0) : 0;
  return (p - a - t * way).norm();
}

class Finder {
 public:
  Finder(const ScanSurface& surface, const VertexNeighbours& neighbours, double smooth)
      : s_(surface),
        mesh_(surface.mesh),
        smooth_(smooth),
        regions_(surface.vertex_region),
        neighbours_(neighbours),
        passed_(surface.mesh.positions.size(), 0) {}

  BorderDistances run() {
    findDistances();
    centreJagged();
    return std::move(out_);
  }

 private:
  void findDistances() {
    double length = 0;
    std::size_t edges = 0;
    for (const Triangle& t : mesh_.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        if (regions_[t[k]] != regions_[t[(k + 1) % 3]]) {
          length += (mesh_.positions[t[k]] - mesh_.positions[t[(k + 1) % 3]]).norm();
          ++edges;
        }
    edge_ = edges > 0 ? length / static_cast<double>(edges) : 0;
    out_.band = kSmoothingRounds * std::max(smooth_, edge_);
    std::vector<Seeds> seeds(s_.region_label.size());
    for (const Triangle& t : mesh_.triangles) {
      if (regions_[t[0]] == regions_[t[1]] && regions_[t[1]] == regions_[t[2]]) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t region = regions_[t[k]];
        if (k > 0 && (region == regions_[t[0]] || (k == 2 && region == regions_[t[1]]))) continue;
        addSeeds(
            t, [&](std::uint32_t v) { return regions_[v] == region; }, seeds[static_cast<std::size_t>(region)]);
      }
    }
    out_.of_vertex.assign(mesh_.positions.size(), {});
    within_.resize(seeds.size());
    for (std::size_t r = 0; r < seeds.size(); ++r) {
      const auto region = static_cast<std::int32_t>(r);
      within_[r] = spread(seeds[r], [&](std::uint32_t v) { return regions_[v] == region; });
      for (const auto& [v, d] : within_[r]) out_.of_vertex[v].push_back({region, d});
    }
  }

  void centreJagged() {
    std::vector<char> is_alone(mesh_.positions.size(), 0);
    for (std::uint32_t v = 0; v < is_alone.size(); ++v) {
      const auto around = neighbours_.of(v);
      const auto same =
          std::count_if(around.begin(), around.end(), [&](std::uint32_t u) { return regions_[u] == regions_[v] && !isDoubtful(u); });
      is_alone[v] = isDoubtful(v) || static_cast<double>(same) < kAlone * static_cast<double>(around.size());
    }
    std::vector<double> gum_shift(mesh_.positions.size(), 0), nearest(mesh_.positions.size(), -out_.band);
    for (std::size_t r = 1; r < within_.size(); ++r) {
      const auto region = static_cast<std::int32_t>(r);
      if (!isJagged(region, is_alone)) continue;
      const std::vector<double> shift = shiftToCentre(region);
      for (std::size_t i = 0; i < shift.size(); ++i) {
        const std::uint32_t v = within_[r][i].first;
        for (RegionDistance& k : out_.of_vertex[v]) {
          if (k.region != region) continue;
          k.distance += shift[i];
          if (k.distance > nearest[v]) nearest[v] = k.distance, gum_shift[v] = -shift[i];
        }
      }
    }
    for (const auto& [v, unused] : within_[kGumRegion])
      for (RegionDistance& k : out_.of_vertex[v])
        if (k.region == kGumRegion) k.distance += gum_shift[v];
  }

  bool isDoubtful(std::uint32_t v) const { return v < s_.is_doubtful.size() && s_.is_doubtful[v]; }

  bool isJagged(std::int32_t region, const std::vector<char>& is_alone) const {
    std::size_t border = 0, alone = 0;
    for (const auto& [v, unused] : within_[static_cast<std::size_t>(region)]) {
      const auto around = neighbours_.of(v);
      const bool is_in = regions_[v] == region;
      if (std::none_of(around.begin(), around.end(), [&](std::uint32_t u) { return (regions_[u] == region) != is_in; })) continue;
      ++border;
      alone += is_alone[v];
    }
    return static_cast<double>(alone) > kJagged * static_cast<double>(border);
  }

  /// How much the distance of each vertex in the band of a region changes if its border is put into the middle [mm].
  std::vector<double> shiftToCentre(std::int32_t region) {
    enum : char { kDoubt, kIn, kOut };
    const Seeds& within = within_[static_cast<std::size_t>(region)];
    std::vector<char> state(mesh_.positions.size(), kDoubt), is_within(mesh_.positions.size(), 0);
    for (const auto& [v, unused] : within) {
      const bool is_in = regions_[v] == region;
      const auto around = neighbours_.of(v);
      const bool is_certain = !isDoubtful(v) && std::none_of(around.begin(), around.end(), [&](std::uint32_t u) {
        return isDoubtful(u) || (regions_[u] == region) != is_in;
      });
      state[v] = !is_certain ? kDoubt : is_in ? kIn : kOut;
      is_within[v] = 1;
    }
    std::vector<double> sum(mesh_.positions.size(), 0);
    std::vector<char> count(mesh_.positions.size(), 0);
    for (const char set : {char(kIn), char(kOut)}) {
      const auto isIn = [&](std::uint32_t v) { return state[v] == set; };
      Seeds seeds;
      for (const Triangle& t : mesh_.triangles)
        if (is_within[t[0]] && is_within[t[1]] && is_within[t[2]]) addSeeds(t, isIn, seeds);
      for (const auto& [v, d] : spread(seeds, isIn)) sum[v] += (set == kIn ? d : -d) / 2, ++count[v];
    }
    std::vector<double> shift;
    for (const auto& [v, d] : within) shift.push_back(count[v] == 2 ? std::clamp(sum[v] - d, -edge_, edge_) : 0);
    return shift;
  }

  /// If the border of a set passes through a triangle, adds the distances of its corners to it.
  template <class IsIn>
  void addSeeds(const Triangle& t, const IsIn& isIn, Seeds& seeds) const {
    std::array<Vector3d, 2> cut;
    std::size_t cuts = 0;
    for (std::size_t e = 0; e < 3; ++e)
      if (isIn(t[e]) != isIn(t[(e + 1) % 3])) cut[cuts++] = (mesh_.positions[t[e]] + mesh_.positions[t[(e + 1) % 3]]) / 2;
    if (cuts == 2)
      for (const std::uint32_t v : t) seeds.emplace_back(v, distanceToSegment(mesh_.positions[v], cut[0], cut[1]));
  }

  /// Signed distances to the border of a set, positive within it, of the vertices in the band around its seeds; in
  /// ascending order of their amounts.
  template <class IsIn>
  Seeds spread(const Seeds& seeds, const IsIn& isIn) {
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const auto& [v, d] : seeds) queue.emplace(d, v);
    Seeds out;
    ++pass_;
    while (!queue.empty()) {
      const auto [d, v] = queue.top();
      queue.pop();
      if (passed_[v] == pass_) continue;
      passed_[v] = pass_;
      out.emplace_back(v, isIn(v) ? d : -d);
      for (const std::uint32_t u : neighbours_.of(v)) {
        const double next = d + (mesh_.positions[u] - mesh_.positions[v]).norm();
        if (isIn(u) == isIn(v) && next < out_.band) queue.emplace(next, u);
      }
    }
    return out;
  }

  const ScanSurface& s_;
  const TriangleMesh& mesh_;
  double smooth_, edge_ = 0;  // the mean edge at the border
  const std::vector<std::int32_t>& regions_;
  const VertexNeighbours& neighbours_;
  BorderDistances out_;
  std::vector<Seeds> within_;  // of each region, the signed distances of the vertices in its band
  std::vector<std::uint32_t> passed_;
  std::uint32_t pass_ = 0;
};

}  // namespace

BorderDistances findBorderDistances(const ScanSurface& surface, const VertexNeighbours& neighbours, double smooth) {
  return Finder(surface, neighbours, smooth).run();
}

}  // namespace spheretree::builder
