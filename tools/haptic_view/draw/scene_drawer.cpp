// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/scene_drawer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "draw/shaders.h"
#include "model/moved_surface.h"

namespace spheretree::view {
/// Locations of the uniforms that the shaders of solids share.
struct SolidUniforms {
  GLint model, view_projection, eye, key, fill, cut, tint, tint_share;
  explicit SolidUniforms(const ShaderProgram& p)
      : model(p.uniform("model")),
        view_projection(p.uniform("view_projection")),
        eye(p.uniform("eye")),
        key(p.uniform("key")),
        fill(p.uniform("fill")),
        cut(p.uniform("cut")),
        tint(p.uniform("tint")),
        tint_share(p.uniform("tint_share")) {}
};

namespace {

using Eigen::Vector3d;

constexpr double kLongestArrow = 150;  // [pixels of the screen]

/// From the frame of a body to the world relative to `origin`, so that float keeps its digits far from the world's
/// origin.
Eigen::Matrix4f matrixOf(const Configuration& pose, const Vector3d& origin) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<3, 3>(0, 0) = pose.orientation.toRotationMatrix();
  m.block<3, 1>(0, 3) = pose.position - origin;
  return m.cast<float>();
}

void setVector(const Gl& gl, GLint at, const Vector3d& v) {
  gl.Uniform3f(at, static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
}

void setColour(const Gl& gl, GLint at, Colour c) {
  gl.Uniform4f(at, static_cast<float>(c.r) / 255, static_cast<float>(c.g) / 255, static_cast<float>(c.b) / 255,
               static_cast<float>(c.a) / 255);
}

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

}  // namespace

struct SceneDrawer::Programs {
  ShaderProgram surface, ball, sky;
  SolidUniforms surface_at, ball_at;
  GLint sky_top, sky_bottom;
  explicit Programs(const Gl& gl)
      : surface(gl, kSurfaceVertex, kSurfaceFragment),
        ball(gl, kBallVertex, kBallFragment),
        sky(gl, kSkyVertex, kSkyFragment),
        surface_at(surface),
        ball_at(ball),
        sky_top(sky.uniform("top")),
        sky_bottom(sky.uniform("bottom")) {}
};

struct SceneDrawer::CutPrograms {
  ShaderProgram surface, wall;
  SolidUniforms surface_at, wall_at;
  explicit CutPrograms(const Gl& gl)
      : surface(gl, kSurfaceVertex, kCutSurfaceFragment), wall(gl, kWallVertex, kWallFragment), surface_at(surface), wall_at(wall) {}
};

struct SceneDrawer::Triangles {
  VertexArray array;
  GlBuffer corners, indices;
  GLsizei count;
  Triangles(const Gl& gl, const Surface& surface)
      : array(gl), corners(gl), indices(gl), count(static_cast<GLsizei>(surface.indices.size())) {
    array.bind();
    corners.fill(GL_ARRAY_BUFFER, surface.corners.data(), surface.corners.size() * sizeof(SurfaceCorner), GL_STATIC_DRAW);
    indices.fill(GL_ELEMENT_ARRAY_BUFFER, surface.indices.data(), surface.indices.size() * sizeof(std::uint32_t), GL_STATIC_DRAW);
    for (const GLuint k : {0u, 1u}) {
      gl.EnableVertexAttribArray(k);
      gl.VertexAttribPointer(k, 3, GL_FLOAT, GL_FALSE, sizeof(SurfaceCorner), offset(k * sizeof(Eigen::Vector3f)));
    }
  }
};

struct SceneDrawer::BodyBuffers {
  struct Balls {
    VertexArray array;
    GlBuffer balls;
    GLsizei count;
    Balls(const Gl& gl, const std::vector<Ball>& set) : array(gl), balls(gl), count(static_cast<GLsizei>(set.size())) {
      array.bind();
      balls.fill(GL_ARRAY_BUFFER, set.data(), set.size() * sizeof(Ball), GL_STATIC_DRAW);
      gl.EnableVertexAttribArray(0);
      gl.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(Ball), offset(0));
      gl.VertexAttribDivisor(0, 1);
      gl.EnableVertexAttribArray(1);
      gl.VertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Ball), offset(16));
      gl.VertexAttribDivisor(1, 1);
    }
  };
  struct Tinted : Triangles {
    GlBuffer colours;
    Tinted(const Gl& gl, const TintedSurface& tinted) : Triangles(gl, tinted.surface), colours(gl) {
      colours.fill(GL_ARRAY_BUFFER, tinted.colours.data(), tinted.colours.size() * sizeof(Colour), GL_STATIC_DRAW);
      gl.EnableVertexAttribArray(2);
      gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Colour), offset(0));
    }
  };
  std::optional<Triangles> mesh, skin;
  std::vector<Balls> levels, bounds;
  std::vector<std::unique_ptr<Tinted>> overhangs;

  BodyBuffers(const Gl& gl, const Body& body) {
    if (!body.mesh.empty()) mesh.emplace(gl, body.mesh);
    if (!body.skin.empty()) skin.emplace(gl, body.skin);
    for (const auto& set : body.levels) levels.emplace_back(gl, set);
    for (const auto& set : body.bounds) bounds.emplace_back(gl, set);
    for (const TintedSurface& tinted : body.overhangs) overhangs.push_back(std::make_unique<Tinted>(gl, tinted));
  }
};

