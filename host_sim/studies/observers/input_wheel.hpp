// SPDX-License-Identifier: MIT
// The observer of every cylinder's input on the toothed wheel, in the angle domain, from the events that an ecu gets. It decodes
// them by the firmware's own decoder. State v1, v2, E_1 ... E_n; v1 is w^2/2 over its mean, less 1, so
// that jitter is as large at every speed.
#pragma once
#include <memory>
#include <optional>

#include "design/misfire/wheel_design.hpp"
#include "studies/observers/input_observer.hpp"

extern "C" {
#include "hal.h"
}

namespace sixdeg {

/// Beside the crank's model (wheel_model): what the covariance is told.
struct InputTune {
    double jitter_deg = 0.01; ///< Of an edge.
    double walk = 0.05;       ///< Of each strength, a tooth.
    double alarm_sd = 4;
};

class InputWheel {
  public:
    struct Firing {
        int cylinder, verdict; ///< Physical; sd_verdict_t.
        double strength;       ///< E_n as it is read, 300 deg after the TDC.
    };
    /// `page` must outlive it, and hold the wheel's tables.
    InputWheel(const EngineFile &engine, const sd_calibration_t &page, const InputTune &tune = {});
    /// An event as the ecu gets it. The firing that is read at it, if any.
    std::optional<Firing> take(const sd_event_t &event);

  private:
    std::optional<Firing> tooth(const sd_tooth_t &tooth);
    void step(std::uint32_t k, const sd_tooth_t &tooth, bool measured);
    Firing read(std::uint32_t lane) const;
    double pulse_positions() const;

    const EngineFile &engine_;
    const sd_calibration_t &page_;
    WheelModel model_;
    sd_crank_t crank_{};
    PlantStep step_;
    InputObserver observer_;
    double load_[2] = {};                ///< v1, v2 that the load alone makes.
    double mean_ = 0, fuel_mg_ = -1;     ///< Mean of j w^2/2, (rad/s)^2; the command now.
    std::vector<double> work_j_;         ///< Commanded at the last TDC of each firing; below 0 unknown.
    int active_ = 0, burning_ = -1;      ///< Whose interval it is; whose pulse, -1: nobody's.
    int settled_ = 0;                    ///< Teeth since it began.
};

} // namespace sixdeg
