// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures without a display: everything is drawn where ray casting predicts it, in the right colours.
#include <gtest/gtest.h>
#include <imgui.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <set>

#include "draw/offscreen.h"
#include "draw/scene_drawer.h"
#include "model/removal.h"
#include "panel/controls.h"
#include "panel/viewer.h"
#include "support/scratch_folder.h"
#include "support/shapes.h"
#include "window/capture.h"
#include "window/picture_maker.h"

namespace spheretree::view {
namespace {

using Eigen::Vector3d;
constexpr int kSize = 200;

Stage oneBall(const Ball& ball) {
  Stage stage;
  Body body;
  body.name = "ball";
  body.levels = {{ball}};
  body.bounds = {{ball}};
  const Vector3d c(ball.x, ball.y, ball.z);
  body.box = Eigen::AlignedBox3d(c.array() - ball.radius, c.array() + ball.radius);
  stage.bodies = {body};
  stage.objects = {{0, {}}};
  return stage;
}

struct Drawn {
  Picture picture;
  std::vector<float> depth;
  std::array<int, 3> at(int x, int y) const {
    const std::size_t p = 3 * static_cast<std::size_t>(y * picture.width + x);
    return {picture.rgb[p], picture.rgb[p + 1], picture.rgb[p + 2]};
  }
};

class Drawing : public ::testing::Test {
 protected:
  void SetUp() override {
    ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    context_ = std::make_unique<OffscreenContext>();
  }
  Drawn draw(const Stage& stage, const Camera& camera, const Look& look, const ShownState& state) {
    const Canvas canvas(context_->gl(), kSize, kSize);
    SceneDrawer drawer(context_->gl(), stage);
    drawer.draw(camera, look, state, kViewport, kSize, 1);
    return {readPixels(context_->gl(), canvas), readDepth(context_->gl(), canvas)};
  }
  static constexpr Viewport kViewport{0, 0, kSize, kSize};
  std::unique_ptr<OffscreenContext> context_;
};

double eyeDepth(float stored, double near, double far) { return near * far / (far - static_cast<double>(stored) * (far - near)); }

TEST_F(Drawing, BallsStandWhereRaysMeetThem) {
  for (const Ball& ball : {Ball{1, 2, 3, 4, {200, 40, 40, 255}}, Ball{-300, 500, 20, 0.05f, {200, 40, 40, 255}}}) {
    const Stage stage = oneBall(ball);
    Camera camera;
    const Vector3d centre(ball.x, ball.y, ball.z);
    camera.frame(centre + Vector3d(0.3, -0.2, 0.1) * ball.radius, 1.6 * static_cast<double>(ball.radius), kViewport);
    const Drawn drawn = draw(stage, camera, {}, {});
    const auto [near, far] = camera.depthRange(stage.centre(), stage.radius() + 1);
    int wrong = 0, hits = 0;
    double worst = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const Ray ray = camera.rayThrough({x + 0.5, y + 0.5}, kViewport);
        const Vector3d from = ray.origin - centre;
        const double along = from.dot(ray.direction), missed = (from - along * ray.direction).norm();
        const double pixel = camera.pixelAt(centre, kViewport), r = static_cast<double>(ball.radius);
        if (std::abs(missed - r) < pixel) continue;  // the outline is exact to a pixel
        const float depth = drawn.depth[static_cast<std::size_t>(y * kSize + x)];
        if (missed > r) {
          wrong += depth < 1;
          continue;
        }
        ++hits;
        const Vector3d hit = ray.origin + (-along - std::sqrt(r * r - missed * missed)) * ray.direction;
        const double expected = (camera.eye() - hit).dot(camera.towardsEye());
        // To a pixel, where the surface is no steeper than the distance from the outline allows, or to the step of the
        // depth buffer.
        const double slope = missed / std::sqrt(r * r - missed * missed);
        const double step = expected * expected / near / (1 << 22);
        const double off = std::abs(eyeDepth(depth, near, far) - expected) - step;
        worst = std::max(worst, off / pixel);
        wrong += off > pixel * std::max(1.0, slope);
      }
    EXPECT_EQ(wrong, 0) << ball.radius << " worst " << worst << " pixels";
    EXPECT_GT(hits, kSize * kSize / 6);
  }
}

TEST_F(Drawing, ABallHasItsColourAndTheRestIsBackground) {
  const Stage stage = oneBall({0, 0, 0, 5, {220, 60, 30, 255}});
  Camera camera;
  camera.frame(Vector3d::Zero(), 8, kViewport);
  for (const ThemeKind theme : {ThemeKind::Dark, ThemeKind::Light}) {
    Look look;
    look.theme = theme;
    const Drawn drawn = draw(stage, camera, look, {});
    const auto middle = drawn.at(kSize / 2, kSize / 2);
    EXPECT_GT(middle[0], 150);
    EXPECT_NEAR(static_cast<double>(middle[1]) / middle[0], 60.0 / 220, 0.12);
    EXPECT_NEAR(static_cast<double>(middle[2]) / middle[0], 30.0 / 220, 0.12);
    const Theme colours = themeOf(theme);
    EXPECT_NEAR(drawn.at(3, 0)[0], colours.top.r, 2);
    EXPECT_NEAR(drawn.at(3, kSize - 1)[2], colours.bottom.b, 2);
  }
}

TEST_F(Drawing, TheSameTwiceIsTheSameBytes) {
  const Stage stage = oneBall({0, 0, 0, 5, {220, 60, 30, 255}});
  Camera camera;
  camera.frame(Vector3d::Zero(), 8, kViewport);
  const Drawn first = draw(stage, camera, {}, {}), second = draw(stage, camera, {}, {});
  EXPECT_EQ(encodePng(first.picture), encodePng(second.picture));
}

TEST_F(Drawing, MeshesHideBallsBehindThem) {
  Stage stage = oneBall({0, 20, 0, 5, {30, 60, 220, 255}});
  TriangleMesh wall;
  wall.positions = {{-50, 0, -50}, {50, 0, -50}, {50, 0, 50}, {-50, 0, 50}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  stage.bodies.push_back(bodyOf("wall", nullptr, &wall, {40, 200, 60, 255}));
  stage.objects.push_back({1, {}});
  Camera camera;
  camera.lookFrom(1);
  camera.frame(Vector3d::Zero(), 30, kViewport);
  EXPECT_GT(draw(stage, camera, {}, {}).at(kSize / 2, kSize / 2)[1], 100);
  camera.lookFrom(2);  // from behind the ball is in front
  EXPECT_GT(draw(stage, camera, {}, {}).at(kSize / 2, kSize / 2)[2], 100);
  Look look;
  look.hidden = {false, true};
  camera.lookFrom(1);
  EXPECT_GT(draw(stage, camera, look, {}).at(kSize / 2, kSize / 2)[2], 100);
}

/// A tool far from the object, both of one ball.
Stage withTool() {
  Stage stage = oneBall({0, 0, -20, 3, {90, 90, 90, 255}});
  stage.bodies.push_back(stage.bodies[0]);
  stage.bodies[1].levels = {{Ball{0, 0, 0, 1, {90, 90, 90, 255}}}};
  stage.bodies[1].box = Eigen::AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1));
  stage.tool = 1;
  return stage;
}