struct SceneDrawer::Pass {
  const Camera& camera;
  const Look& look;
  const ShownState& state;
  Viewport viewport;
  double pixel;
  Theme theme;
  Eigen::Matrix4f view_projection;
  std::array<float, 4> cut{};  // for objects, while they are drawn
  mutable std::array<float, 4> cut_now{};
  mutable float opacity = 1;
};

std::optional<ForceArrow> forceArrow(const ShownState& state, const Camera& camera, const Viewport& viewport, double pixel) {
  const double newtons = state.wrench.force.norm();
  if (!state.has_tool || !(newtons > 0.1)) return std::nullopt;
  const double length = arrowShare(newtons) * kLongestArrow * pixel * camera.pixelAt(state.graphic.position, viewport);
  return ForceArrow{state.graphic.position + state.graphic.orientation * state.tool_mark, state.wrench.force / newtons * length, newtons};
}

SceneDrawer::SceneDrawer(const Gl& gl, const Stage& stage)
    : gl_(gl), stage_(stage), programs_(std::make_unique<Programs>(gl)), empty_(gl), shape_array_(gl), shape_buffer_(gl) {
  for (const Body& body : stage.bodies) bodies_.push_back(std::make_unique<BodyBuffers>(gl, body));
  for (const PlacedObject& object : stage.objects) {
    if (object.cut && !cut_programs_) cut_programs_ = std::make_unique<CutPrograms>(gl);
    cut_.push_back(object.cut ? std::make_unique<CutDrawer>(gl) : nullptr);
  }
  shape_array_.bind();
  shape_buffer_.bind(GL_ARRAY_BUFFER);
  for (const GLuint k : {0u, 1u}) {
    gl.EnableVertexAttribArray(k);
    gl.VertexAttribPointer(k, 3, GL_FLOAT, GL_FALSE, sizeof(ShapeCorner), offset(k * sizeof(Eigen::Vector3f)));
  }
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(ShapeCorner), offset(2 * sizeof(Eigen::Vector3f)));
  gl.BindVertexArray(0);
}

SceneDrawer::~SceneDrawer() = default;

namespace {

/// Sets the uniforms that are equal for all solids of a picture.
template <class Pass>
void setSolid(const Gl& gl, const SolidUniforms& at, const Pass& pass, const Eigen::Matrix4f& model, std::optional<Colour> tint) {
  gl.UniformMatrix4fv(at.model, 1, GL_FALSE, model.data());
  gl.UniformMatrix4fv(at.view_projection, 1, GL_FALSE, pass.view_projection.data());
  const Camera& camera = pass.camera;
  setVector(gl, at.eye, camera.eye() - camera.target);
  setVector(gl, at.key, (-0.5 * camera.right() + 0.7 * camera.up() + 0.75 * camera.towardsEye()).normalized());
  setVector(gl, at.fill, (0.85 * camera.right() - 0.1 * camera.up() + 0.4 * camera.towardsEye()).normalized());
  gl.Uniform4f(at.cut, pass.cut_now[0], pass.cut_now[1], pass.cut_now[2], pass.cut_now[3]);
  const Colour c = tint.value_or(Colour{});
  gl.Uniform4f(at.tint, static_cast<float>(c.r) / 255, static_cast<float>(c.g) / 255, static_cast<float>(c.b) / 255, pass.opacity);
  gl.Uniform1f(at.tint_share, tint ? 1.0f : 0.0f);
}

}  // namespace

