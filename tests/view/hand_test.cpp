// SPDX-License-Identifier: GPL-3.0-or-later
// From inputs to the intended pose of the hand: hand_input.h, hand_filter.h, space_mouse.h
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/input.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "hand/hand_filter.h"
#include "hand/hand_input.h"
#include "hand/rumble.h"
#include "hand/space_mouse.h"
#include "support/scratch_folder.h"

namespace spheretree::view {
namespace {

using Eigen::Vector3d;

Camera fromTheFront() {
  Camera camera;
  camera.lookFrom(1);
  return camera;
}

TEST(HandFilter, ArrivesWithoutOvershoot) {
  HandFilter filter;
  filter.resetTo({});
  const Configuration target{{2, 0, 0}, rotationOf({0, 0, 0.2})};
  double last = 0;
  for (int n = 0; n < 500; ++n) {
    const double x = filter.towards(target, 1e-3).position.x();
    EXPECT_GE(x, last);
    EXPECT_LE(x, 2 + 1e-9);
    last = x;
  }
  EXPECT_NEAR(last, 2, 1e-6);
  EXPECT_LT(displacementBetween(filter.pose(), target).rotation.norm(), 1e-6);
}

TEST(HandFilter, FollowsTheFormulaOfACriticallyDampedFilter) {
  HandFilter filter;
  filter.resetTo({});
  const double omega = 2 * 3.14159265358979 * 8;
  for (int n = 1; n <= 100; ++n) {
    const double t = n * 1e-3, expected = 1 - (1 + omega * t) * std::exp(-omega * t);
    EXPECT_NEAR(filter.towards({{1, 0, 0}, {1, 0, 0, 0}}, 1e-3).position.x(), expected, 1e-9) << n;
  }
}

TEST(HandFilter, IsNeverFasterThanAHand) {
  HandFilter filter;
  filter.resetTo({});
  Configuration before = filter.pose();
  for (int n = 0; n < 2000; ++n) {
    const Configuration target{n % 400 < 200 ? Vector3d(80, 0, 0) : Vector3d(-80, 30, 0), rotationOf({n % 300 < 150 ? 2.5 : -2.5, 0, 0})};
    const Configuration now = filter.towards(target, 1e-3);
    const Displacement way = displacementBetween(before, now);
    EXPECT_LE(way.translation.norm(), HandFilter::kFastest * 1e-3 + 1e-9);
    EXPECT_LE(way.rotation.norm(), HandFilter::kFastestTurn * 1e-3 + 1e-9);
    before = now;
  }
}

TEST(HandInput, ADragMovesTheHandWithThePointer) {
  HandInput hand;
  hand.resetTo({{3, 8, -2}, {1, 0, 0, 0}});
  Camera camera = fromTheFront();
  camera.orbit(0.4, 0.3);
  const Viewport viewport{0, 0, 640, 480};
  const Eigen::Vector2d before = *camera.pixelOf(hand.pose().position, viewport);
  hand.drag(40, -25, camera, viewport);
  const Eigen::Vector2d after = *camera.pixelOf(hand.pose().position, viewport);
  EXPECT_LT((after - before - Eigen::Vector2d(40, -25)).norm(), 1e-9);
  // By the length of the pixels there in millimetres, and not towards the eye.
  const Vector3d way = hand.pose().position - Vector3d(3, 8, -2);
  EXPECT_NEAR(way.norm(), std::hypot(40, 25) * camera.pixelAt({3, 8, -2}, viewport), 1e-9);
  EXPECT_NEAR(way.dot(camera.towardsEye()), 0, 1e-9);
}

TEST(HandInput, MotionsFollowTheView) {
  const Camera camera = fromTheFront();  // right is x, up is z, away is y
  HandInput hand;
  hand.push(2.5, camera);
  EXPECT_LT((hand.pose().position - Vector3d(0, 2.5, 0)).norm(), 1e-12);
  hand.resetTo({});
  hand.turn(10, 0, camera);  // to the right: about the axis that points up
  EXPECT_LT((rotationVector(hand.pose().orientation) - Vector3d(0, 0, 10 * HandInput::kTurnOfPixel)).norm(), 1e-12);
  hand.resetTo({});
  hand.hold({1, 0, 0, 0, 0, 0}, 0.5, camera);
  EXPECT_LT((hand.pose().position - Vector3d(0.5 * HandInput::kKeySpeed, 0, 0)).norm(), 1e-12);
}

TEST(HandInput, DiagonalKeysAreNoFaster) {
  HandInput hand;
  hand.hold({1, 1, 1, 0, 0, 0}, 1, fromTheFront());
  EXPECT_NEAR(hand.pose().position.norm(), HandInput::kKeySpeed, 1e-12);
}

TEST(HandInput, SticksHaveADeadZoneAndAFineMiddle) {
  EXPECT_EQ(withDeadZone(0.149, 0.15), 0);
  EXPECT_EQ(withDeadZone(-0.15, 0.15), 0);
  EXPECT_NEAR(withDeadZone(0.575, 0.15), 0.5, 1e-12);
  EXPECT_EQ(withDeadZone(-3, 0.15), -1);
  HandInput hand;
  hand.steer({0.5, 0, 0, 0, 0, 0}, 1, fromTheFront());
  EXPECT_NEAR(hand.pose().position.x(), HandInput::kStickSpeed / 8, 1e-12);
}

TEST(HandInput, GamepadAtRestMovesNothing) {
  for (const double d : gamepadDeflection({0.1f, -0.1f, 0.05f, 0, -1, -1}, false)) EXPECT_EQ(d, 0);
  const Deflection left_up = gamepadDeflection({-1, -1, 0, 0, -1, 1}, false);
  EXPECT_EQ(left_up[0], -1);
  EXPECT_EQ(left_up[1], 1);   // up is negative on a stick
  EXPECT_EQ(left_up[2], -1);  // the right trigger pushes away
  EXPECT_EQ(gamepadDeflection({0, 0, 1, 0, -1, -1}, false)[4], 1);
  EXPECT_EQ(gamepadDeflection({0, 0, 1, 0, -1, -1}, true)[5], -1);
}

/// Replaces spacenavd: a socket that accepts one connection and sends events.
class FakeDaemon {
 public:
  explicit FakeDaemon(const std::string& path) : listener_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
  }
  ~FakeDaemon() {
    close();
    ::close(listener_);
  }
  void accept() { connection_ = ::accept(listener_, nullptr, nullptr); }
  void send(const std::array<std::int32_t, 8>& event, std::size_t bytes = 32) {
    EXPECT_EQ(::send(connection_, event.data(), bytes, 0), static_cast<ssize_t>(bytes));
  }
  void close() {
    if (connection_ >= 0) ::close(connection_);
    connection_ = -1;
  }