/// Pixels of about a colour.
std::vector<Eigen::Vector2d> pixelsOf(const Drawn& drawn, const std::function<bool(const std::array<int, 3>&)>& is) {
  std::vector<Eigen::Vector2d> out;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (is(drawn.at(x, y))) out.push_back({x + 0.5, y + 0.5});
  return out;
}

TEST_F(Drawing, TheForceArrowHasDirectionAndLength) {
  const Stage stage = withTool();
  Camera camera;
  camera.lookFrom(1);
  camera.frame(Vector3d::Zero(), 20, kViewport);
  Look look;
  look.haptic_tool = look.spring = look.torque = look.contacts = false;
  ShownState state;
  state.has_tool = true;
  // 0.1 to 10 N are 0 to 150 pixels by the logarithm: 1 N is 75.
  for (const auto& [direction, newtons, pixels] :
       {std::tuple(Vector3d(1, 0, 0), 1.0, 75.0), std::tuple(Vector3d(0, 0, 1), 0.316227766, 37.5),
        std::tuple(Vector3d(-1, 0, 0), 1.0, 75.0)}) {
    state.wrench.force = newtons * direction;
    const Drawn drawn = draw(stage, camera, look, state);
    const auto orange = pixelsOf(drawn, [](const auto& c) { return c[0] > 110 && c[0] > 2 * c[2] + 30 && c[1] < c[0] - 15; });
    ASSERT_GT(orange.size(), 50u);
    const Eigen::Vector2d along(direction.x(), -direction.z()), middle(kSize / 2.0, kSize / 2.0);
    double farthest = 0, aside = 0;
    for (const Eigen::Vector2d& p : orange) {
      farthest = std::max(farthest, (p - middle).dot(along));
      aside = std::max(aside, std::abs((p - middle).dot(Eigen::Vector2d(-along.y(), along.x()))));
    }
    EXPECT_NEAR(farthest, pixels, 2.5);
    EXPECT_LT(aside, 9);
  }
  state.wrench.force = Vector3d(0.05, 0, 0);
  EXPECT_FALSE(forceArrow(state, camera, kViewport, 1));
  state.wrench.force = Vector3d(1000, 0, 0);  // no longer than 10 N
  EXPECT_NEAR(forceArrow(state, camera, kViewport, 1)->along.norm(), 150 * camera.pixelAt(Vector3d::Zero(), kViewport), 1e-9);
}

