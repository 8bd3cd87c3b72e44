// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/soften_items.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <span>
#include <stdexcept>

#include "pipeline/tissue/fill_body.h"
#include "pipeline/tissue/fixed_regions.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/builder/soften_tree.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/tissue_codec.h"

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

constexpr double kSeconds = 60;                                 // time limit for each run of the child
constexpr const char* kSoftSchema = "spheretree.batch-soft/2";  // version of the data under a key in the cache

/// The fixed nodes of an item: in a region of the world, or in the leaves of another item.
class Fixed {
 public:
  Fixed(const BatchItem& item, const std::vector<BatchItem>& items) : pose_(item.source->pose) {
    for (const formats::FixedRegion& region : item.source->soft->fixed) {
      if (!region.inside.empty()) {
        addLeavesOf(region.inside, items);
      } else if (region.region.shape == formats::WorkRegion::Shape::Sphere) {
        balls_.push_back({region.region.centre_mm, region.region.radius_mm});
      } else {
        boxes_.emplace_back(region.region.low_mm, region.region.high_mm);
      }
    }
  }

  bool holds(const Vector3d& in_mesh) const {
    const Vector3d p = pose_.orientation * in_mesh + pose_.position;
    return std::any_of(balls_.begin(), balls_.end(), [&](const WorldBall& b) { return (p - b.centre).norm() <= b.radius; }) ||
           std::any_of(boxes_.begin(), boxes_.end(), [&](const Eigen::AlignedBox3d& box) { return box.contains(p); });
  }

  /// Visits everything on which holds() depends.
  template <class Visit>
  void visitNumbers(const Visit& visit) const {
    const auto point = [&](const Vector3d& p) { visit(p.x()), visit(p.y()), visit(p.z()); };
    point(pose_.position);
    point(pose_.orientation.vec());
    visit(pose_.orientation.w());
    for (const WorldBall& b : balls_) point(b.centre), visit(b.radius);
    for (const Eigen::AlignedBox3d& box : boxes_) point(box.min()), point(box.max());
  }

 private:
  struct WorldBall {
    Vector3d centre;
    double radius;
  };

  void addLeavesOf(const std::string& name, const std::vector<BatchItem>& items) {
    const auto other = std::find_if(items.begin(), items.end(), [&](const BatchItem& i) { return i.source->name == name && !i.is_tool; });
    if (other == items.end() || !other->hasTree())
      throw builder::BuildError("soft: the scene has no tree of \"" + name + "\", in which the body is fixed");
    FixedRegions leaves;
    addLeaves(other->result.tree, leaves);
    const Configuration& pose = other->source->pose;
    for (const Sphere& s : leaves.balls)
      balls_.push_back({pose.orientation * Eigen::Vector3f(s.x, s.y, s.z).cast<double>() + pose.position, static_cast<double>(s.radius)});
  }

  Configuration pose_;
  std::vector<WorldBall> balls_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

std::string noteOf(const Tissue& tissue) {
  char text[160];
  std::snprintf(text, sizeof text, "%s%zu tetrahedra, %zu of %zu nodes fixed%s", kSoftNote, tissue.tetrahedra.size(), tissue.fixed.size(),
                tissue.nodes.size(), tissue.response.empty() ? "; too many nodes for players" : "");
  return text;
}

/// The hash of everything on which the soft tree of an item depends.
std::string keyOf(const BatchItem& item, const Fixed& fixed) {
  const formats::SoftSettings& soft = *item.source->soft;
  std::string text = std::string(kSoftSchema) + "\n" + item.job.key();
  const auto add = [&](double x) {
    char number[32];
    text.append("\n").append(number, std::to_chars(number, number + sizeof number, x).ptr);
  };
  for (const double x : {soft.young_kpa, soft.poisson, soft.density_kg_m3, static_cast<double>(soft.tetrahedra)}) add(x);
  fixed.visitNumbers(add);
  return toHex(builder::bytesHash(std::as_bytes(std::span(text))));
}

std::vector<std::byte> softened(const BatchItem& item, const Fixed& fixed, builder::Progress& progress) {
  const formats::SoftSettings& soft = *item.source->soft;
  const builder::RepairedMesh repaired = item.job.solid(progress);
  const FilledBody body = fillBody(repaired.mesh, soft.tetrahedra, kSeconds, progress);
  const Tissue tissue = builder::softenTree(
      joined(repaired.mesh, repaired.to_cover), item.result.tree, body.boundary, body.tetrahedra,
      {soft.young_kpa, soft.poisson, soft.density_kg_m3}, [&](const Vector3d& p) { return fixed.holds(p); }, progress);
  return encodeSoftTree(item.result.tree, tissue);
}

void soften(BatchItem& item, const std::vector<BatchItem>& items, const TreeCache& cache, builder::Progress& progress) {
  const Fixed fixed(item, items);
  const std::string key = keyOf(item, fixed);
  item.soft = cache.findSoft(key);
  if (item.soft.empty()) {
    item.soft = softened(item, fixed, progress);
    cache.prepare();
    cache.storeSoft(key, item.soft);
  }
  SphereTree tree;
  Tissue tissue;
  if (decodeSoftTree(item.soft, tree, tissue) == LoadStatus::Ok) item.result.figures.notes.push_back(noteOf(tissue));
}

}  // namespace

void softenItems(std::vector<BatchItem>& items, const TreeCache& cache, builder::Progress& progress) {
  for (BatchItem& item : items) {
    if (!item.source->soft || !item.hasTree()) continue;
    progress.check();
    try {
      soften(item, items, cache, progress);
    } catch (const builder::BuildError& error) {
      item.status = ItemStatus::Failed;
      item.error = error.what();
    } catch (const std::invalid_argument& error) {  // a material out of range
      item.status = ItemStatus::Failed;
      item.error = error.what();
    }
  }
}

}  // namespace spheretree::pipeline
