// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_laws.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

using test::Random;

constexpr double kFriction = 0.4, kRadius = 0.5, kNormal = 0.8;

struct Case {
  const char* name;
  Law law;
  ContactPart part;
};

class ContactLaws : public testing::TestWithParam<Case> {
 protected:
  const ContactPart& part() const { return GetParam().part; }
  void nearest(double* z, Slopes* slopes = nullptr) const { nearestForce(GetParam().law, part(), kNormal, z, slopes); }
  void draw(Random& random, double* z) const {
    for (std::size_t a = 0; a < part().size; ++a) z[a] = random.between(-2, 2);
  }
};

// No other allowed force is nearer, and an allowed one stays.
TEST_P(ContactLaws, TheNearestForceIsAllowedAndNearest) {
  Random random(1);
  for (int run = 0; run < 2000; ++run) {
    double z[3], to[3], other[3];
    draw(random, z);
    std::copy_n(z, 3, to);
    nearest(to);
    double again[3] = {to[0], to[1], to[2]};
    nearest(again);
    draw(random, other);
    nearest(other);
    double near = 0, far = 0;
    for (std::size_t a = 0; a < part().size; ++a) {
      ASSERT_NEAR(again[a], to[a], 1e-12) << run;
      near += (to[a] - z[a]) * (to[a] - z[a]);
      far += (other[a] - z[a]) * (other[a] - z[a]);
    }
    // With Coulomb's law, the disc of a contact that does not press is that of its present normal force no more.
    const bool is_projection = GetParam().law != Law::Coulomb || part().size < 3 || z[0] > 0;
    ASSERT_TRUE(!is_projection || near <= far + 1e-12) << run;
  }
}

TEST_P(ContactLaws, SlopesAreDifferences) {
  Random random(2);
  constexpr double kStep = 1e-6;
  for (int run = 0; run < 2000; ++run) {
    double z[3];
    draw(random, z);
    Slopes slopes;
    double at[3] = {z[0], z[1], z[2]};
    nearest(at, &slopes);
    for (std::size_t b = 0; b < part().size; ++b) {
      double more[3] = {z[0], z[1], z[2]}, less[3] = {z[0], z[1], z[2]};
      more[b] += kStep, less[b] -= kStep;
      Slopes after, before;
      nearest(more, &after);
      nearest(less, &before);
      for (std::size_t a = 0; a < part().size; ++a) {
        if (std::abs(after.by[a][b] - before.by[a][b]) > 1e-3) continue;  // a kink lies between
        ASSERT_NEAR(slopes.by[a][b], (more[a] - less[a]) / (2 * kStep), 1e-4) << run << ' ' << a << ' ' << b;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ContactLaws,
                         testing::Values(Case{"Row", Law::Coulomb, {{}, 1, 0, 0}}, Case{"Disc", Law::Coulomb, {{}, 2, 0, kRadius}},
                                         Case{"Coulomb", Law::Coulomb, {{}, 3, kFriction, 0}},
                                         Case{"Discs", Law::Discs, {{}, 3, kFriction, kRadius}},
                                         Case{"Cones", Law::Cones, {{}, 3, kFriction, 0}}),
                         [](const auto& of) { return of.param.name; });

// The disc of a contact that slips widens with the normal force.
TEST(ContactLaws, ADiscWidensWithItsNormalForce) {
  const ContactPart part{{}, 3, kFriction, 0};
  double less[3] = {1, 3, 4}, more[3] = {1, 3, 4}, at[3] = {1, 3, 4};
  Slopes slopes;
  nearestForce(Law::Coulomb, part, kNormal, at, &slopes);
  nearestForce(Law::Coulomb, part, kNormal - 0.01, less, nullptr);
  nearestForce(Law::Coulomb, part, kNormal + 0.01, more, nullptr);
  for (std::size_t a = 1; a < 3; ++a) EXPECT_NEAR(slopes.widening[a], (more[a] - less[a]) / 0.02, 1e-9);
}

}  // namespace
}  // namespace spheretree::runtime
