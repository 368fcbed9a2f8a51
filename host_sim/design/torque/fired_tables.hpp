// SPDX-License-Identifier: MIT
// What of a tooth pattern can be told from torque while an engine fires, and what looks the same (firmware/torque/sd_fired.h).
#pragma once
#include <vector>

#include "design/torque/kalman_tables.hpp"

namespace sixdeg {

/// A pattern that looks like torque of the firings.
struct HiddenPattern {
    Eigen::VectorXd pattern;    ///< Over the columns of `mean_of_revolutions`: a pattern of length 1, mean 0.
    Eigen::VectorXd from_parts; ///< What the torque that looks like it reads, over J_mean w^2, of what a cycle shows of each column.
    Eigen::VectorXd of_firings; ///< The same of the firings' torques: 1 for the torque that a pattern of 1 looks like over J_mean w^2.
    double spread = 0;          ///< Rms over the firings of that torque over J_mean w^2, the mean of all firings taken out.
    bool common = false;        ///< The same in all firings.
};

struct FiredTables {
    /// [2 N][3 + firings], columns of length 1 at right angles: what phase, energy, load and firings that are not as expected make of the
    /// lateness of each tooth of a cycle. 0 where there is no tooth.
    Eigen::MatrixXd columns;
    Eigen::MatrixXd restore; ///< From what the mean of both revolutions shows in these columns to what was taken out of the pattern.
    std::vector<HiddenPattern> hidden;
    Eigen::VectorXd seen;    ///< Of the pattern in these columns, ascending: 0 nothing, 1 all; in every other direction all is seen.
};

/// For a rigid crank whose coefficients are firings.
FiredTables fired_tables(const EngineFile &engine, const KnownTorque &torque);

/// Writes them where sd_fired.h reads them, behind the rows. The tables must have their sizes, `parts` and `hidden` among them.
void put_fired(const FiredTables &fired, sd_kalman_tables_t &tables);

} // namespace sixdeg
