// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_change.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/hull_fit.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

// What a change says of itself is so once it is made: nothing that became worse costs more than it.
void expectAsForetold(const HullComplex& before, const HullChange& change) {
  HullComplex after = before;
  after.apply(change);
  ASSERT_TRUE(test::isConsistent(after));
  EXPECT_TRUE(after.around(change.from).empty());
  for (std::size_t p = 0; p < after.samples().size(); ++p)
    EXPECT_LE(after.samples()[p].cost, std::max(before.samples()[p].cost, change.cost));
  for (const std::uint32_t i : after.around(change.to)) EXPECT_LE(after.simplices()[i].overhang, after.most());
}

TEST(HullChange, CollapsesCostWhatTheySay) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  const HullComplex complex = rig.joined();
  int found = 0;
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v)
    for (const std::uint32_t w : complex.neighbours(v))
      if (const HullChange change = collapseOf(complex, v, w, complex.most()); change.cost <= complex.most()) {
        ++found;
        expectAsForetold(complex, change);
      }
  EXPECT_GT(found, 10);
}

TEST(HullChange, MovesCostWhatTheySay) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  const HullComplex complex = rig.joined();
  test::Random random(4);
  int found = 0;
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v) {
    if (complex.around(v).empty()) continue;
    const Eigen::Vector3d c = complex.balls()[v].centre + 0.05 * random.direction();
    const HullChange change = moveOf(complex, v, {c, -rig.field.signedDistance(c)}, complex.most());
    if (!(change.cost <= complex.most())) continue;
    ++found;
    expectAsForetold(complex, change);
  }
  EXPECT_GT(found, 10);
}

}  // namespace
}  // namespace spheretree::builder
