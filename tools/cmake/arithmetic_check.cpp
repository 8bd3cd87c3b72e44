// SPDX-License-Identifier: Apache-2.0
// Prints what of the arithmetic that the proofs rest on is wrong with the options that this file is compiled with, and
// what to do. CMake compiles and runs it when the project is configured.
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <limits>

#include "spheretree/core/rounding.h"

namespace {

int faults = 0;
void expect(bool right, const char* otherwise) {
  if (!right) std::printf("  %s\n", otherwise), ++faults;
}

/// The same number, which the compiler does not know any more.
template <class Number>
Number unknown(Number x) {
  volatile Number hidden = x;
  return hidden;
}

// Functions of their own, as a library has them.
[[gnu::noinline]] void roundPair(const double* in, double* out) {
  const float x = static_cast<float>(in[0]), y = static_cast<float>(in[1]);
  out[0] = x, out[1] = y;
}
[[gnu::noinline]] void roundStored(const double* in, double* out) {
  const float x = spheretree::roundToFloat(in[0]), y = spheretree::roundToFloat(in[1]);
  out[0] = x, out[1] = y;
}
[[gnu::noinline]] double fused(const double* v) { return v[0] * v[1] - v[2]; }
[[gnu::noinline]] double reordered(const double* v) { return (v[0] + v[1]) - v[0]; }
[[gnu::noinline]] float quotient(const float* v) { return v[0] / v[1]; }
[[gnu::noinline]] bool isNumber(const double* v) { return v[0] == v[0]; }
[[gnu::noinline]] double halved(const double* v) { return 0.5 * v[0]; }

}  // namespace

int main() {
  const double in[2] = {unknown(0.1), unknown(0.2)};
  double out[2];
  const auto rounds = [&] { return out[0] == 0.100000001490116119384765625 && out[1] == 0.20000000298023223876953125; };
  roundPair(in, out);
  expect(rounds(), "numbers are not rounded to float: -fno-tree-slp-vectorize is needed, or another compiler");
  roundStored(in, out);
  expect(rounds(), "roundToFloat() does not round: this compiler needs a barrier of its own in spheretree/core/rounding.h");
  const double third[3] = {unknown(1.0 / 3), unknown(3.0), unknown(1.0)};
  expect(fused(third) == 0, "products and sums are fused: remove -ffp-contract=fast");
  const double far[2] = {unknown(0x1p60), unknown(1.0)};
  expect(reordered(far) == 0, "sums are reordered: remove -ffast-math, -Ofast, -fassociative-math");
  const float seventh[2] = {unknown(1.0f), unknown(7.0f)};
  expect(quotient(seventh) == 0x1.24924ap-3f, "quotients are approximate: remove -mrecip, -freciprocal-math, -ffast-math");
  const double nan[1] = {unknown(std::numeric_limits<double>::quiet_NaN())};
  expect(!isNumber(nan) && std::isnan(nan[0]), "NaN is not seen: remove -ffinite-math-only, -ffast-math");
  const double least[1] = {unknown(std::numeric_limits<double>::min())};
  expect(halved(least) > 0, "small numbers become 0: remove -ffast-math and -mdaz-ftz, also where programs are linked");
  expect(FLT_EVAL_METHOD == 0, "numbers have more digits than their type: use -mfpmath=sse");
#if defined(__AVX__) || defined(__FMA__)
  expect(false, "Eigen would add in another order: remove -march=native and -mavx; the runtime finds its kernels for the processor itself");
#endif
  return faults;
}
