// SPDX-License-Identifier: Apache-2.0
// Newton's method on the weights of a patch: what the searches for the foot of a ball and of a hull share.
#pragma once

#include "kernel/lanes.h"

namespace spheretree::runtime {
namespace {

constexpr int kNewtonSteps = 6;        // to the foot of a ball on a patch; usually 2 or 3
constexpr float kLastStep = 3e-4f;     // in weights: convergence is quadratic, and the next step would be below 1e-6
constexpr float kLongestStep = 0.35f;  // in weights: beyond this the quadratic model is unreliable
constexpr float kOutside = 0.1f;       // in weights: how far an iterate may leave the patch
constexpr float kFootFound = 1e-3f;    // in weights: largest last step of an accepted foot; convergence is quadratic

// Makes a step from the weights u and v of corners 1 and 2, whose larger component is `size_of_step`: no longer than
// kLongestStep, and not far out of the patch. Returns the way that was made.
inline F8 stepOn(const F8& du, const F8& dv, const F8& size_of_step, F8& u, F8& v) {
  const F8 one = splat(1), zero = splat(0), low = splat(-kOutside), high = splat(1 + kOutside), half = splat(0.5f);
  const F8 shorter = minOf(one, splat(kLongestStep) / maxOf(size_of_step, splat(1e-9f)));
  F8 to_u = u + shorter * du, to_v = v + shorter * dv;
  const F8 excess = half * maxOf(zero, to_u + to_v - high);
  to_u = maxOf(low, minOf(to_u - excess, high));
  to_v = maxOf(low, minOf(to_v - excess, high));
  const F8 moved = maxOf(size(to_u - u), size(to_v - v));
  u = to_u;
  v = to_v;
  return moved;
}

}  // namespace
}  // namespace spheretree::runtime
