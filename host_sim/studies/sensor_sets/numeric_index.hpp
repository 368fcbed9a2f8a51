// SPDX-License-Identifier: MIT
// Definition 3 the way document 002 had to compute it: ranks of a floating-point observability matrix. The
// answer hangs on the tolerance below which a singular value counts as zero and on the units, so both are
// parameters.
#pragma once
#include <vector>

#include "studies/sensor_sets/linear_point.hpp"

namespace sixdeg {

enum class Scaling {
    si,    ///< Jacobians as they are.
    sized, ///< Every state and sensor divided by its size.
    rows,  ///< Sized, and every row of the observability matrix brought to length one.
};

/// Index for each tolerance (relative to the greatest singular value), 0 where no number of derivatives
/// suffices.
std::vector<int> numeric_index(const Augmented &system, const std::vector<int> &targets, Scaling scaling,
                               const std::vector<double> &tolerances);

} // namespace sixdeg
