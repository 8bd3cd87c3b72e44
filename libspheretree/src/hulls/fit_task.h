// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit of hulls has to cover: the triangles of a mesh, cut to pieces about as large as the balls below them, and
// samples of these. docs/algorithms/hulls/fit_hulls.md
// Units: mm, frame of the mesh.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/ball.h"
#include "certify/triangle_piece.h"
#include "geometry/distance_field.h"
#include "hulls/hull_cover.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr double kAccuracy = 0.02;  // of the overhang of a hull, as a share of the tolerance

struct FitSettings {
  double tolerance = 0;       // > 0: of the overhang [mm]
  double rounding = 0;        // share of the tolerance that is left for rounding the hulls [mm]
  std::size_t max_hulls = 0;  // 1 or more

  double accuracy() const { return kAccuracy * tolerance; }  // to which the overhang of a hull is proven [mm]
  double margin() const { return accuracy() + rounding; }    // how deep a point has to lie in a hull to count as held [mm]
};

/// A point of the surface.
struct FitSample {
  Eigen::Vector3d point, normal;  // unit, outward
  double cost = kInfinity;        // how far the best hull has to grow to hold it, plus the overhang of that hull [mm]
};

class FitTask {
 public:
  /// Cuts the triangles. All but the settings must outlive the task.
  FitTask(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress);

  /// More samples where the surface is more curved; every second is a corner.
  std::vector<FitSample> samples() const;
  /// A sample of each piece that the hulls do not hold, at a place that they do not, and these pieces.
  struct Bare {
    std::vector<FitSample> samples{};
    std::vector<Piece> pieces{};
  };
  Bare bareOf(const HullCover& cover) const;
  /// Below the middle of a piece. Radius 0 if there is no ball that leaves at most `gap` > 0 [mm].
  Ball ballBelowPiece(const Piece& piece, double gap) const;

  const TriangleMesh& mesh;
  const DistanceField& field;  // of the solid
  FitSettings settings;
  Progress& progress;

 private:
  struct CutPiece {
    Piece piece;
    double samples;  // that it should have
  };
  std::vector<CutPiece> cutTriangle(const Piece& triangle) const;

  std::vector<CutPiece> pieces_;
};

}  // namespace spheretree::builder
