// SPDX-License-Identifier: MIT
// The diagnosis on a plant that obeys its own model: document 001's four states, inputs that wander about one point, noise.
#pragma once
#include <array>
#include <string>

#include "common/random.hpp"
#include "design/airpath/airpath_tables.hpp"
#include "plant/airpath/mean_value.hpp"

namespace sixdeg {

/// Of the two pressures and the air flow, in standard deviations of each.
using MatchedNoise = std::array<double, 3>;

/// An air path and its design, as files name them.
struct MatchedSetup {
    AirPathSystem system;
    double displaced_m3 = 0;
    AirPathDesign design;
};
MatchedSetup read_matched_setup(const std::string &air_path_file, const std::string &design_file);

struct MatchedFault {
    const char *name;
    double egr = 0, vgt = 0; ///< Added to the true positions.
    std::uint8_t actuator = SD_AIRPATH_NO_FAULT;
};
const std::array<MatchedFault, 4> &matched_faults();

constexpr double kMatchedPeriodS = 0.01;

/// Plant, sensors and bank. Copies go on alike.
class MatchedRun {
  public:
    MatchedRun(const MatchedSetup &setup, double detect, double isolate, RandomStream &random);

    void set_fault(const MatchedFault &fault) { fault_ = fault; }
    /// 10 ms of the plant, and the bank with what sensors then say.
    void step(const MatchedNoise &noise);
    const sd_airpath_out_f32_t &out() const { return out_; }
    const sd_airpath_bank_f32_t &bank() const { return bank_; }
    const MeanValueModel &plant() const { return plant_; }
    const sd_airpath_in_f32_t &readings() const { return in_; }
    bool decides() const { return out_.phase == SD_AIRPATH_DECIDES; }

  private:
    /// Two sines of random period and phase about a middle.
    struct Wander {
        double middle, amplitude, phase[2], radps[2];
        double at(double time_s) const;
    };
    MeanValueInput input(double time_s) const;
    void read(const MatchedNoise &noise);

    const MatchedSetup *setup_;
    sd_airpath_config_f32_t config_;
    std::array<Wander, 4> wander_;
    MeanValueModel plant_;
    MatchedFault fault_{"", 0, 0, SD_AIRPATH_NO_FAULT};
    sd_airpath_bank_f32_t bank_{};
    sd_airpath_in_f32_t in_{};
    sd_airpath_out_f32_t out_{};
    long steps_ = 0;
};

MatchedNoise draw_noise(RandomStream &random);

} // namespace sixdeg
