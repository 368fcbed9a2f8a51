// SPDX-License-Identifier: MIT
// The crank of document 000 with an unknown strength E_n of every cylinder: a Kalman filter. Ours, and no part of the firmware:
// docs/results/observers.md has the figures that decided so.
//
//   v1' = v2,  v2' = -k2 v2 - k1 v1 + sum over n of E_n (C Q_n),  E_n a random walk,  y = v1 + noise
// The document's observers take the nominal input, so a misfire that nobody told them of stays in their estimate
// forever. Here E_n is a state: 1 is a cylinder that does what its input says, 0 a misfire.
//
// The step is exact for the mean input of each cylinder over it. The covariance runs along, in Joseph's form: at a fixed sampling
// time firings never fall on the same samples twice, so no table of gains would serve, and it gives every estimate its standard
// deviation. Two innovations in a row beyond `alarm_sd` deviations, on the same side, mean that the active cylinder no longer does
// what it did: its E is then learned anew, from deviation 1 (while its input acts; else v2 is, from start_accel).
#pragma once
#include <vector>

#include "design/misfire/switched_design.hpp"
extern "C" {
#include "sd_status.h"
}

namespace sixdeg {

/// Units of v1 as the caller chooses; those of v2 and the input follow from the step's.
struct InputConfig {
    PlantStep step;        ///< Of the plant (plant_step), over a sampling interval or a tooth.
    int inputs = 0;        ///< Cylinders, and whatever else has a strength; at least 1.
    double noise = 0;      ///< Standard deviation of y, above 0.
    double start_speed = 0, start_accel = 0; ///< Deviations of v1 and v2 at the start, above 0.
    double start_strength = 0; ///< Deviation of each E_n at the start, (0, 1].
    double walk_strength = 0;  ///< Deviation of each E_n's walk in one step, [0, 1].
    double alarm_sd = 0;       ///< [3, 100].
    long settle_steps = 0;     ///< Steps until the estimate counts as converged.
};

class InputObserver {
  public:
    /// Throws std::invalid_argument where a field is out of its range. Starts not running.
    explicit InputObserver(const InputConfig &config);
    /// Begins with v1 and v2 as given and each E_n (empty: all 1). Not finite: stays not running.
    void start(double speed, double accel, const std::vector<double> &strengths = {});
    /// One step to sample y. input: mean of C Q_n over it for E_n = 1. active: whose firing interval it is. Not running: starts at y. y not
    /// finite: predicts only; 12 in a row, or an input that is not finite: stops running. Returns v2, 0 while not running; never NaN.
    double step(double y, const std::vector<double> &input, int active);

    bool running() const { return running_; }
    double speed() const { return state_[0]; }
    double accel() const { return state_[1]; }
    double accel_sd() const;
    double strength(int n) const { return state_[std::size_t(n) + 2]; }
    double strength_sd(int n) const;
    long alarms() const { return alarms_; }   ///< Since the start.
    long rejected() const { return rejected_; } ///< Samples left out.
    sd_health_t health() const;

  private:
    std::size_t states() const { return state_.size(); }
    double &p(std::size_t i, std::size_t j) { return covariance_[i * states() + j]; }
    double p(std::size_t i, std::size_t j) const { return covariance_[i * states() + j]; }
    void transform(const std::vector<double> &input, double *x, std::size_t stride) const;
    void predict(const std::vector<double> &input);
    void watch(double squared, const std::vector<double> &input, std::size_t active);
    void correct(double y, const std::vector<double> &input, std::size_t active);
    bool sound() const;
    void stop();

    InputConfig config_;
    std::vector<double> state_, covariance_;
    double innovation_ = 0;
    long steps_ = 0, alarms_ = 0, rejected_ = 0;
    int rejected_in_row_ = 0, last_side_ = 0;
    bool running_ = false;
};

} // namespace sixdeg
