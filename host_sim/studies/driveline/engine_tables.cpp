// SPDX-License-Identifier: MIT
#include "studies/driveline/engine_tables.hpp"

#include <fmt/format.h>
#include <functional>

#include "studies/driveline/own_torque.hpp"
#include "studies/driveline/shuffle_misfires.hpp"

namespace sixdeg {
namespace {

struct Row {
    const char *name;
    std::function<void(Scenario &)> change;
};

void stiffen(Scenario &s, double factor, bool same_torque) {
    Driveline &car = s.vehicle->car;
    car.soft_nmprad *= factor;
    car.stiff_nmprad *= factor;
    if (same_torque) car.kink_rad /= factor;
}

const Row kRows[] = {
    {"as believed", [](Scenario &) {}},
    {"friction takes 3 N m more than is believed", [](Scenario &s) { s.engine.fmep_pa[0] += 3 / s.engine.torque_of_mep_nm(1); }},
    {"damping +30 %", [](Scenario &s) { s.vehicle->car.damping_nms *= 1.3; }},
    {"stiffness -10 %, kink at the same torsion", [](Scenario &s) { stiffen(s, 0.9, false); }},
    {"stiffness +10 %, the same", [](Scenario &s) { stiffen(s, 1.1, false); }},
    {"stiffness -25 %, the same", [](Scenario &s) { stiffen(s, 0.75, false); }},
    {"stiffness +25 %, the same", [](Scenario &s) { stiffen(s, 1.25, false); }},
    {"tooth pattern 0.1 deg, learned in overrun", [](Scenario &s) { s.encoder.pattern_rms_deg = 0.1; }},
    {"one misfire in 50", [](Scenario &s) { s.misfire_rate = 0.02; }},
    {"injectors +6, -5, +4, -5 %", [](Scenario &s) { s.fuel_factor = {1.06, 0.95, 1.04, 0.95}; }},
    {"a road of 20 N m rms", [](Scenario &s) { s.road_rms_nm = 20; }},
    {"a slope of 50 N m that nobody knows of", [](Scenario &s) { s.vehicle->slope_nm = Profile(50.0); }},
};

void print_misfires(const ShuffleCase &c, const MisfireFigures &f) {
    const double judged = double(f.healthy + f.missed + f.partial);
    fmt::print("{:>6.0f}{:>6}{:>8.0f}{:>8.0f}  {:<8}{:>6} of {:<6}{:>4} of {:<7}{:>7.3f} %{:>9.2f}\n", c.speed_rpm, c.gear, c.road_nm,
               c.seconds, c.word ? "told" : "not told", f.detected, f.missed, f.false_alarms, f.healthy,
               100 * double(f.false_alarms) / double(f.healthy), 100 * judged / (judged + double(f.not_judged)));
}

} // namespace

void print_drive_header(const char *title) {
    fmt::print("\n{:<46}{:>8}{:>8}{:>7}{:>8}{:>8}{:>8}{:>9}{:>10}{:>8}{:>8}{:>8}\n", title, "changes", "missed", "extra", "mean", "rms",
               "p95", "wrong %", "torsion", "shaft", "bias", "told %");
}

void print_drive(const std::string &name, const DriveFigures &f) {
    fmt::print("{:<46}{:>8}{:>8}{:>7}{:>8.2f}{:>8.2f}{:>8.2f}{:>9.3f}{:>10.1e}{:>8.3f}{:>8.2f}{:>8.1f}\n", name, f.transitions, f.missed,
               f.extra, 1e3 * f.delay_mean_s, 1e3 * f.delay_rms_s, 1e3 * f.delay_p95_s, f.wrong_percent, f.twist_rms_rad, f.shaft_rms_nm,
               f.bias_mean_nm, f.told_percent);
}

void print_own_torque(double seconds, unsigned seed) {
    print_drive_header("behind an engine");
    for (const Row &row : kRows) {
        Scenario drive = own_torque_drive(seconds, seed);
        const EngineFile believed = drive.engine.shared;
        row.change(drive);
        const OwnTorqueFigures f = run_own_torque(drive, believed);
        print_drive(row.name, f.own);
        print_drive("  told the true torque", f.same);
        print_drive("  told the true torque, and believing it", f.believing);
        std::fflush(stdout);
    }
}

void print_shuffle_misfires(double seconds, unsigned seed) {
    fmt::print("\n{:>6}{:>6}{:>8}{:>8}  {:<8}{:>16}{:>24}{:>15}\n", "rpm", "gear", "road Nm", "s", "gear is", "misfires found",
               "false alarms", "judged, %");
    const double shorter = std::min(seconds, 300.0);
    for (const ShuffleCase &each : {ShuffleCase{seconds, 1000, 2}, ShuffleCase{seconds, 1000, 3}, ShuffleCase{shorter, 1000, 1},
                                    ShuffleCase{shorter, 3000, 1}, ShuffleCase{shorter, 3000, 2}, ShuffleCase{shorter, 3000, 3},
                                    ShuffleCase{shorter, 1000, 2, 60}, ShuffleCase{shorter, 3000, 2, 60}}) {
        ShuffleCase c = each;
        c.seed = seed;
        for (const bool word : {false, true}) {
            c.word = word;
            print_misfires(c, run_shuffle(c));
            std::fflush(stdout);
        }
    }
}

} // namespace sixdeg