void SceneDrawer::drawSurface(const Pass& pass, const Triangles& triangles, const Configuration& pose, Colour colour) {
  programs_->surface.use();
  setSolid(gl_, programs_->surface_at, pass, matrixOf(pose, pass.camera.target), std::nullopt);
  triangles.array.bind();
  gl_.VertexAttrib4Nub(2, colour.r, colour.g, colour.b, 255);
  gl_.DrawElements(GL_TRIANGLES, triangles.count, GL_UNSIGNED_INT, nullptr);
}

void SceneDrawer::drawBalls(const Pass& pass, std::size_t body, std::size_t level, bool bounds, const Configuration& pose, Colour tint) {
  const BodyBuffers& buffers = *bodies_[body];
  if (pass.look.overhang && !bounds && level < buffers.overhangs.size()) return drawSurface(pass, *buffers.overhangs[level], pose, {});
  const BodyBuffers::Balls& balls = bounds ? buffers.bounds[level] : buffers.levels[level];
  programs_->ball.use();
  setSolid(gl_, programs_->ball_at, pass, matrixOf(pose, pass.camera.target), tint.a ? std::optional(tint) : std::nullopt);
  if (tint.a) gl_.Uniform1f(programs_->ball_at.tint_share, 0.75f);
  balls.array.bind();
  gl_.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, balls.count);
}

const SceneDrawer::Triangles* SceneDrawer::shownSurface(const Pass& pass, std::size_t body, Geometry geometry) const {
  const BodyBuffers& buffers = *bodies_[body];
  if (buffers.levels.empty()) geometry = Geometry::Meshes;
  const bool is_tool = stage_.tool && body == *stage_.tool;  // its contact surface is always its leaves
  if (geometry == Geometry::Contact && pass.look.skin_contact && buffers.skin && !is_tool) return &*buffers.skin;
  return geometry == Geometry::Meshes && buffers.mesh ? &*buffers.mesh : nullptr;
}

/// `own_colours`: balls keep the hues of their families; otherwise all have `colour`.
void SceneDrawer::drawBody(const Pass& pass, std::size_t body, const Configuration& pose, Geometry geometry, Colour colour,
                           bool own_colours) {
  if (const Triangles* surface = shownSurface(pass, body, geometry)) return drawSurface(pass, *surface, pose, colour);
  const BodyBuffers& buffers = *bodies_[body];
  if (buffers.levels.empty()) return;
  const std::size_t last = buffers.levels.size() - 1;
  const bool by_level = geometry == Geometry::Spheres || geometry == Geometry::Bounds;
  const std::size_t level = by_level ? std::min(static_cast<std::size_t>(std::max(pass.look.level, 0)), last) : last;
  Colour tint = colour;
  if (own_colours) tint.a = 0;
  drawBalls(pass, body, level, geometry == Geometry::Bounds, pose, tint);
}

void SceneDrawer::drawCut(const Pass& pass, std::size_t object, const CutSurface& cut, const Triangles& triangles,
                          const Configuration& pose, Colour colour) {
  const CutPrograms& programs = *cut_programs_;
  CutDrawer& drawer = *cut_[object];
  drawer.update(cut);
  const Eigen::Matrix4f model = matrixOf(pose, pass.camera.target);
  programs.surface.use();
  setSolid(gl_, programs.surface_at, pass, model, std::nullopt);
  drawer.setField(programs.surface);
  triangles.array.bind();
  gl_.VertexAttrib4Nub(2, colour.r, colour.g, colour.b, 255);
  gl_.DrawElements(GL_TRIANGLES, triangles.count, GL_UNSIGNED_INT, nullptr);
  programs.wall.use();
  setSolid(gl_, programs.wall_at, pass, model, std::nullopt);
  drawer.drawWalls();
}

template <class Draw>
void SceneDrawer::drawGlass(const Pass& pass, double opacity, Draw&& draw) {
  // Depth first, so that only its front is visible.
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw();
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.Enable(GL_BLEND);
  gl_.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl_.DepthFunc(GL_LEQUAL);
  pass.opacity = static_cast<float>(opacity);
  draw();
  pass.opacity = 1;
  gl_.DepthFunc(GL_LESS);
  gl_.Disable(GL_BLEND);
}

