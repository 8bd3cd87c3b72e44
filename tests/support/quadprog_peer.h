// SPDX-License-Identifier: Apache-2.0
// An independent QP solver, if this machine has one: qpgen2, the Fortran reference of Goldfarb and Idnani's method by
// B. A. Turlach, out of Debian's r-cran-quadprog. Opened at run time; nothing of the project needs it.
#pragma once

#if __has_include(<dlfcn.h>)
#include <dlfcn.h>
#endif

#include <algorithm>
#include <cstddef>
#include <vector>

namespace spheretree::test {

class QuadprogPeer {
 public:
  QuadprogPeer() {
#if __has_include(<dlfcn.h>)
    if (void* library = dlopen("/usr/lib/R/site-library/quadprog/libs/quadprog.so", RTLD_NOW | RTLD_LOCAL))
      solve_ = reinterpret_cast<Solve*>(dlsym(library, "qpgen2_"));
#endif
  }
  bool isThere() const { return solve_ != nullptr; }

  /// Space for problems of `rows` rows, so that solve() allocates nothing.
  void reserve(std::size_t rows) {
    multiplier_.resize(rows + 6);
    active_.resize(rows + 6);
    work_.resize(2 * 6 + 6 * (6 + 5) / 2 + 2 * rows + 16);
  }
  /// minimise |y - target|^2 / 2 subject to a_i . y >= b_i. `a`: row by row, `b`: both may be changed. False if
  /// infeasible.
  bool solve(double* a, double* b, int rows, const double* target, double* y) {
    double hessian[36] = {}, linear[6], value = 0;
    for (int k = 0; k < 6; ++k) {
      hessian[7 * k] = 1;
      linear[k] = target[k];
    }
    int n = 6, count = rows, equalities = 0, active_count = 0, iterations[2] = {}, status = 1;  // 1: the Hessian comes factored
    solve_(hessian, linear, &n, &n, y, multiplier_.data(), &value, a, b, &n, &count, &equalities, active_.data(), &active_count, iterations,
           work_.data(), &status);
    return status == 0;
  }

 private:
  using Solve = void(double*, double*, int*, int*, double*, double*, double*, double*, double*, int*, int*, int*, int*, int*, int*, double*,
                     int*);
  Solve* solve_ = nullptr;
  std::vector<double> multiplier_, work_;
  std::vector<int> active_;
};

}  // namespace spheretree::test
