// SPDX-License-Identifier: Apache-2.0
// The contacts that hold the tool, as contacts() of step.h reports them.
#pragma once

#include "step/step_parts.h"

namespace spheretree::runtime {

/// Stores the contacts of the last QP: normals and forces of its active rows, which StepParts::keepActive() has named.
/// The tool was at `before` at the beginning of the step.
void noteContacts(const RowSet& set, const Configuration& before, const StepParts& parts);

}  // namespace spheretree::runtime