Shapes SceneDrawer::marks(const Pass& pass) const {
  const ShownState& state = pass.state;
  const Look& look = pass.look;
  Shapes out;
  const auto unit = [&](const Vector3d& at) { return pass.pixel * pass.camera.pixelAt(at, pass.viewport); };
  if (look.overhang) {
    const Spot* worst = nullptr;  // of what is shown
    Configuration pose;
    for (std::size_t i = 0; i < stage_.objects.size(); ++i) {
      const Body& body = stage_.bodies[stage_.objects[i].body];
      if (!look.shows(i) || body.worst.empty()) continue;
      const auto& spot = body.worst[std::min(static_cast<std::size_t>(std::max(look.level, 0)), body.worst.size() - 1)];
      if (!spot || (worst && spot->length <= worst->length)) continue;
      worst = &*spot;
      pose = state.poseOf(stage_.objects[i]);
    }
    if (worst) {
      const Vector3d tip = pose.position + pose.orientation * worst->position, away = pose.orientation * worst->direction;
      addArrow(out, tip + 60 * unit(tip) * away, -58 * unit(tip) * away, 3 * unit(tip), pass.theme.bad);
    }
  }
  if (!state.has_tool) return out;
  const auto marked = [&](const Configuration& pose) -> Vector3d { return pose.position + pose.orientation * state.tool_mark; };
  const Vector3d at = marked(state.graphic);
  const double px = unit(at);
  if (look.contacts)
    for (const ShownContact& contact : state.contacts) {
      const double share = arrowShare(contact.force);
      const Colour colour = heat(share);
      const Vector3d point = contact.point.cast<double>(), normal = contact.normal.cast<double>();
      const Vector3d lifted = point + 0.6 * px * normal;
      addDisc(out, lifted, normal, 8 * px, colour);
      addRing(out, lifted, normal, 8 * px, 9.5 * px, pass.theme.text);
      if (share > 0) addRod(out, lifted, lifted + 42 * share * px * normal, 1.4 * px, colour);
      const Vector3d friction = contact.friction.cast<double>();
      const double rub = arrowShare(friction.norm());
      if (rub > 0) addArrow(out, lifted, 42 * rub * px * friction.normalized(), 1.4 * px, pass.theme.warning);
    }
  const Vector3d stretch = marked(state.haptic) - at;
  if (look.spring && stretch.norm() > 2 * px)
    addCoil(out, at, marked(state.haptic), std::min(4.5 * px, 0.3 * stretch.norm()), 1.1 * px, pass.theme.spring);
  if (look.force)
    if (const auto arrow = forceArrow(state, pass.camera, pass.viewport, pass.pixel))
      addArrow(out, arrow->from, arrow->along, 3.2 * px, pass.theme.force);
  const double torque = state.wrench.torque.norm();
  if (look.torque && torque > 1) {
    const double share = std::min(1.0, std::log10(torque) / 2.3);  // a full circle at 200 N mm
    addArc(out, at, state.wrench.torque, 34 * px, 0.2 + 5.4 * share, 2.0 * px, pass.theme.torque);
  }
  return out;
}

/// `ghosts`: hidden parts are also drawn, faintly.
void SceneDrawer::drawShapes(const Pass& pass, const Shapes& shapes, bool ghosts) {
  if (shapes.empty()) return;
  programs_->surface.use();
  setSolid(gl_, programs_->surface_at, pass, matrixOf({}, pass.camera.target), std::nullopt);
  shape_array_.bind();
  shape_buffer_.fill(GL_ARRAY_BUFFER, shapes.data(), shapes.size() * sizeof(ShapeCorner), GL_STREAM_DRAW);
  gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(shapes.size()));
  if (!ghosts) return;
  gl_.Enable(GL_BLEND);
  gl_.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl_.DepthFunc(GL_GREATER);
  gl_.DepthMask(GL_FALSE);
  gl_.Uniform4f(programs_->surface_at.tint, 1, 1, 1, 0.3f);
  gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(shapes.size()));
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  gl_.Disable(GL_BLEND);
}

void SceneDrawer::drawObject(const Pass& pass, std::size_t i) {
  const PlacedObject& object = stage_.objects[i];
  const Configuration pose = pass.state.poseOf(object);
  const Geometry geometry = pass.look.objects;
  Colour colour = stage_.bodies[object.body].colour;
  const bool is_marked = pass.look.marked == i;
  if (is_marked) {
    const Colour mark = pass.theme.spring;
    colour = {static_cast<std::uint8_t>((colour.r + mark.r) / 2), static_cast<std::uint8_t>((colour.g + mark.g) / 2),
              static_cast<std::uint8_t>((colour.b + mark.b) / 2), colour.a};
  }
  const bool is_moved = object.soft && i < pass.state.tissue.size() && !pass.state.tissue[i].empty();
  if (is_moved && (geometry == Geometry::Meshes || geometry == Geometry::Contact)) {
    const BodyBuffers::Tinted now(gl_, object.soft->at(pass.state.tissue[i], colour));
    drawSurface(pass, now, pose, {});
    return;
  }
  const CutSurface* const cut = pass.state.removal ? pass.state.removal->of(i) : nullptr;
  const Triangles* const surface = cut && !cut->empty() ? shownSurface(pass, object.body, geometry) : nullptr;
  if (surface) {
    drawCut(pass, i, *cut, *surface, pose, colour);
  } else {
    drawBody(pass, object.body, pose, geometry, colour, stage_.objects.size() == 1 && !is_marked);
  }
}