TEST_F(Drawing, TheToolsAreAsFarApartAsTheSpringIsLong) {
  const Stage stage = withTool();
  Camera camera;
  camera.lookFrom(1);
  camera.frame(Vector3d::Zero(), 20, kViewport);
  Look look;
  look.force = look.torque = look.contacts = look.spring = false;
  look.hidden = {true};
  ShownState state;
  state.has_tool = true;
  state.haptic.position = {8, 0, 0};
  const auto middleOf = [&](bool haptic) {
    ShownState apart = state;
    apart.graphic.position = haptic ? Vector3d(0, 0, 60) : Vector3d(0, 0, 0);  // out of the picture
    look.haptic_tool = haptic;
    const Drawn drawn = draw(stage, camera, look, apart);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double count = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        if (drawn.depth[static_cast<std::size_t>(y * kSize + x)] < 1) {
          sum += Eigen::Vector2d(x + 0.5, y + 0.5);
          ++count;
        }
    return Eigen::Vector2d(sum / count);
  };
  const double pixel = camera.pixelAt(Vector3d::Zero(), kViewport);
  EXPECT_NEAR(middleOf(false).x(), kSize / 2.0, 1);
  EXPECT_NEAR(middleOf(true).x(), kSize / 2.0 + 8 / pixel, 1);
}

TEST_F(Drawing, ContactsAreDiscsInTheColourOfTheirForce) {
  const Stage stage = withTool();
  Camera camera;
  camera.lookFrom(1);
  camera.frame(Vector3d::Zero(), 20, kViewport);
  Look look;
  look.haptic_tool = look.spring = look.torque = look.force = false;
  ShownContact contact;
  contact.point = {6, -3, 4};
  contact.normal = {0, -1, 0};
  contact.force = 10;
  ShownState state;
  state.has_tool = true;
  state.contacts = {&contact, 1};
  const Drawn drawn = draw(stage, camera, look, state);
  const auto pixel = camera.pixelOf({6, -3, 4}, kViewport);
  const auto c = drawn.at(static_cast<int>(pixel->x()) + 3, static_cast<int>(pixel->y()));
  EXPECT_GT(c[0], 120);  // 10 N: yellow
  EXPECT_GT(c[1], 110);
  EXPECT_LT(c[2], 0.7 * c[0]);
}

/// A block of 8 mm whose top is z = 0, of a green layer with a red one from z = -1 down, and a burr of 0.5 mm.
Stage drilledBlock() {
  Stage stage;
  const TriangleMesh block = test::boxMesh({-4, -4, -8}, {4, 4, 0});
  stage.bodies.push_back(bodyOf("block", nullptr, &block, {200, 200, 200, 255}));
  stage.objects = {{0, {}}};
  stage.burr = {{Vector3d::Zero(), 0.5}};
  stage.objects[0].cut =
      std::make_shared<const CutMaterial>(CutMaterial{{{"upper",
                                                        {40, 200, 60, 255},
                                                        [](const Vector3d& p) {
                                                          return -test::boxDistance({-4, -4, -8}, {4, 4, 0}, p);
                                                        }},
                                                       {"lower", {200, 40, 40, 255}, [](const Vector3d& p) { return -1 - p.z(); }}}});
  return stage;
}

