// SPDX-License-Identifier: MIT
#include "studies/driveline/driveline_study.hpp"

#include <filesystem>
#include <fmt/format.h>

#include "common/files.hpp"
#include "common/progress.hpp"
#include "plant/engine/units.hpp"
#include "studies/driveline/damping_case.hpp"
#include "studies/driveline/engine_tables.hpp"
#include "studies/driveline/figure_six.hpp"
#include "studies/driveline/fixed_beside.hpp"
#include "studies/driveline/manoeuvres.hpp"

namespace sixdeg {
namespace {

struct Options {
    double seconds;
    unsigned seed;
    std::string folder;
};

// ---- Figure 6 ------------------------------------------------------------------------------------------------------

void print_figure(const char *name, const FigureSixCase &c, const std::string &csv) {
    const FigureSix figure = run_figure_six(c);
    const Delays found = delays(figure);
    fmt::print("\nFigure 6, {}: threshold {} rpm, left after {:.0f} ms at the latest\n", name, c.belief.threshold_rpm,
               1e3 * c.belief.hold_s);
    for (std::size_t i = 0; i < figure.real.size(); ++i) {
        const LocationChange &real = figure.real[i];
        const std::string late = found.late_s[i] < 0 ? "not before the next" : fmt::format("{:.1f} ms later", 1e3 * found.late_s[i]);
        fmt::print("  {:.4f} s  {} -> {}   found {}\n", real.time_s, real.from, real.to, late);
    }
    fmt::print("  found and not there: {}; wrong {:.1f} % of the time from 2 s on; torsion off by {:.4f} rad at most\n", found.false_ones,
               figure.wrong_percent, figure.largest_error_rad);
    if (!csv.empty()) write_file(csv, figure_six_csv(figure));
}

void print_bounds(const char *name, const FigureSixCase &c) {
    const HybridBelief &b = c.belief;
    const double ratio = c.driveline.ratios[0];
    const Eigen::Vector3d push(0, -ratio / c.driveline.engine_inertia_kgm2, 1 / c.driveline.vehicle_inertia_kgm2);
    fmt::print("\npropositions, {}\n", name);
    std::vector<Eigen::Matrix3d> f;
    for (Location q : {3, 2}) {
        const LocationModel m = location_model(c.driveline, ratio, b.equilibrium_rad, q);
        for (const Eigen::Vector3d &poles : {b.residual_poles, Eigen::Vector3d(-360, -420, -480)}) {
            const ResidualSpeed s = residual_speed(m.a - observer_gain(m, poles) * m.c, m.c, 0.05, 1, 0.1);
            fmt::print("  3.1.1, location {}, poles {:g}: largest real part {:.0f}, needed {:.0f} for 0.1 rpm in 50 ms ({}); k {:.0f}\n",
                       q, poles(0),
                       s.abscissa, s.needed, s.holds() ? "holds" : "does not hold", s.condition);
        }
        const LocationModel other = location_model(c.driveline, ratio, b.equilibrium_rad, 5 - q);
        const std::optional<int> order = hiding_order(m, other, observer_gain(other, b.residual_poles));
        fmt::print("  3.1.3, in location {} believed {}: the document's condition does not hold; an input reaches the residual at order "
                   "{}\n", q, 5 - q,
                   order.value_or(0));
        f.push_back(m.a - observer_gain(m, b.observer_poles) * m.c);
        const double drive = push.norm() * 25;
        const ErrorBound bound = error_bound(f.back(), 0.08, 0.02, drive);
        fmt::print("  3.3.1, location {}, changes 80 ms apart found within 20 ms, 25 N m: n k exp(a D) {:.3g}, so {}; as printed {:.3g}\n",
                   q,
                   bound.contraction, bound.bound ? fmt::format("{:.3g}", *bound.bound) : "no bound follows",
                       printed_bound(f.back(), 0.08, 0.02, drive));
    }
}

void figure_6(const Options &options) {
    if (!options.folder.empty()) std::filesystem::create_directories(options.folder);
    const auto csv = [&](const char *name) { return options.folder.empty() ? "" : options.folder + "/" + name; };
    FigureSixCase at_once = canonical_figure();
    at_once.belief.hold_s = 0;
    print_figure("canonical driveline", canonical_figure(), csv("figure_6.csv"));
    print_figure("canonical driveline, a location may be left at once", at_once, "");
    print_figure("a driveline that visits location 1 too", three_location_figure(), csv("figure_6_three.csv"));
    print_bounds("canonical driveline", canonical_figure());
}

// ---- locations 1 and 3 -----------------------------------------------------------------------------------------------

void ambiguity(const Options &) {
    fmt::print("\nlocations 1 and 3: what their residual generators hold after 1.9 s in location 3\n");
    for (const auto &[name, figure] : {std::pair{"canonical", canonical_figure()}, {"three locations", three_location_figure()}}) {
        FigureSixCase c = figure;
        c.duration_s = 1.9;
        const FigureSixRow last = run_figure_six(c).rows.back();
        const Driveline &d = c.driveline;
        fmt::print("  {:<16} r1 {:.5f}, r3 {:.5f} rpm; torsion of 1 less that of 3 {:.4f} rad, -2 (k1 - k) theta1 / k1 = {:.4f}\n", name,
                   last.residual_rpm[0], last.residual_rpm[2], last.generator_rad[0] - last.generator_rad[2],
                   -2 * (d.stiff_nmprad - d.soft_nmprad) * d.kink_rad / d.stiff_nmprad);
    }
}

// ---- the published bank on teeth ----------------------------------------------------------------------------------------

void teeth(const Options &) {
    fmt::print("\nthe published bank on the speed of the last tooth (60-2), Figure 6's four changes in 10 s\n"
               "  {:>10} {:>8} {:>14} {:>8} {:>8} {:>10} {:>14}\n", "jitter deg", "poles", "threshold rpm", "missed", "false", "wrong %",
                   "torsion rad");
    for (const double jitter : {0.0, 0.02}) {
        for (const double scale : {1.0, 0.5, 0.25}) {
            for (const double threshold : {0.02, 0.2, 2.0, 20.0}) {
                FigureSixCase c = canonical_figure();
                c.jitter_deg = jitter;
                c.belief.residual_poles *= scale;
                c.belief.threshold_rpm = threshold;
                c.duration_s = 10;
                const FigureSix figure = run_figure_six(c);
                const Delays found = delays(figure);
                fmt::print("  {:>10} {:>8.0f} {:>14} {:>8} {:>8} {:>10.1f} {:>14.4f}\n", jitter, c.belief.residual_poles(0), threshold,
                           found.missed,
                           found.false_ones, figure.wrong_percent, figure.largest_error_rad);
            }
        }
    }
}

// ---- the guard filter ----------------------------------------------------------------------------------------------------

struct Row {
    std::string name;
    std::function<void(DriveCase &)> change;
};

void stiffen(DriveCase &c, double factor, bool same_torque) {
    c.real.soft_nmprad *= factor;
    c.real.stiff_nmprad *= factor;
    if (same_torque) c.real.kink_rad /= factor;
}

std::vector<Row> common_rows() {
    std::vector<Row> rows{{"nominal", [](DriveCase &) {}},
                          {"torque told 3 N m too high", [](DriveCase &c) { c.torque_error_nm = 3; }},
                          {"damping +30 %", [](DriveCase &c) { c.real.damping_nms *= 1.3; }}};
    for (const double percent : {-10, 10, -25, 25}) {
        rows.push_back({fmt::format("stiffness {:+g} %, kink at the same torsion", percent),
                        [percent](DriveCase &c) { stiffen(c, 1 + percent / 100, false); }});
        if (percent < 0) {
            rows.push_back({fmt::format("stiffness {:+g} %, kink at the same torque", percent),
                            [percent](DriveCase &c) { stiffen(c, 1 + percent / 100, true); }});
        }
    }
    rows.push_back({"a slope of 50 N m that nobody knows of", [](DriveCase &c) { c.slope_nm = 50; }});
    return rows;
}

void with_wheel_teeth(DriveCase &c) {
    c.wheel_jitter_deg = 0.05;
    c.belief.wheel_jitter_rad = 0.05 * kRadPerDeg;
    c.belief.twist_walk_rad = 1e-3;
}

void drive(const Options &options) {
    std::vector<Row> wheel_faults{{"firing ripple 60 N m", [](DriveCase &c) { c.ripple_nm = 60; }},
                                  {"tooth pattern 0.1 deg, not learned", [](DriveCase &c) { c.pattern_deg = 0.1; }},
                                  {"tooth pattern 0.1 deg, learned", [](DriveCase &c) { c.pattern_deg = 0.1, c.pattern_known = true; }}};
    const auto table = [&](const char *title, const std::vector<Row> &rows, const std::function<void(DriveCase &)> &all) {
        print_drive_header(title);
        Progress progress("row", double(rows.size()));
        for (const Row &row : rows) {
            DriveCase c = usual_drive();
            c.duration_s = options.seconds;
            c.seed = options.seed;
            all(c);
            row.change(c);
            print_drive(row.name, run_drive(c));
            progress.next();
        }
    };
    fmt::print("\n{:.0f} s of driving; delays in ms, torsion in rad rms, torque of the shaft and bias at the crank in N m\n",
               options.seconds);
    std::vector<Row> rows = common_rows();
    rows.insert(rows.end(), wheel_faults.begin(), wheel_faults.end());
    table("guard in angle", rows, [](DriveCase &) {});
    table("guard in torque", common_rows(), [](DriveCase &c) { c.guard = SD_GUARD_TORQUE; });
    table("guard in angle, and 48 wheel teeth of 0.05 deg", common_rows(), with_wheel_teeth);
}

/// What is missing laid to the road in place of the engine.
void slope(const Options &options) {
    print_drive_header("the road's torque walks, the engine's is believed");
    const Row rows[] = {{"nominal", [](DriveCase &) {}},
                        {"torque told 3 N m too high", [](DriveCase &c) { c.torque_error_nm = 3; }},
                        {"a slope of 50 N m that nobody knows of", [](DriveCase &c) { c.slope_nm = 50; }}};
    for (const double walk : {1.0, 5.0}) {
        for (const Row &row : rows) {
            DriveCase c = usual_drive();
            c.duration_s = options.seconds;
            c.seed = options.seed;
            c.belief.bias_walk_nm = 0.01;
            c.belief.road_walk_radps = walk;
            row.change(c);
            print_drive(fmt::format("{:g} rad/s a second: {}", walk, row.name), run_drive(c));
        }
    }
}

/// The same teeth in both arithmetics.
void fixed_point(const Options &options) {
    fmt::print("\n{:.0f} s of driving, guard filter in q31 beside f32\n  {:<42}{:>9}{:>10}{:>8}{:>20}{:>24}{:>28}\n", options.seconds, "",
               "teeth", "location", "health", "apart rms, most", "wrong % f32, q31", "torsion rms f32, q31");
    std::vector<Row> rows = common_rows();
    rows.push_back({"firing ripple 60 N m", [](DriveCase &c) { c.ripple_nm = 60; }});
    rows.push_back({"guard in torque", [](DriveCase &c) { c.guard = SD_GUARD_TORQUE; }});
    rows.push_back({"48 wheel teeth of 0.05 deg", with_wheel_teeth});
    Progress progress("row", double(rows.size()));
    for (const Row &row : rows) {
        DriveCase c = usual_drive();
        c.duration_s = options.seconds;
        c.seed = options.seed;
        row.change(c);
        const Beside b = fixed_beside(c);
        fmt::print("  {:<42}{:>9}{:>10}{:>8}{:>11.1e}{:>9.1e}{:>14.4f}{:>10.4f}{:>16.2e}{:>12.2e}\n", row.name, b.teeth, b.other_location,
                   b.other_health, b.twist_apart_rms_rad, b.twist_apart_most_rad, b.f32.wrong_percent, b.q31.wrong_percent,
                   b.f32.twist_rms_rad, b.q31.twist_rms_rad);
        progress.next();
    }
}

void print_manoeuvres(const Options &options) {
    print_drive_header("manoeuvres, guard in angle");
    for (const Manoeuvre &m : manoeuvres()) {
        DriveCase c = usual_drive();
        c.seed = options.seed;
        print_drive(m.name, run_manoeuvre(m, c));
    }
}

void damping(const Options &) {
    fmt::print("\nactive damping of a tip-out: second swing of the shaft's torque at the crank, N m\n  {:<18}{:>8}{:>9}{:>9}{:>11}\n", "",
               "off", "damped",
               "request", "told %");
    for (const double factor : {1.0, 0.8, 1.2}) {
        DampingCase c;
        stiffen(c.drive, factor, false);
        const double off = run_damping(c).second_swing_nm;
        c.damping.enabled = 1;
        const DampingFigures f = run_damping(c);
        fmt::print("  stiffness {:>+4.0f} %  {:>8.1f}{:>9.1f}{:>9.1f}{:>11.1f}\n", 100 * factor - 100, off, f.second_swing_nm,
                   f.largest_request_nm,
                   f.told_percent);
    }
    for (const double at_s : {2.0, 3.1, 3.3, 4.0}) {
        DampingCase c;
        c.damping.enabled = 1;
        c.wrong_at_s = at_s;
        fmt::print("  put into a wrong location at {} s: no request after {:.1f} ms\n", at_s, 1e3 * run_damping(c).off_after_s);
    }
}

void own_torque(const Options &options) { print_own_torque(options.seconds, options.seed); }
void misfire(const Options &options) { print_shuffle_misfires(options.seconds, options.seed); }

struct Part {
    const char *name;
    void (*print)(const Options &);
};
constexpr Part kParts[] = {{"figure-6", figure_6}, {"ambiguity", ambiguity}, {"teeth", teeth}, {"drive", drive}, {"slope", slope},
                           {"fixed-point", fixed_point},
                           {"manoeuvres", print_manoeuvres}, {"damping", damping},
                           {"own-torque", own_torque}, {"misfire", misfire}};

} // namespace

std::vector<std::string> driveline_study_parts() {
    std::vector<std::string> names;
    for (const Part &part : kParts) names.push_back(part.name);
    return names;
}

void print_driveline_study(const std::string &part, double seconds, unsigned seed, const std::string &folder) {
    Progress progress("part", part.empty() ? double(std::size(kParts)) : 1);
    for (const Part &p : kParts) {
        if (!part.empty() && part != p.name) continue;
        p.print({seconds, seed, folder});
        progress.next();
    }
}

} // namespace sixdeg