void SceneDrawer::draw(const Camera& camera, const Look& look, const ShownState& state, const Viewport& viewport, int frame_height,
                       double pixel) {
  const int low = frame_height - viewport.y - viewport.height;
  gl_.Viewport(viewport.x, low, viewport.width, viewport.height);
  gl_.Scissor(viewport.x, low, viewport.width, viewport.height);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.DepthMask(GL_TRUE);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  Pass pass{camera, look, state, viewport, pixel, themeOf(look.theme), {}, {}};
  const double tool = state.has_tool ? stage_.toolReach() : 0;
  double radius = stage_.radius();
  if (state.has_tool) radius = std::max(radius, (state.graphic.position - stage_.centre()).norm() + tool);
  const auto [near, far] = camera.depthRange(stage_.centre(), radius + 1);
  Camera about_target = camera;
  about_target.target.setZero();
  pass.view_projection = (camera.projection(viewport.aspect(), near, far) * about_target.view()).cast<float>();
  programs_->sky.use();
  setColour(gl_, programs_->sky_top, pass.theme.top);
  setColour(gl_, programs_->sky_bottom, pass.theme.bottom);
  empty_.bind();
  gl_.DepthMask(GL_FALSE);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.DepthMask(GL_TRUE);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_LESS);

  if (look.cut && state.has_tool)
    if (const auto at = camera.pixelOf(state.graphic.position, viewport))
      pass.cut_now = {static_cast<float>(at->x()), static_cast<float>(frame_height - at->y()), static_cast<float>(90 * pixel),
                      static_cast<float>((camera.eye() - state.graphic.position).norm() - 0.06 * tool)};
  for (std::size_t i = 0; i < stage_.objects.size(); ++i)
    if (look.shows(i) && !look.isGlass(i)) drawObject(pass, i);
  pass.cut_now = {};
  if (state.has_tool && stage_.tool) {
    const Configuration& g = state.graphic;
    drawBody(pass, *stage_.tool, {g.position - g.orientation * stage_.reference_point, g.orientation}, look.tool, pass.theme.graphic,
             false);
  }
  drawShapes(pass, marks(pass), true);
  if (state.has_tool && stage_.tool && look.haptic_tool) {
    const Configuration& h = state.haptic;
    const Configuration pose{h.position - h.orientation * stage_.reference_point, h.orientation};
    const Colour colour = pass.theme.haptic;
    drawGlass(pass, colour.a / 255.0, [&] { drawBody(pass, *stage_.tool, pose, look.tool, colour, false); });
  }
  constexpr double kGlass = 0.3;
  for (std::size_t i = 0; i < stage_.objects.size(); ++i)
    if (look.shows(i) && look.isGlass(i)) drawGlass(pass, kGlass, [&] { drawObject(pass, i); });
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.BindVertexArray(0);
}

void Screen::begin(int width, int height, int samples) {
  width_ = width;
  height_ = height;
  samples_ = samples;
  if (!frame_ || frame_->width() != width * samples || frame_->height() != height * samples)
    frame_.emplace(gl_, width * samples, height * samples);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, frame_->id());
}

void Screen::resolve(GLuint target) {
  // A linear filter is the mean of four at exactly half the size, so that a quarter takes two steps.
  const Canvas* from = &*frame_;
  gl_.Disable(GL_SCISSOR_TEST);
  const auto copy = [&](const Canvas& source, GLuint into, int width, int height) {
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, source.id());
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, into);
    gl_.BlitFramebuffer(0, 0, source.width(), source.height(), 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                        source.width() > width ? GL_LINEAR : GL_NEAREST);
  };
  if (samples_ == 4) {
    if (!half_ || half_->width() != 2 * width_ || half_->height() != 2 * height_) half_.emplace(gl_, 2 * width_, 2 * height_);
    copy(*frame_, half_->id(), 2 * width_, 2 * height_);
    from = &*half_;
  }
  copy(*from, target, width_, height_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target);
  gl_.Viewport(0, 0, width_, height_);
}

}  // namespace spheretree::view
