// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/label_pieces.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {
namespace {

struct Piece {
  std::int32_t label = 0;
  double area = 0;
};

struct Pieces {
  std::vector<std::uint32_t> of;  // vertex -> piece
  std::vector<Piece> all;         // by first vertex
};

Pieces piecesOf(const TriangleMesh& mesh, const std::vector<std::int32_t>& label, const std::vector<double>& vertex_area) {
  Groups groups(label.size());
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (label[t[k]] == label[t[(k + 1) % 3]]) groups.join(t[k], t[(k + 1) % 3]);
  Pieces pieces;
  pieces.of.assign(label.size(), 0);
  std::vector<std::uint32_t> number(label.size(), kNone);
  for (std::uint32_t v = 0; v < label.size(); ++v) {
    const std::uint32_t root = groups.root(v);
    if (number[root] == kNone) {
      number[root] = static_cast<std::uint32_t>(pieces.all.size());
      pieces.all.push_back({label[v], 0});
    }
    pieces.of[v] = number[root];
    pieces.all[number[root]].area += vertex_area[v];
  }
  return pieces;
}

/// One round: merges every piece that is too small, the smallest first, unless a neighbour changed in this round.
bool joinIslands(const TriangleMesh& mesh, const Pieces& pieces, double min_area, std::vector<std::int32_t>& label, std::size_t& islands) {
  std::map<std::uint32_t, std::map<std::uint32_t, double>> borders;  // of small pieces: border length with each neighbour
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], p = pieces.of[a], q = pieces.of[b];
      if (p == q) continue;
      const double length = (mesh.positions[a] - mesh.positions[b]).norm();
      if (pieces.all[p].area < min_area) borders[p][q] += length;
      if (pieces.all[q].area < min_area) borders[q][p] += length;
    }
  std::vector<std::uint32_t> order;
  for (const auto& [piece, unused] : borders) order.push_back(piece);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return pieces.all[a].area < pieces.all[b].area; });
  std::vector<std::int32_t> now(pieces.all.size());
  for (std::size_t p = 0; p < now.size(); ++p) now[p] = pieces.all[p].label;
  std::vector<char> is_touched(pieces.all.size(), 0);
  bool is_any = false;
  for (const std::uint32_t p : order) {
    if (is_touched[p]) continue;
    std::map<std::int32_t, double> by_label;
    for (const auto& [q, length] : borders[p]) by_label[now[q]] += length;
    const auto longest =
        std::max_element(by_label.begin(), by_label.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    now[p] = longest->first;
    for (const auto& [q, length] : borders[p]) is_touched[q] = 1;
    is_any = true;
    ++islands;
  }
  for (std::size_t v = 0; v < label.size(); ++v) label[v] = now[pieces.of[v]];
  return is_any;
}

}  // namespace

LabelPieces findLabelPieces(const TriangleMesh& mesh, std::vector<std::int32_t> label, double min_area) {
  std::vector<double> vertex_area(label.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) vertex_area[v] += triangleArea(mesh, t) / 3;
  LabelPieces out;
  const std::vector<std::int32_t> old_label = label;
  Pieces pieces = piecesOf(mesh, label, vertex_area);
  while (joinIslands(mesh, pieces, min_area, label, out.islands)) pieces = piecesOf(mesh, label, vertex_area);

  std::vector<std::uint32_t> order(pieces.all.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Piece &p = pieces.all[a], &q = pieces.all[b];
    return p.label != q.label ? p.label < q.label : p.area > q.area;
  });
  out.region_label = {0};
  out.region_piece = {1};
  std::vector<std::int32_t> region_of(pieces.all.size(), kGumRegion);
  for (const std::uint32_t p : order) {
    const Piece& piece = pieces.all[p];
    if (piece.label == 0 || !(piece.area > 0)) continue;  // gum, or a vertex without triangles
    const bool is_first = out.region_label.back() != piece.label;
    region_of[p] = static_cast<std::int32_t>(out.region_label.size());
    out.region_piece.push_back(is_first ? 1 : out.region_piece.back() + 1);
    out.region_label.push_back(piece.label);
  }
  for (const std::uint32_t p : pieces.of) out.region.push_back(region_of[p]);
  for (std::size_t v = 0; v < label.size(); ++v) out.is_island.push_back(label[v] != old_label[v]);
  return out;
}

}  // namespace spheretree::builder