/// A hole down to the layer below.
Removal drilledHole(const Stage& stage) {
  Removal removal(stage);
  player::RecordedStep step;
  step.spins = true;
  for (step.tick = 0; step.tick < 100; ++step.tick) {
    step.graphic.position = {0, 0, 0.8 - 0.02 * static_cast<double>(step.tick)};
    removal.add(step, {});
  }
  return removal;
}

TEST_F(Drawing, ACavityIsWhatTheBurrLeaves) {
  const Stage stage = drilledBlock();
  const Removal removal = drilledHole(stage);
  const Vector3d from(0, 0, 0.8), to(0, 0, -1.18);
  const auto isMaterial = [&](const Vector3d& p) {
    const Vector3d on_way(0, 0, std::clamp(p.z(), to.z(), from.z()));
    return test::boxDistance({-4, -4, -8}, {4, 4, 0}, p) < 0 && (p - on_way).norm() > 0.5;
  };
  for (const Vector3d& direction : {Vector3d(0.1, -0.2, 1), Vector3d(0.8, 0.3, 1)}) {
    Camera camera;
    camera.lookFrom(direction);
    camera.frame(Vector3d(0, 0, -0.4), 1, kViewport);
    ShownState state;
    state.removal = &removal;
    const Drawn drawn = draw(stage, camera, {}, state);
    const auto [near, far] = camera.depthRange(stage.centre(), stage.radius() + 1);
    const auto expected = [&](double x, double y) {
      const Ray ray = camera.rayThrough({x, y}, kViewport);
      double along = (camera.eye() - Vector3d(0, 0, -0.4)).norm() - 3;
      while (!isMaterial(ray.origin + along * ray.direction) && along < 1e3) along += 0.005;
      return along * -ray.direction.dot(camera.towardsEye());
    };
    int wrong = 0, red = 0, deep = 0;
    for (int y = 1; y < kSize; y += 3)
      for (int x = 1; x < kSize; x += 3) {
        // The outline of the hole is exact to a pixel, of 0.01 mm, and its wall ends less than one above the surface.
        double least = 1e9, most = 0;
        for (const auto& [dx, dy] :
             {std::pair(0.5, 0.5), std::pair(-1.5, 0.5), std::pair(2.5, 0.5), std::pair(0.5, -1.5), std::pair(0.5, 2.5)}) {
          const double depth = expected(x + dx, y + dy);
          least = std::min(least, depth);
          most = std::max(most, depth);
        }
        const double depth = eyeDepth(drawn.depth[static_cast<std::size_t>(y * kSize + x)], near, far);
        const bool is_wrong = depth < least - 0.02 || depth > most + 0.02;
        EXPECT_FALSE(is_wrong) << x << " " << y << ": " << depth << ", not " << least << " to " << most;
        const auto colour = drawn.at(x, y);
        red += colour[0] > 2 * colour[1];
        deep += colour[1] > 2 * colour[0];
      }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(red, 20);
    EXPECT_GT(deep, 20);
  }
}

TEST_F(Drawing, NothingRemovedIsDrawnAsWithoutABurr) {
  Stage stage = drilledBlock();
  const Removal none(stage);
  Camera camera;
  camera.frame(Vector3d::Zero(), 8, kViewport);
  ShownState state;
  state.removal = &none;
  const Drawn whole = draw(stage, camera, {}, state);
  stage.objects[0].cut.reset();
  EXPECT_EQ(encodePng(draw(stage, camera, {}, {}).picture), encodePng(whole.picture));
}

