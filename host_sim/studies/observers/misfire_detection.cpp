// SPDX-License-Identifier: MIT
#include "studies/observers/misfire_detection.hpp"

#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "design/calibration.hpp"
#include "studies/observers/input_wheel.hpp"
#include "studies/observers/recorded_run.hpp"

namespace sixdeg {
namespace {

constexpr double kRampShare = 0.2, kRampS = 4;

/// What one method said of each firing.
struct Judged {
    std::vector<FiringVerdict> verdicts;
    MisfireFigures figures;
};

Judged judge(const Scenario &scenario, const PlantRecord &record, std::vector<FiringVerdict> verdicts) {
    const MisfireFigures figures = score_of(verdicts, record, scenario.engine.shared).result();
    return {std::move(verdicts), figures};
}

std::vector<FiringVerdict> observe_inputs(const Scenario &scenario, const sd_calibration_t &page, const PlantRecord &record) {
    std::vector<FiringVerdict> verdicts;
    InputWheel wheel(scenario.engine.shared, page);
    for (const sd_event_t &event : record.events) {
        if (const auto firing = wheel.take(event)) verdicts.push_back({event.tick, firing->cylinder, firing->verdict, firing->strength, 0,
                                                                       SD_VALID});
    }
    return verdicts;
}

void compare(const Judged &a, const Judged &b, Detection &detection) {
    for (std::size_t i = 0; i < std::min(a.verdicts.size(), b.verdicts.size()); ++i) {
        if (a.verdicts[i].verdict == SD_NOT_JUDGED && b.verdicts[i].verdict == SD_NOT_JUDGED) continue;
        ++detection.compared;
        detection.differing += a.verdicts[i].verdict != b.verdicts[i].verdict;
    }
}

} // namespace

std::vector<DetectionCell> detection_cells() {
    std::vector<DetectionCell> cells;
    for (const bool ramp : {false, true}) {
        for (const int rpm : {900, 1500, 3000, 6000}) {
            for (const double bar : {1.0, 10.0}) cells.push_back({rpm, bar, ramp});
        }
    }
    return cells;
}

Scenario detection_scenario(const DetectionCell &cell, int cycles, std::uint64_t seed) {
    std::string speed = fmt::format("rpm = {}", cell.rpm);
    if (cell.ramp) {
        std::string rpm, time;
        const double end_s = 1.3 * cycles * 120.0 / cell.rpm;
        for (int k = 0; k * kRampS < end_s + kRampS; ++k) {
            rpm += fmt::format("{}{}", k ? ", " : "", cell.rpm * (k % 2 ? 1 + kRampShare : 1 - kRampShare));
            time += fmt::format("{}{}", k ? ", " : "", k * kRampS);
        }
        speed = fmt::format("rpm = [{}]\ntime_s = [{}]", rpm, time);
    }
    TomlFile file("cell", fmt::format("engine = \"diesel_22.toml\"\nseed = {}\n[run]\ncycles = {}\n[speed]\n{}\n[load]\nbmep_bar = {}\n"
                                      "[cyclic]\ncov_percent = 5\n[misfires]\none_in = 50\n[encoder]\njitter_deg = 0.01\n",
                                      seed, cycles, speed, cell.bmep_bar));
    Scenario scenario = read_scenario(file, SD_DATA "/engines");
    if (cell.rpm < 1000) scenario.engine.shared.inertia_kgm2 *= 3;
    return scenario;
}

Detection run_detection(const Scenario &scenario, const std::vector<std::string> &parameters) {
    Detection detection;
    PlantRecord record;
    TomlFile tune("tune", "");
    for (const std::string &parameter : parameters) tune.set(parameter);
    const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "tune");
    const auto bench = std::make_unique<EcuBench>(page);
    bench->listen([&](bool out, const sd_event_t &event) { record.hear(out, event); });
    detection.run = run_scenario(scenario, page, *bench, nullptr, &record);
    constexpr const char *kNames[] = {"FOLSMO", "FOSMO", "ROO"};
    for (int method = 1; method <= 3; ++method) {
        const Judged f32 = judge(scenario, record, verdicts_on(record, with_method(page, method, 0)));
        const Judged q31 = judge(scenario, record, verdicts_on(record, with_method(page, method, 1)));
        detection.rows.push_back({kNames[method - 1], f32.figures});
        detection.rows.push_back({std::string(kNames[method - 1]) + " q31", q31.figures});
        compare(f32, q31, detection);
    }
    detection.rows.push_back({"input observer", judge(scenario, record, observe_inputs(scenario, page, record)).figures});
    detection.rows.push_back({"monitor", detection.run.misfire});
    return detection;
}

} // namespace sixdeg
