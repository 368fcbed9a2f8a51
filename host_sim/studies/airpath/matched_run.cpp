// SPDX-License-Identifier: MIT
#include "studies/airpath/matched_run.hpp"

#include <cmath>

#include "common/toml_file.hpp"

namespace sixdeg {
namespace {

constexpr double kPlantStepS = 0.005, kFuelGps = 7, kAirNoise = 0.01;
constexpr double kRadpsPerRpm = M_PI / 30;
constexpr std::uint32_t kSettleSteps = 100;

} // namespace

const std::array<MatchedFault, 4> &matched_faults() {
    static const std::array<MatchedFault, 4> faults{{{"EGR 0.1", 0.1, 0, SD_AIRPATH_EGR_FAULT},
                                                     {"VGT 0.1", 0, -0.1, SD_AIRPATH_VGT_FAULT},
                                                     {"EGR 0.05", 0.05, 0, SD_AIRPATH_EGR_FAULT},
                                                     {"VGT 0.05", 0, -0.05, SD_AIRPATH_VGT_FAULT}}};
    return faults;
}

MatchedSetup read_matched_setup(const std::string &air_path_file, const std::string &design_file) {
    MatchedSetup setup;
    TomlFile file{std::filesystem::path(air_path_file)};
    setup.system = *read_air_path(file);
    const double bore = file.number("cylinders.bore_m", {0.02, 0.5, "m"}), stroke = file.number("cylinders.stroke_m", {0.02, 0.5, "m"});
    setup.displaced_m3 = M_PI / 4 * bore * bore * stroke * double(file.numbers("cylinders.firing_order", {1, 8, ""}).size());
    TomlFile design{std::filesystem::path(design_file)};
    setup.design = read_air_path_design(design, setup.system, setup.displaced_m3);
    design.finish();
    return setup;
}

double MatchedRun::Wander::at(double t) const {
    return middle + amplitude / 2 * (std::sin(radps[0] * t + phase[0]) + std::sin(radps[1] * t + phase[1]));
}

MatchedRun::MatchedRun(const MatchedSetup &setup, double detect, double isolate, RandomStream &random)
    : setup_(&setup), config_{kSettleSteps, 0, {float(detect), float(isolate)}}, plant_(setup.system, setup.displaced_m3) {
    const double middle[] = {1500 * kRadpsPerRpm, 0.113, 0.35, 0.44}, amplitude[] = {60 * kRadpsPerRpm, 0.06 * 0.113, 0.05, 0.04};
    for (std::size_t i = 0; i < wander_.size(); ++i) {
        wander_[i].middle = middle[i], wander_[i].amplitude = amplitude[i];
        for (int j = 0; j < 2; ++j) {
            wander_[i].phase[j] = 2 * M_PI * random.uniform();
            wander_[i].radps[j] = 2 * M_PI / (3 + 17 * random.uniform());
        }
    }
    sd_airpath_start_f32(&bank_);
    plant_.rest(input(0));
}

MeanValueInput MatchedRun::input(double t) const {
    return {wander_[0].at(t), wander_[1].at(t), 1e-3 * kFuelGps, wander_[2].at(t) + fault_.egr, wander_[3].at(t) + fault_.vgt};
}

void MatchedRun::read(const MatchedNoise &noise) {
    const double t = double(steps_) * kMatchedPeriodS;
    const double *sigma = setup_->design.sigma_kpa;
    in_.speed_rpm = float(wander_[0].at(t) / kRadpsPerRpm);
    in_.air_gps = float(1e3 * wander_[1].at(t) * (1 + kAirNoise * noise[2]));
    in_.fuel_gps = float(kFuelGps);
    in_.charge_k = float(setup_->system.charge_k), in_.egr_k = float(setup_->system.egr_k), in_.exhaust_k = float(setup_->system.exhaust_k);
    in_.egr_opening = float(wander_[2].at(t)), in_.vgt_position = float(wander_[3].at(t));
    in_.intake_kpa = float(1e-3 * plant_.intake_pa() + sigma[0] * noise[0]);
    in_.exhaust_kpa = float(1e-3 * plant_.exhaust_pa() + sigma[1] * noise[1]);
}

void MatchedRun::step(const MatchedNoise &noise) {
    const double t = double(steps_) * kMatchedPeriodS;
    for (double at = 0; at < kMatchedPeriodS - 1e-9; at += kPlantStepS) plant_.step(input(t + at + kPlantStepS / 2), kPlantStepS);
    steps_++;
    read(noise);
    sd_airpath_step_f32(&bank_, &setup_->design.tables, &config_, &in_, &out_);
}

MatchedNoise draw_noise(RandomStream &random) {
    const double a = random.normal(), b = random.normal(), c = random.normal();
    return {a, b, c};
}

} // namespace sixdeg