TEST_F(Drawing, OneDrawerShowsEveryMomentOfARun) {
  // As a new one does: what an earlier picture uploaded leaves nothing behind.
  const Stage stage = drilledBlock();
  Camera camera;
  camera.lookFrom(Vector3d(0.8, 0.3, 1));
  camera.frame(Vector3d::Zero(), 2, kViewport);
  const Canvas canvas(context_->gl(), kSize, kSize);
  SceneDrawer drawer(context_->gl(), stage);
  Removal longer = drilledHole(stage);
  player::RecordedStep step;
  step.spins = true;
  for (const double x : {0.0, 1.5}) {
    step.graphic.position = {x, 0.5, -0.5};
    longer.add(step, {});
  }
  const Removal none(stage), hole = drilledHole(stage);
  for (const Removal* removal : std::initializer_list<const Removal*>{&none, &longer, &hole, &longer, &none}) {
    ShownState state;
    state.removal = removal;
    drawer.draw(camera, {}, state, kViewport, kSize, 1);
    EXPECT_EQ(encodePng(readPixels(context_->gl(), canvas)), encodePng(draw(stage, camera, {}, state).picture));
    context_->gl().BindFramebuffer(GL_FRAMEBUFFER, canvas.id());
  }
}

/// A frame with all panels, moved by pointer and keys.
class WholeFrame : public Drawing {
 protected:
  void SetUp() override {
    Drawing::SetUp();
    stage_ = withTool();
    Pane pane;
    pane.stage = &stage_;
    pane.has_state = true;
    state_.panes = {pane};
    state_.hand = &hand_;
    state_.can_record = true;
    interface_ = std::make_unique<Interface>(1);
    viewer_ = std::make_unique<Viewer>(context_->gl(), *interface_, state_);
    canvas_ = std::make_unique<Canvas>(context_->gl(), 800, 600);
    state_.camera = firstCamera(stage_, Configuration(), layoutOf(state_, 800, 600, 1).panes[0]);
    frame();
  }
  void frame(double seconds = 0.02) {
    interface_->begin(800, 600, seconds);
    viewer_->frame(800, 600, 1, seconds, canvas_->id());
  }
  void pointer(double x, double y, int button = -1) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {static_cast<float>(x), static_cast<float>(y)};
    for (int k = 0; k < 3; ++k) io.MouseDown[k] = k == button;
    frame();
  }
  void key(int code, bool down) {
    ImGui::GetIO().KeysDown[code] = down;
    frame();
  }
  void stroke(int code) {
    key(code, true);
    key(code, false);
  }
  Stage stage_;
  HandInput hand_;
  ViewerState state_;
  std::unique_ptr<Interface> interface_;
  std::unique_ptr<Viewer> viewer_;
  std::unique_ptr<Canvas> canvas_;
};

TEST_F(WholeFrame, ADragMovesTheHandByTheMillimetresAskedFor) {
  const Viewport pane = layoutOf(state_, 800, 600, 1).panes[0];
  const double mm = state_.camera.pixelAt(Vector3d::Zero(), pane);
  pointer(200, 200);
  pointer(200, 200, 0);
  pointer(260, 180, 0);
  pointer(300, 200, 0);
  pointer(300, 200);
  const Vector3d expected = 100 * mm * state_.camera.right();
  EXPECT_LT((hand_.pose().position - expected).norm(), 0.02 * expected.norm());
  ImGui::GetIO().MouseWheel = 4;
  frame();
  ImGui::GetIO().MouseWheel = 0;
  EXPECT_NEAR((hand_.pose().position - expected).dot(-state_.camera.towardsEye()), 4 * HandInput::kWheelStep, 0.02);
  const Quaternion before = hand_.pose().orientation;
  pointer(200, 200);
  pointer(200, 200, 1);
  pointer(230, 200, 1);
  EXPECT_NEAR(rotationVector(hand_.pose().orientation * before.conjugate()).norm(), 30 * HandInput::kTurnOfPixel, 1e-6);
}

TEST_F(WholeFrame, AKeyAsksForTheBurrWhereThereIsOne) {
  stroke(keyOf('B'));
  EXPECT_FALSE(state_.wants_spindle);
  state_.can_spin = true;
  stroke(keyOf('B'));
  EXPECT_TRUE(state_.wants_spindle);
}

