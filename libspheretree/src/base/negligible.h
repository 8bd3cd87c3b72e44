// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace spheretree::builder {

/// Lengths below this share of the diagonal are in no figure: it is a tenth of the precision that all of them have
/// (docs/measures.md).
inline constexpr double kNegligible = 1e-6;

}  // namespace spheretree::builder
