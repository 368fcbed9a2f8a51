// SPDX-License-Identifier: MIT
#include "studies/airpath/full_study.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/progress.hpp"
#include "common/random.hpp"

namespace sixdeg {
namespace {

constexpr double kLearnedS = 12, kWaitS = 8; // faults come after offsets are learned; then so long is waited
constexpr std::uint32_t kWhen = 950;         // stream of the faults' times

/// Bounds of a share that k of n runs suggest, 95 %, after E. B. Wilson, 1927.
std::pair<double, double> share_bounds(int k, int n) {
    constexpr double z = 1.96;
    const double p = double(k) / n, middle = (p + z * z / (2 * n)) / (1 + z * z / n);
    const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4.0 * n * n));
    return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

/// Of the false alarms and transients: with few runs a look is enough.
double share_of(const FullStudy &study) { return study.runs >= 50 ? 1 : study.runs / 500.0; }

struct Counts {
    int runs = 0, early = 0, right = 0, wrong = 0, unclear = 0, silent = 0, not_ready = 0, suspect = 0;
    std::vector<double> delays;
};

/// First what the bank says of the fault, then whether it is right: a wrong actuator counts even where the right one follows.
void judge(const FaultCase &fault, const FullResult &result, double from_s, double to_s, Counts &counts) {
    ++counts.runs;
    counts.suspect += result.suspect;
    if (result.decides_s < 0 || result.decides_s > from_s) {
        ++counts.not_ready;
        return;
    }
    if (result.first(0, from_s)) {
        ++counts.early;
        return;
    }
    bool right = false, wrong = false, unclear = false;
    for (const Alarm &alarm : result.alarms) {
        if (alarm.time_s >= to_s) break;
        if (alarm.fault == fault.may_name && !right) {
            right = true;
            counts.delays.push_back(alarm.time_s - from_s);
        }
        wrong = wrong || (alarm.fault != SD_AIRPATH_UNCLEAR && alarm.fault != fault.may_name && !(fault.may_name & alarm.fault));
        unclear = unclear || alarm.fault == SD_AIRPATH_UNCLEAR;
    }
    if (wrong) ++counts.wrong;
    else if (right) ++counts.right;
    else if (unclear) ++counts.unclear;
    else ++counts.silent;
}

/// Moves valve and vanes to and fro every 2 s from from_s on.
void move_actuators(FullCase &c, double from_s) {
    for (Profile *command : {&c.setup.egr, &c.setup.vgt}) {
        std::vector<double> time = command->x(), value = command->value();
        for (std::size_t i = 0; i < time.size(); ++i)
            if (time[i] >= from_s && std::fmod(time[i] - from_s, 4) >= 2) value[i] += 0.1;
        *command = Profile(std::move(time), std::move(value));
    }
}

Counts measure(const FullStudy &study, const FaultCase &fault, int runs, std::uint64_t first_seed) {
    Counts counts;
    Progress progress(fault.name, runs);
    for (int i = 0; i < runs; ++i, progress.next()) {
        const std::uint64_t seed = first_seed + std::uint64_t(i);
        const double from_s = kLearnedS + 2 * RandomStream(seed, kWhen).uniform();
        FullCase c = wandering(from_s + kWaitS, seed);
        c.setup.faults = fault.faults;
        for (airpath::Fault &f : c.setup.faults) f.from_s = from_s;
        if (fault.moving) move_actuators(c, from_s);
        judge(fault, judge_full(study.engine, study.tables, study.config, c), from_s, c.seconds, counts);
    }
    return counts;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return NAN;
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1, std::size_t(share * double(values.size())))];
}

void print_delays(const FullStudy &study) {
    fmt::print("delay of a step, {} runs each: mean, 90 %, within 8 s found, wrong actuator (95 % of the share), "
               "alarms before, suspect offsets\n",
               study.runs);
    std::uint64_t seed = study.seed;
    for (const FaultCase &fault : step_cases()) {
        const Counts c = measure(study, fault, study.runs, seed);
        seed += std::uint64_t(study.runs);
        double sum = 0;
        for (double d : c.delays) sum += d;
        const auto bounds = share_bounds(c.wrong, c.runs);
        fmt::print("  {:<10} {:.3f} s  {:.3f} s  {:6.2f} %  {} ({:.2f} to {:.2f} %)  {}  {}\n", fault.name, sum / double(c.delays.size()),
                   quantile(c.delays, 0.9), 100.0 * double(c.delays.size()) / c.runs, c.wrong, 100 * bounds.first, 100 * bounds.second,
                       c.early,
                   c.suspect);
    }
}

void print_false_alarms(const FullStudy &study) {
    constexpr int kPieces = 8;
    const double piece_s = 900 * share_of(study);
    int alarms = 0;
    double judged_s = 0;
    Progress progress("piece", kPieces);
    for (int i = 0; i < kPieces; ++i, progress.next()) {
        const FullResult r = judge_full(study.engine, study.tables, study.config, wandering(piece_s, study.seed + 100000 +
            std::uint64_t(i)));
        alarms += int(r.alarms.size());
        if (r.decides_s >= 0) judged_s += piece_s - r.decides_s;
    }
    fmt::print("false alarms: {} in {:.2f} h of wandering operation\n", alarms, judged_s / 3600);
}

void print_transients(const FullStudy &study) {
    const int count = int(200 * share_of(study));
    constexpr double kRampS = 5;
    int steps = 0, ramps = 0;
    Progress progress("transient", count);
    for (int i = 0; i < count; ++i, progress.next()) {
        const std::uint64_t seed = study.seed + 200000 + std::uint64_t(i);
        RandomStream random(seed, kWhen);
        FullCase step = wandering(24, seed);
        add_load_step(step, kLearnedS, kLearnedS + 6, 1e5 * (4 + 9 * random.uniform()));
        steps += !judge_full(study.engine, study.tables, study.config, step).alarms.empty();
        FullCase ramp = wandering(24, seed + 200);
        ramp.speed_radps = Profile({kLearnedS, kLearnedS + kRampS}, {1000 * kRadpsPerRpm, 2000 * kRadpsPerRpm});
        ramps += !judge_full(study.engine, study.tables, study.config, ramp).alarms.empty();
    }
    fmt::print("runs with an alarm: {} of {} load steps from 8 to 4..13 bar and back, {} of {} ramps from 1000 to 2000 rpm in {:g} s\n",
        steps, count,
               ramps, count, kRampS);
}

void print_others(const FullStudy &study) {
    const int runs = std::max(study.runs / 5, 1);
    fmt::print("other faults, {} runs each: named rightly, a wrong actuator named, unclear, nothing said\n", runs);
    std::uint64_t seed = study.seed + 300000;
    for (const FaultCase &fault : other_cases()) {
        const Counts c = measure(study, fault, runs, seed);
        seed += std::uint64_t(runs);
        fmt::print("  {:<36} {:4d} {:4d} {:4d} {:4d}\n", fault.name, c.right, c.wrong, c.unclear, c.silent + c.early + c.not_ready);
    }
}

} // namespace

void print_full_study(const FullStudy &study) {
    print_delays(study);
    print_false_alarms(study);
    print_transients(study);
    print_others(study);
}

} // namespace sixdeg