TEST_F(WholeFrame, ThePanelKeepsThePointerToItself) {
  pointer(700, 300);
  pointer(700, 300, 0);
  pointer(760, 330, 0);
  EXPECT_EQ(hand_.pose().position, Vector3d(0, 0, 0));
}

TEST_F(WholeFrame, TheMiddleButtonOrbitsAndLeavesTheHand) {
  const double azimuth = state_.camera.azimuth;
  pointer(200, 200);
  pointer(200, 200, 2);
  pointer(250, 200, 2);
  EXPECT_NEAR(state_.camera.azimuth, azimuth - 50 * 0.008, 1e-6);
  EXPECT_EQ(hand_.pose().position, Vector3d(0, 0, 0));
}

TEST_F(WholeFrame, KeysMoveTheHandAtTwentyMillimetresASecond) {
  ImGui::GetIO().KeysDown[262] = true;  // right
  for (int n = 0; n < 50; ++n) frame(0.02);
  ImGui::GetIO().KeysDown[262] = false;
  EXPECT_NEAR(hand_.pose().position.dot(state_.camera.right()), 20, 0.5);
}

TEST_F(WholeFrame, KeysChooseViewThemeAndGeometry) {
  stroke('5');
  EXPECT_LT((state_.camera.towardsEye() - Vector3d(0, 0, 1)).norm(), 1e-9);
  stroke('T');
  EXPECT_EQ(state_.look.theme, ThemeKind::Light);
  stroke('M');
  EXPECT_EQ(state_.look.objects, Geometry::Spheres);
  stroke('R');
  EXPECT_TRUE(state_.wants_record);
  stroke(290);  // F1
  EXPECT_TRUE(state_.help);
  stroke(256);  // Escape
  EXPECT_FALSE(state_.help);
  stroke('F');
  EXPECT_LT((state_.camera.target - Vector3d(0, 0, 0)).norm(), 1e-9);
}

TEST_F(WholeFrame, KeysPauseSlowAndRestartALiveRun) {
  stroke(32);
  EXPECT_FALSE(state_.course.is_paused) << "not a live run";
  state_.course.is_live = true;
  stroke(32);
  EXPECT_TRUE(state_.course.is_paused);
  stroke('N');
  EXPECT_EQ(state_.course.wanted_steps, 1);
  stroke(32);
  EXPECT_FALSE(state_.course.is_paused);
  stroke('N');
  EXPECT_TRUE(state_.course.is_paused) << "a single step begins a pause";
  for (int n = 0; n < 9; ++n) stroke('-');
  EXPECT_EQ(state_.course.slowness, 32);
  for (int n = 0; n < 9; ++n) stroke('=');
  EXPECT_EQ(state_.course.slowness, 1);
  stroke(259);  // Backspace
  EXPECT_TRUE(state_.course.wants_restart);
  stroke('Z');
  EXPECT_TRUE(state_.frozen);
  std::set<std::string> keys;
  for (const HelpLine& line : helpLines(state_)) EXPECT_TRUE(keys.insert(line.key).second) << line.key << " has two meanings";
}

TEST_F(WholeFrame, ThePointerNamesAndAClickChoosesAnObject) {
  const auto pixel = state_.camera.pixelOf({0, 0, -20}, layoutOf(state_, 800, 600, 1).panes[0]);
  ASSERT_TRUE(pixel);
  pointer(pixel->x(), pixel->y());
  EXPECT_EQ(state_.hovered, 0u);
  const auto figures = objectFigures(state_.panes[0], 0);
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[0].value, "1");  // leaf
  EXPECT_EQ(figures[1].value, "16.00 mm");
  EXPECT_FALSE(state_.selected);
  pointer(pixel->x(), pixel->y(), 0);
  pointer(pixel->x(), pixel->y());
  EXPECT_EQ(state_.selected, 0u);
  EXPECT_EQ(hand_.pose().position, Vector3d(0, 0, 0)) << "a click moves no hand";
  stroke('G');
  EXPECT_TRUE(state_.look.isGlass(0));
  stroke('H');
  EXPECT_FALSE(state_.look.shows(0));
  frame();
  EXPECT_FALSE(state_.hovered) << "hidden";
  stroke('U');
  EXPECT_TRUE(state_.look.shows(0));
  EXPECT_FALSE(state_.look.isGlass(0));
  pointer(5, 300, 0);
  pointer(5, 300);
  EXPECT_FALSE(state_.selected) << "a click beside everything";
}

