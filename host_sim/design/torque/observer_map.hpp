// SPDX-License-Identifier: MIT
// The adaptive Fourier observer as a linear map over one cycle, in double precision: what its gains make of errors, of
// known torques and of noise. docs/theory/torque.md, form B; missing teeth included.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "common/engine_file.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {

/// Columns are cases carried side by side; rows are energy, a_0, a_1, b_1, a_2 ... as the firmware orders them.
class ObserverMap {
  public:
    ObserverMap(const EngineFile &engine, const sd_parameters_t &tune);

    int positions() const { return positions_; } ///< A revolution.
    int coefficients() const { return int(gain_.size()); }
    /// Whether the energy half a pitch before cycle position k is measured: both teeth are there.
    bool measures(int k) const;
    /// What one cycle makes of the observer's error.
    Eigen::MatrixXd error_map() const;
    /// Coefficients at the end of a cycle in the steady state that repeats the energies [cycle position][case] (J, half
    /// a pitch before each position).
    Eigen::MatrixXd settled(const Eigen::MatrixXd &energy) const;
    /// Covariance of the coefficients at the end of a cycle for white errors of the tooth times, per unit of
    /// (J omega^2)^2 and of the variance of the angle that an error is worth, rad^2.
    Eigen::MatrixXd noise_covariance() const;

  private:
    void step(int k, Eigen::MatrixXd &state, const Eigen::RowVectorXd &energy) const;
    Eigen::MatrixXd run(Eigen::MatrixXd state, const Eigen::MatrixXd &energy) const;
    Eigen::VectorXd basis(int k) const;

    int positions_;
    double pitch_, gain_energy_;
    Eigen::VectorXd gain_; ///< l_j of each coefficient.
    std::vector<int> missing_;
};

} // namespace sixdeg
