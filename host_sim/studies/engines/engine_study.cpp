// SPDX-License-Identifier: MIT
#include "studies/engines/engine_study.hpp"

#include <fmt/format.h>
#include <limits>

#include "common/files.hpp"
#include "common/progress.hpp"
#include "common/random.hpp"
#include "design/calibration.hpp"
#include "studies/engines/engine_figures.hpp"

namespace sixdeg {
namespace {

constexpr int kCycles = 80; ///< Of a run that is scored, FiringScore::kSettleCycles of them left out.
constexpr const char *kFuel = "fuel_percent = [10, 0, 0, -20]\n";
constexpr double kFourierPatternDeg = 0.02;
constexpr std::uint32_t kDriveStream = 302; ///< Of random numbers; beside those of common/streams.hpp.
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// What a file that says nothing of its tolerances may be off by: belief less truth.
constexpr double kInertiaPercent = -3, kCompressionPercent = 2, kWheelDeg = -0.3;
constexpr const char *kWrong = ", file with J -3 %, compression ratio +2 %, wheel -0.3 deg";

/// The pages that all engines share.
struct Pages {
    sd_calibration_t right, wrong;
    EngineFile file;
};

Pages make_pages() {
    EngineFile file = nominal_engine(EngineKind::rigid), wrong = file;
    wrong.inertia_kgm2 *= 1 + kInertiaPercent / 100, wrong.compression_ratio *= 1 + kCompressionPercent / 100;
    wrong.position_0_deg += kWheelDeg;
    TomlFile tune("tune", "");
    const sd_parameters_t parameters = read_tune(tune);
    return {calibrate(file, parameters, "tune"), calibrate(wrong, parameters, "tune"), file};
}

std::string at_speed(double rpm) { return fmt::format("[speed]\nrpm = {:g}\n", rpm); }

/// What is learned without fuel; `speed` is the table [speed], `seconds` from the first on.
sd_kept_t learn_in_cut(const SetEngine &engine, const sd_calibration_t &page, const std::string &speed, double seconds) {
    const Scenario lesson = made_scenario(engine, fmt::format("[run]\nduration_s = {0:g}\n{1}[load]\nbmep_bar = 0\n"
                                                              "fuel_cut_s = [0.1, {0:g}]\n[encoder]\njitter_deg = 0.01\n", seconds, speed));
    return run_on_bench(lesson, page, nullptr).learned;
}

sd_kept_t learn_at_two(const SetEngine &engine, const sd_calibration_t &page) {
    return learn_in_cut(engine, page, "[speed]\nrpm = [3000, 3000, 1500, 1500]\ntime_s = [0, 3, 4, 8]\n", 8);
}

RunResult run_at(const SetEngine &engine, double rpm, double bar, const sd_calibration_t &page, const sd_kept_t &learned) {
    const Scenario scenario = made_scenario(engine, fmt::format("[run]\ncycles = {}\n{}[load]\nbmep_bar = {:g}\n[cylinders]\n{}"
                                                                "[encoder]\njitter_deg = 0.01\n", kCycles, at_speed(rpm), bar, kFuel));
    return run_on_bench(scenario, page, nullptr, &learned);
}

std::string point_name(double rpm, double bar) { return fmt::format("{:g} rpm {:g} bar", rpm, bar); }

struct Point {
    double rpm, bar;
};
constexpr Point kPoints[] = {{1000, 5}, {1500, 2}, {1500, 5}, {3000, 5}, {3000, 9}, {4500, 5}};
constexpr double kBar = 5;

/// Level, waveform, and actual over stated, after a fuel cut at two speeds.
void cut(const SetEngine &engine, const Pages &pages, EngineFigures &figures) {
    for (const bool wrong : {false, true}) {
        const sd_calibration_t &page = wrong ? pages.wrong : pages.right;
        const sd_kept_t learned = learn_at_two(engine, page);
        const std::string file = wrong ? kWrong : ", right file";
        for (const Point &p : kPoints) {
            const RunResult run = run_at(engine, p.rpm, p.bar, page, learned);
            if (!run.firing || !run.waveform) continue;
            const auto row = [&](const char *what, const char *unit, FigureGoal goal, double value) {
                figures.add(engine, what + file, point_name(p.rpm, p.bar), unit, goal, value);
            };
            row("level of torque", " %", {0, wrong ? 6.0 : 3.0}, run.firing->bias_percent);
            if (p.bar == kBar) {
                row("imbalance", " %", {0, kNoLimit}, run.firing->imbalance_percent);
                const FigureGoal goal = wrong ? FigureGoal{0.67, 1.5} : FigureGoal{0.5, kNoLimit};
                row("imbalance, actual over stated", "", goal, run.firing->imbalance_honesty);
            }
            if (wrong) continue;
            row("waveform, shift", " deg", {0, 0.2}, run.waveform->shift_deg);
            row("waveform, rms", " %", {0, 1}, run.waveform->rms_true_percent);
        }
    }
}

/// Level at another speed than that of the fuel cut.
void one_speed(const SetEngine &engine, const Pages &pages, EngineFigures &figures) {
    const std::pair<const char *, sd_kept_t> lessons[] = {
        {"level after a fuel cut at 1500 rpm alone", learn_in_cut(engine, pages.right, at_speed(1500), 5)},
        {"level after a coast from 1800 to 1370 rpm",
         learn_in_cut(engine, pages.right, "[speed]\nrpm = [1800, 1800, 1370]\ntime_s = [0, 1, 4]\n", 4)}};
    for (const auto &[what, learned] : lessons) {
        const RunResult run = run_at(engine, 4500, kBar, pages.right, learned);
        if (run.firing) figures.add(engine, what, point_name(4500, kBar), " %", {0, 4}, run.firing->bias_percent);
    }
}

/// Imbalance by the Fourier observer.
void fourier(const SetEngine &drawn, const Pages &pages, EngineFigures &figures) {
    SetEngine engine = drawn;
    engine.pattern_rms_deg = kFourierPatternDeg;
    const sd_kept_t learned = learn_at_two(engine, pages.right);
    for (const auto &[rpm, goal] : {std::pair{3000.0, 0.5}, std::pair{4500.0, 1.0}}) {
        const RunResult run = run_at(engine, rpm, kBar, pages.right, learned);
        if (!run.cylinders) continue;
        figures.add(engine, "imbalance by the Fourier observer, pattern 0.02 deg, worst cylinder", point_name(rpm, kBar), " %", {0, goal},
                    run.cylinders->imbalance_percent);
    }
}

/// A drive of 60 s over 12 points, drawn; no fuel cut.
sd_kept_t learn_on_a_drive(const SetEngine &engine, const sd_calibration_t &page) {
    RandomStream random(engine.seed, kDriveStream);
    std::string rpm, bar, time;
    for (int i = 0; i < 12; ++i) {
        const double speed = 1000 + 3500 * random.uniform(), load = 2 + 5 * random.uniform();
        for (const double at_s : {5.0 * i, 5.0 * i + 4}) {
            rpm += fmt::format("{:.0f}, ", speed), bar += fmt::format("{:.2f}, ", load), time += fmt::format("{:g}, ", at_s);
        }
    }
    const std::string text = fmt::format("[run]\nduration_s = 60\n[speed]\nrpm = [{0}]\ntime_s = [{2}]\n[load]\nbmep_bar = [{1}]\n"
                                         "time_s = [{2}]\n[cylinders]\n{3}[encoder]\njitter_deg = 0.01\n", rpm, bar, time, kFuel);
    return run_on_bench(made_scenario(engine, text), page, nullptr).learned;
}

void firing(const SetEngine &engine, const Pages &pages, EngineFigures &figures) {
    const sd_kept_t learned = learn_on_a_drive(engine, pages.right);
    for (const auto &[rpm, goal] : {std::pair{1000.0, 0.25}, std::pair{3000.0, 0.30}, std::pair{4500.0, 0.55}}) {
        const RunResult run = run_at(engine, rpm, kBar, pages.right, learned);
        if (!run.firing) continue;
        figures.add(engine, "imbalance after 60 s of driving without a fuel cut", point_name(rpm, kBar), " %", {0, goal},
                    run.firing->imbalance_percent);
        figures.add(engine, "the same, actual over stated", point_name(rpm, kBar), "", {0, kNoLimit}, run.firing->imbalance_honesty);
    }
}

struct Part {
    const char *name;
    void (*run)(const SetEngine &, const Pages &, EngineFigures &);
};
constexpr Part kParts[] = {{"fuel-cut", cut}, {"one-speed", one_speed}, {"fourier", fourier}, {"driving", firing}};

} // namespace

std::vector<std::string> engine_study_parts() {
    std::vector<std::string> parts;
    for (const Part &part : kParts) parts.emplace_back(part.name);
    return parts;
}

void print_engine_study(const EngineStudy &study) {
    const Pages pages = make_pages();
    EngineFigures figures;
    Progress progress("engine", 2.0 * study.engines * (study.part.empty() ? std::size(kParts) : 1));
    for (const Part &part : kParts) {
        if (!study.part.empty() && study.part != part.name) continue;
        for (const Physics physics : {Physics::own, Physics::other}) {
            for (const SetEngine &engine : draw_engines(EngineKind::rigid, physics, study.engines, study.seed)) {
                part.run(engine, pages, figures);
                progress.next();
            }
        }
    }
    fmt::print("{}", figures.table());
    if (study.out.empty()) return;
    OutputFolder out(study.out);
    out.add("engines.csv", figures.csv());
    out.commit();
}

} // namespace sixdeg