TEST_F(Drawing, GlassShowsWhatIsBehindIt) {
  Stage stage = oneBall({0, 0, 0, 5, {30, 60, 220, 255}});
  stage.bodies.push_back(stage.bodies[0]);
  stage.bodies[1].levels = stage.bodies[1].bounds = {{Ball{0, 20, 0, 5, {220, 60, 30, 255}}}};
  stage.bodies[0].colour = {30, 60, 220, 255};
  stage.bodies[1].colour = {220, 60, 30, 255};
  stage.objects.push_back({1, {}});
  Camera camera;
  camera.lookFrom(1);
  camera.frame(Vector3d::Zero(), 12, kViewport);
  Look look;
  const auto solid = draw(stage, camera, look, {}).at(kSize / 2, kSize / 2);
  EXPECT_GT(solid[2], solid[0]);
  look.glass = {true};
  const auto glass = draw(stage, camera, look, {}).at(kSize / 2, kSize / 2);
  EXPECT_GT(glass[0], glass[2]) << "red shows through";
  EXPECT_GT(glass[2], draw(stage, camera,
                           [] {
                             Look l;
                             l.hidden = {true};
                             return l;
                           }(),
                           {})
                          .at(kSize / 2, kSize / 2)[2])
      << "and some blue stays";
}

TEST_F(Drawing, ScreenshotsAndFilmsReplaceNoFile) {
  const test::ScratchFolder folder;
  const Canvas canvas(context_->gl(), 80, 61);
  context_->gl().ClearColor(1, 0, 0, 1);
  context_->gl().Clear(GL_COLOR_BUFFER_BIT);
  std::ofstream(folder.path() / "run-1.png") << "mine";
  Capture capture(folder.path() / "run.csv");
  for (int n = 0; n < 2; ++n) EXPECT_NE(capture.take(context_->gl(), 80, 61, true, false).find("run-"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(folder.path() / "run-1.png"), 4u);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "run-2.png"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "run-3.png"));
  EXPECT_EQ(capture.take(context_->gl(), 80, 61, false, true), "");
  EXPECT_NE(capture.film(), "");
  const std::string told = capture.take(context_->gl(), 80, 61, false, true);
  EXPECT_NE(told.find("1 frames: ffmpeg"), std::string::npos) << told;
  EXPECT_EQ(capture.film(), "");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "run-1-film" / "00001.png"));
}

TEST_F(WholeFrame, SpaceStopsAReplay) {
  Playback playback(5000);
  state_.playback = &playback;
  stroke(32);
  EXPECT_TRUE(playback.isPlaying());
  frame(0.5);
  EXPECT_GE(playback.step(), 500u);
  stroke(32);
  const std::size_t at = playback.step();
  stroke(262);
  EXPECT_EQ(playback.step(), at + 1);
}

TEST_F(WholeFrame, TheScrubberJumpsWhereItIsClicked) {
  Playback playback(5001);
  state_.playback = &playback;
  const Viewport bar = layoutOf(state_, 800, 600, 1).scrubber;
  ASSERT_GT(bar.width, 100);
  frame();
  const double x = bar.x + 0.75 * bar.width, y = bar.y + bar.height / 2.0;
  pointer(x, y);
  pointer(x, y, 0);
  pointer(x, y);
  EXPECT_GT(playback.step(), 3000u);
  EXPECT_LT(playback.step(), 4000u);
}

TEST_F(WholeFrame, BothThemesAtBothScalesFillTheirPlaces) {
  for (const double scale : {1.0, 2.0}) {
    const Layout layout = layoutOf(state_, 1600, 1000, scale);
    EXPECT_EQ(layout.scene.width + layout.panel.width, 1600);
    EXPECT_EQ(layout.panel.width, static_cast<int>(268 * scale));
  }
  state_.panels = false;
  EXPECT_EQ(layoutOf(state_, 800, 600, 1).scene.width, 800);
}

