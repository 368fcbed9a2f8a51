// SPDX-License-Identifier: MIT
// The air path of one run: model, actuators, sensors and faults, in steps of 1 ms whoever drives it, read every 10 ms.
//
//     AirPath air(data, engine.displacement_m3(), ratio, setup, seed);
//     air.start({speed_radps, fuel_kgps});
//     while (...) {
//         air.advance(time_s, {speed_radps, fuel_kgps}); // after each step of the crank, or every 10 ms without one
//         while (air.next(time_s, readings)) firmware(readings);
//     }
#pragma once
#include <array>
#include <deque>
#include <optional>

#include "plant/airpath/actuator.hpp"
#include "plant/airpath/full_model.hpp"
#include "plant/airpath/setup.hpp"

namespace sixdeg::airpath {

/// What the sensors say at one time, by Channel; none where one is silent.
struct Readings {
    double time_s = 0;
    std::array<std::optional<double>, kChannels> value{};
};

/// What is true at the same time.
struct Truth {
    double time_s = 0, speed_radps = 0, fuel_kgps = 0;
    double egr = 0, vgt = 0; ///< Positions.
    Flows flows;
    double egr_k = 0, turbo_radps = 0;
};

/// What the engine does to the air path.
struct EngineDrive {
    double speed_radps, fuel_kgps;
};

class AirPath {
  public:
    /// The same data, setup and seed give the same bits.
    AirPath(const FullData &data, double displacement_m3, double compression_ratio, const Setup &setup, std::uint64_t seed);

    /// Settles at the commands of time 0, which it is then.
    void start(const EngineDrive &engine);
    /// Takes the steps of 1 ms that end by time_s.
    void advance(double time_s, const EngineDrive &engine);
    /// Readings taken before time_s, in order; `truth`, where given, gets the truth of the same time. False if none waits.
    bool next(double time_s, Readings &readings, Truth *truth = nullptr);

    double intake_pa() const { return model_.flows().intake_pa; }
    double exhaust_pa() const { return model_.flows().exhaust_pa; }
    const FullModel &model() const { return model_; }

  private:
    struct Sample {
        Readings readings;
        Truth truth;
    };
    std::array<double, kChannels> seen_now() const;
    void read(double time_s, const EngineDrive &engine);

    Setup setup_;
    FullModel model_;
    Actuator egr_, vgt_;
    RandomStream random_;
    std::array<double, kChannels> seen_{}, share_{}; ///< Behind the sensors' lags; of a step that they follow in 1 ms.
    std::array<std::optional<double>, kChannels> last_{}; ///< What was read last.
    std::int64_t steps_ = 0; ///< Of 1 ms since time 0.
    std::deque<Sample> samples_;
};

} // namespace sixdeg::airpath
