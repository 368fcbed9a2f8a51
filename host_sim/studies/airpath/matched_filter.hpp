// SPDX-License-Identifier: MIT
// An extended Kalman filter of the matched plant: what can be known of it, and, with both flows' errors as further states, the augmented
// filter that the observers are compared with.
#pragma once
#include <Eigen/Core>

#include "studies/airpath/matched_run.hpp"

namespace sixdeg {

class MatchedFilter {
  public:
    /// walk_gps: of each flow's error in a step; 0: there is none, and four states.
    explicit MatchedFilter(const MatchedSetup &setup, double walk_gps = 0);

    /// A period on; the innovations of the two outputs, kPa.
    Eigen::Vector2d step(const sd_airpath_in_f32_t &in);
    const Eigen::Matrix2d &innovation_covariance() const { return s_; }
    /// EGR and turbine flow beyond the model's, g/s.
    Eigen::Vector2d flow_error() const { return x_.tail<2>(); }
    Eigen::Matrix2d flow_covariance() const { return p_.bottomRightCorner<2, 2>(); }

  private:
    using State = Eigen::Matrix<double, 6, 1>; ///< kPa, g, g, g, g/s, g/s.
    State moved(const State &x, const sd_airpath_in_f32_t &in) const;

    const MatchedSetup *setup_;
    double walk_gps_;
    bool begun_ = false;
    MeanValueModel model_; ///< For its flows.
    State x_ = State::Zero();
    Eigen::Matrix<double, 6, 6> p_ = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix2d s_ = Eigen::Matrix2d::Identity();
};

} // namespace sixdeg