void showSideBySide(ViewerState& state, const std::vector<Stage>& stages) {
  for (const Stage& stage : stages) {
    Pane& pane = state.panes.emplace_back();
    pane.stage = &stage;
    pane.shift = shiftBetween(stages[0], stage);
  }
}

// Objects of a scene side by side, each in its own place of the world: every pane shows its own.
TEST(SideBySide, APaneShowsItsStageWhereverItIs) {
  ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  const std::vector<Stage> stages{oneBall({0, 0, 0, 4, {200, 40, 40, 255}}), oneBall({60, -20, 9, 4, {200, 40, 40, 255}}),
                                  oneBall({2, 1, 0, 4, {200, 40, 40, 255}})};
  EXPECT_EQ(shiftBetween(stages[0], stages[1]), Vector3d(60, -20, 9));
  EXPECT_EQ(shiftBetween(stages[0], stages[2]), Vector3d(0, 0, 0)) << "they overlap: equal places are seen at equal places";
  ViewerState state;
  state.panels = false;
  showSideBySide(state, stages);
  PictureMaker maker(900, 300, 1, state);
  state.camera = wishedCamera(stages[0], std::nullopt, {.from = Vector3d(0, -1, 0)}, maker.layout().panes[0]);
  const double near = state.camera.distance;
  frameWhole(state, maker.layout().panes[0]);
  EXPECT_NEAR(state.camera.distance / near, 1 + std::sqrt(5.0) / stages[0].radius(), 1e-6) << "the third ball is whole, too";
  EXPECT_EQ(state.camera.target, Vector3d(0, 0, 0));
  const Picture picture = maker.draw();
  std::array<double, 3> middle{};  // of the pixels of each pane that differ from the background, from its left edge
  for (std::size_t k = 0; k < 3; ++k) {
    const Viewport place = maker.layout().panes[k];
    const auto red = [&](int x, int y) { return static_cast<int>(picture.rgb[3 * static_cast<std::size_t>(y * picture.width + x)]); };
    int count = 0;
    for (int y = 60; y < place.height - 60; ++y)  // between text and scale
      for (int x = place.x + 5; x < place.x + place.width - 5; ++x)
        if (std::abs(red(x, y) - red(place.x + 4, y)) > 20) middle[k] += x - place.x, ++count;
    ASSERT_GT(count, 300) << "pane " << k;
    middle[k] /= count;
  }
  EXPECT_NEAR(middle[1], middle[0], 2);
  EXPECT_GT(middle[2], middle[0] + 5) << "by 2 mm to the right";
}

// A ball of 0.1 mm beside one of 20 mm: at one scale it is a dot; if each fills its pane, both are equally large, and a
// camera that is turned and moved shows both from the same side.
TEST(SideBySide, EachStageFillsItsPane) {
  ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  const std::vector<Stage> stages{oneBall({0, 0, 0, 20, {200, 40, 40, 255}}), oneBall({70, 5, 0, 0.1f, {200, 40, 40, 255}})};
  ViewerState state;
  state.panels = false;
  showSideBySide(state, stages);
  PictureMaker maker(600, 300, 1, state);
  const auto pixels = [&] {  // of each ball
    const Picture picture = maker.draw();
    std::array<int, 2> count{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Viewport place = maker.layout().panes[k];
      const auto red = [&](int x, int y) { return static_cast<int>(picture.rgb[3 * static_cast<std::size_t>(y * picture.width + x)]); };
      for (int y = 0; y < 240; ++y)  // above the scale
        for (int x = place.x + 5; x < place.x + place.width - 5; ++x) count[k] += std::abs(red(x, y) - red(place.x + 4, y)) > 20;
    }
    return count;
  };
  frameWhole(state, maker.layout().panes[0]);
  EXPECT_LT(20 * pixels()[1], pixels()[0]);
  state.fills_panes = true;
  frameWhole(state, maker.layout().panes[0]);
  state.camera.orbit(0.4, 0.2);
  state.camera.pan(20, -10, maker.layout().panes[0]);
  const auto [large, small] = pixels();
  EXPECT_GT(large, 10'000);
  EXPECT_NEAR(small, large, 0.02 * large);
}

}  // namespace
}  // namespace spheretree::view
