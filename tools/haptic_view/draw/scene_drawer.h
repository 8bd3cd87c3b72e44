// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a stage and the state of its tool. Balls are ray-cast in the fragment shader, so that they are round at any
// size and intersect surfaces correctly. Everything of the stage is uploaded to the graphics card once.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "draw/camera.h"
#include "draw/cut_drawer.h"
#include "draw/gl.h"
#include "draw/look.h"
#include "draw/shapes.h"
#include "model/stage.h"

namespace spheretree::view {

/// The arrow of the force on the hand: from the graphic tool at its reference point, with a length of arrowShare()
/// times 150 pixels.
struct ForceArrow {
  Eigen::Vector3d from, along;
  double newtons;
};
/// `pixel`: size of a screen pixel, in pixels of the viewport. Empty below 0.1 N.
std::optional<ForceArrow> forceArrow(const ShownState& state, const Camera& camera, const Viewport& viewport, double pixel);

class SceneDrawer {
 public:
  /// `stage` must outlive the object. @throws ViewError
  SceneDrawer(const Gl& gl, const Stage& stage);
  ~SceneDrawer();
  SceneDrawer(const SceneDrawer&) = delete;
  SceneDrawer& operator=(const SceneDrawer&) = delete;

  /// Draws into the bound framebuffer, which is `frame_height` pixels high; `viewport` is relative to its upper left
  /// corner. `pixel`: number of its pixels in one screen pixel. Changes the viewport and the scissor of OpenGL.
  void draw(const Camera& camera, const Look& look, const ShownState& state, const Viewport& viewport, int frame_height, double pixel);

  const Stage& stage() const { return stage_; }

 private:
  struct Triangles;
  struct BodyBuffers;
  struct Programs;
  struct CutPrograms;
  struct Pass;  // data that all draw calls of a picture share
  /// The surface that `geometry` shows; null if it shows spheres.
  const Triangles* shownSurface(const Pass& pass, std::size_t body, Geometry geometry) const;
  void drawBody(const Pass& pass, std::size_t body, const Configuration& pose, Geometry geometry, Colour colour, bool own_colours);
  void drawSurface(const Pass& pass, const Triangles& triangles, const Configuration& pose, Colour colour);
  void drawBalls(const Pass& pass, std::size_t body, std::size_t level, bool bounds, const Configuration& pose, Colour tint);
  /// What `draw` draws, translucent.
  template <class Draw>
  void drawGlass(const Pass& pass, double opacity, Draw&& draw);
  void drawObject(const Pass& pass, std::size_t object);
  void drawCut(const Pass& pass, std::size_t object, const CutSurface& cut, const Triangles& triangles, const Configuration& pose,
               Colour colour);
  void drawShapes(const Pass& pass, const Shapes& shapes, bool ghosts);
  Shapes marks(const Pass& pass) const;

  const Gl& gl_;
  const Stage& stage_;
  std::unique_ptr<Programs> programs_;
  std::vector<std::unique_ptr<BodyBuffers>> bodies_;
  std::unique_ptr<CutPrograms> cut_programs_;    // null: no object can be cut
  std::vector<std::unique_ptr<CutDrawer>> cut_;  // (object) null: it cannot be cut
  VertexArray empty_, shape_array_;
  GlBuffer shape_buffer_;
};

/// A picture of `width` x `height` pixels, drawn at a higher resolution and averaged, so that edges are smooth.
class Screen {
 public:
  explicit Screen(const Gl& gl) : gl_(gl) {}
  /// Binds the framebuffer to draw into, with `samples` x `samples` pixels for each pixel of the picture; 1, 2 or 4.
  void begin(int width, int height, int samples);
  int frameHeight() const { return frame_->height(); }
  int samples() const { return samples_; }
  /// Averages into the framebuffer `target` (0: the window) and binds it.
  void resolve(GLuint target);
  const Canvas& frame() const { return *frame_; }

 private:
  const Gl& gl_;
  int width_ = 0, height_ = 0, samples_ = 1;
  std::optional<Canvas> frame_, half_;
};

}  // namespace spheretree::view