 private:
  int listener_, connection_ = -1;
};

TEST(SpaceMouse, TakesTheNewestMotionAndNoticesTheEnd) {
  const test::ScratchFolder folder;
  const std::string path = (folder.path() / "spnav.sock").string();
  ::setenv("SPNAV_SOCKET", path.c_str(), 1);
  {
    const SpaceMouse nobody;
    EXPECT_FALSE(nobody.isOpen());
    EXPECT_NE(nobody.fault().find(path), std::string::npos);
  }
  FakeDaemon daemon(path);
  SpaceMouse mouse;
  ASSERT_TRUE(mouse.isOpen()) << mouse.fault();
  daemon.accept();
  EXPECT_EQ(mouse.poll(), (std::array<int, 6>{}));  // no event yet, and no waiting
  daemon.send({0, 10, 20, 30, 1, 2, 3, 16});
  daemon.send({1, 0, 1, 0, 0, 0, 0, 0});  // a button
  daemon.send({0, 350, -20, 30, 1, 2, 3, 16});
  EXPECT_EQ(mouse.poll(), (std::array<int, 6>{350, -20, -30, 1, 2, -3}));
  const std::array<std::int32_t, 8> halved{0, 7, 0, 0, 0, 0, 0, 0};
  daemon.send(halved, 12);  // an event in pieces waits for its rest
  EXPECT_EQ(mouse.poll()[0], 350);
  daemon.close();
  EXPECT_EQ(mouse.poll(), (std::array<int, 6>{}));
  ::unsetenv("SPNAV_SOCKET");
}

TEST(SpaceMouse, FullDeflectionIsOneAndNoiseIsNothing) {
  const Deflection d = spaceMouseDeflection({350, -700, 10, 0, 175, -10});
  EXPECT_EQ(d[0], 1);
  EXPECT_EQ(d[1], -1);
  EXPECT_EQ(d[2], 0);  // 10 of 350 is below 3 %
  EXPECT_NEAR(d[4], (0.5 - 0.03) / 0.97, 1e-12);
  EXPECT_EQ(d[5], 0);
}

TEST(RumbleSignal, AConstantForceIsStillAndAJumpIsFull) {
  RumbleSignal signal;
  for (int n = 0; n < 1000; ++n) signal.add({0, 0, 5}, 1e-3);
  EXPECT_EQ(signal.strength().strong, 0);
  EXPECT_EQ(signal.strength().weak, 0);
  signal.add({0, 0, 6.5}, 1e-3);
  EXPECT_GT(signal.strength().strong, 0.9);
  // A slow change of the same size, as of a hand that presses harder over a second, stays weak.
  for (int n = 0; n < 1000; ++n) signal.add({0, 0, 6.5}, 1e-3);
  for (int n = 0; n < 1000; ++n) signal.add({0, 0, 6.5 - 1.5e-3 * n}, 1e-3);
  EXPECT_LT(signal.strength().strong, 0.01);
}

/// The event interface of one gamepad, as the kernel answers.
struct FakePad {
  static inline int open_error = 0;  // of opening it for writing
  static inline bool has_motors = true, is_unplugged = false;
  static inline std::vector<ff_effect> effects;
  static inline std::vector<int> plays;
  static inline int open_files = 0;
  static const EventCalls& calls() {
    static const EventCalls calls{[](const char*, int flags) {
                                    if (open_error != 0 && (flags & O_ACCMODE) != O_RDONLY) return errno = open_error, -1;
                                    return ++open_files, 7;
                                  },
                                  [](int, unsigned long request, void* argument) {
                                    if (is_unplugged) return errno = ENODEV, -1;
                                    if (request == EVIOCGID) {
                                      *static_cast<input_id*>(argument) = {3, 0x045e, 0x028e, 0x110};
                                    } else if (request == EVIOCSFF) {
                                      auto& effect = *static_cast<ff_effect*>(argument);
                                      if (effect.id < 0) effect.id = 4;
                                      effects.push_back(effect);
                                    } else if (has_motors) {
                                      static_cast<unsigned long*>(argument)[FF_RUMBLE / 64] |= 1ul << (FF_RUMBLE % 64);
                                    }
                                    return 0;
                                  },
                                  [](int, const void* bytes, std::size_t count) {
                                    const auto& event = *static_cast<const input_event*>(bytes);
                                    EXPECT_EQ(event.type, EV_FF);
                                    EXPECT_EQ(event.code, 4);
                                    plays.push_back(event.value);
                                    return static_cast<long>(count);
                                  },
                                  [](int) { return --open_files, 0; }};
    return calls;
  }
};

TEST(Rumble, PlaysOnTheGamepadOfThisIdentity) {
  std::uint16_t vendor = 0, product = 0;
  ASSERT_TRUE(idsOfGamepad("030000005e0400008e02000010010000", vendor, product));
  EXPECT_EQ(vendor, 0x045e);
  EXPECT_EQ(product, 0x028e);
  EXPECT_FALSE(idsOfGamepad("78696e70757401000000000000000000x", vendor, product));
  const test::ScratchFolder folder;
  std::ofstream(folder.path() / "event3") << "";
  {
    Rumble rumble(0x045e, 0x028e, FakePad::calls(), folder.path());
    ASSERT_TRUE(rumble.isOpen()) << rumble.fault();
    rumble.set({});
    EXPECT_TRUE(FakePad::effects.empty()) << "nothing is sent while nothing happens";
    rumble.set({0.5, 1});
    rumble.set({1, 1});
    rumble.set({});
    rumble.set({});
    ASSERT_EQ(FakePad::effects.size(), 3u);
    EXPECT_EQ(FakePad::effects[0].u.rumble.strong_magnitude, 32768);
    EXPECT_EQ(FakePad::effects[0].u.rumble.weak_magnitude, 65535);
    EXPECT_EQ(FakePad::effects[1].id, 4) << "the same effect is changed";
    EXPECT_GT(FakePad::effects[0].replay.length, 0) << "the motors stop by themselves if the program hangs";
    EXPECT_EQ(FakePad::plays, (std::vector<int>{1, 1, 0}));
    FakePad::is_unplugged = true;
    rumble.set({1, 1});
    EXPECT_FALSE(rumble.isOpen());
    EXPECT_NE(rumble.fault().find("No such device"), std::string::npos) << rumble.fault();
    FakePad::is_unplugged = false;
  }
  EXPECT_EQ(FakePad::open_files, 0);
  EXPECT_FALSE(Rumble(0x045e, 1, FakePad::calls(), folder.path()).isOpen()) << "another gamepad";
  FakePad::open_error = EACCES;
  const std::string fault = Rumble(0x045e, 0x028e, FakePad::calls(), folder.path()).fault();
  EXPECT_NE(fault.find("event3: Permission denied"), std::string::npos) << fault;
  FakePad::open_error = 0;
  FakePad::has_motors = false;
  EXPECT_NE(Rumble(0x045e, 0x028e, FakePad::calls(), folder.path()).fault().find("no motors"), std::string::npos);
  EXPECT_EQ(FakePad::open_files, 0);
}

}  // namespace
}  // namespace spheretree::view
