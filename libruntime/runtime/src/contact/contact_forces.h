// SPDX-License-Identifier: Apache-2.0
// The solver of the contact problem.
//
// Method: Newton's method with whole steps, which sweeps over the contacts start anew; then, for what it leaves open,
// two convex problems by the proximal point method: docs/algorithms/runtime/contact_forces.md.
// Papers: P. Alart, A. Curnier. A mixed formulation for frictional contact problems prone to Newton like solution
// methods. Comput. Methods Appl. Mech. Engrg. 92, 1991. M. Jean. The non-smooth contact dynamics method. Ibid. 177,
// 1999. G. De Saxce, Z.-Q. Feng. The bipotential method. Math. Comput. Modelling 28, 1998. R. T. Rockafellar. Augmented
// Lagrangians and applications of the proximal point algorithm in convex programming. Math. Oper. Res. 1(2), 1976.
// No allocation. Deterministic.
#pragma once

#include "contact/contact_problem.h"

namespace spheretree::runtime {

/// `compliance`: null without tissue. The rows must have a common solution. Any guess is allowed. Whatever happens, the
/// forces press and lie in their discs. Returns the work, in the unit of StepLimits::max_work; after `max_work` nothing
/// more is tried. Cost, with a good guess: two or three iterations of 0.4 us for a contact with friction, of 4 us for
/// five.
std::uint32_t solveForces(ContactProblem& problem, const SurfaceCompliance* compliance, std::uint32_t max_work) noexcept;

}  // namespace spheretree::runtime
