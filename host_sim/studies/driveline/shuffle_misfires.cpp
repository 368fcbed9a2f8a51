// SPDX-License-Identifier: MIT
#include "studies/driveline/shuffle_misfires.hpp"

#include "design/calibration.hpp"
#include "loop/bench_run.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

Profile load(double seconds) {
    std::vector<double> time, pa;
    for (double t = 2; t < seconds; t += 3) {
        time.insert(time.end(), {t, t + 0.1, t + 1, t + 1.1});
        pa.insert(pa.end(), {1e5, 4e5, 4e5, 1e5});
    }
    return Profile(time, pa);
}

} // namespace

MisfireFigures run_shuffle(const ShuffleCase &c) {
    Scenario s = read_scenario(std::filesystem::path(SD_DATA "/scenarios/shuffle.toml"));
    s.duration_s = c.seconds;
    s.seed = c.seed;
    s.speed_radps = Profile(c.speed_rpm * kRadpsPerRpm);
    s.bmep_pa = load(c.seconds);
    s.cyclic_cov = Profile(0.2);
    s.encoder.jitter_deg = 0.01;
    s.vehicle->gear = std::size_t(c.gear - 1);
    s.vehicle->tell_gear = c.word;
    s.road_rms_nm = c.road_nm;
    TomlFile tune("tune", "");
    return run_on_bench(s, calibrate(s.engine.shared, read_tune(tune), "tune"), nullptr).misfire;
}

} // namespace sixdeg
