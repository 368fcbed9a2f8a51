// SPDX-License-Identifier: MIT
#include "studies/observers/observer_bench.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "design/misfire/switched_design.hpp"
#include "common/random.hpp"
#include "studies/observers/input_observer.hpp"

namespace sixdeg {
namespace {

constexpr int kCylinders = 4;
constexpr double kSampleS = 1e-4, kNoise = 1e-4, kStartErrorMps = 0.3;
constexpr double kSpeedBase = 20, kAccelBase = 1000, kJerkBase = 1e5; // per-unit bases of q31

using Strengths = std::vector<double>; // by place in the firing order

/// One sample as an observer meets it.
struct Sample {
    double time_s, speed_mps;
    std::vector<double> input_mps3; // mean over the step before it, of each cylinder, for E = 1
    int active;                     // cylinder whose interval that step ends in
    bool present;                   // false: a missing tooth
};

/// The common face of the observers: acceleration at a sample.
class Observer {
  public:
    virtual ~Observer() = default;
    virtual void start(double y_mps, double speed_mps, double accel_mps2) = 0;
    virtual double step(const Sample &sample) = 0;
    virtual double speed() const = 0; ///< v1^, m/s; the sample itself in ROO.
};

struct F32 : NumberF32 {
    using State = sd_switched_f32_t;
    static constexpr auto start = sd_switched_start_f32;
    static constexpr auto step = sd_switched_step_f32;
    static constexpr auto coast = sd_switched_coast_f32;
};
struct Q31 : NumberQ31 {
    using State = sd_switched_q31_t;
    static constexpr auto start = sd_switched_start_q31;
    static constexpr auto step = sd_switched_step_q31;
    static constexpr auto coast = sd_switched_coast_q31;
};

template <class V> class Switched : public Observer {
  public:
    Switched(const PlantStep &step, double sliding, const Strengths &believed) : believed_(believed) {
        if (!switched_table<V>(step, {kSpeedBase, kAccelBase, kJerkBase},
                               table_)) throw std::logic_error("a switched observer does not fit its bases");
        state_.sliding = V::in(sliding / kJerkBase);
    }
    void start(double y, double speed, double accel) override {
        V::start(&state_, &table_, V::in(y / kSpeedBase), V::in(speed / kSpeedBase), V::in(accel / kAccelBase));
    }
    double step(const Sample &sample) override {
        double input = 0;
        for (int n = 0; n < kCylinders; ++n) input += believed_[std::size_t(n)] * sample.input_mps3[std::size_t(n)];
        const auto u = V::in(input / kJerkBase);
        if (!sample.present) return kAccelBase * V::out(V::coast(&state_, &table_, u));
        return kAccelBase * V::out(V::step(&state_, &table_, V::in(sample.speed_mps / kSpeedBase), u));
    }
    double speed() const override { return kSpeedBase * V::out(table_.reduced ? state_.output : state_.state[0]); }

  private:
    typename V::Table table_{};
    typename V::State state_{};
    Strengths believed_;
};

class PerCylinder : public Observer {
  public:
    PerCylinder(const HybridEngine &engine, const Strengths &believed) : observer_(config(engine)), believed_(believed) {}
    void start(double, double speed, double accel) override { observer_.start(speed, accel, believed_); }
    double step(const Sample &sample) override { return observer_.step(sample.speed_mps, sample.input_mps3, sample.active); }
    double speed() const override { return observer_.speed(); }

  private:
    static InputConfig config(const HybridEngine &engine) {
        InputConfig config{};
        config.step = plant_step({engine.k1_per_s2, engine.k2_per_s}, kSampleS);
        config.inputs = kCylinders;
        config.noise = kNoise * engine.crank_radius_m * engine.speed_radps;
        config.start_speed = kStartErrorMps;
        config.start_accel = 50;
        config.start_strength = 0.5;
        config.walk_strength = 1e-5;
        config.alarm_sd = 4;
        return config;
    }
    InputObserver observer_;
    Strengths believed_;
};

/// Mean input of each cylinder over [from, to].
std::vector<double> mean_inputs(const HybridEngine &engine, double from_s, double to_s) {
    std::vector<double> mean(kCylinders, 0.0);
    const double interval = engine.interval_s();
    for (long k = long(std::floor(from_s / interval)); k * interval < to_s; ++k)
        mean[std::size_t(k % kCylinders)] += engine.mean_input(from_s - k * interval, to_s - k * interval);
    return mean;
}

struct Trace {
    HybridState start;
    std::vector<Sample> samples;
    std::vector<double> speed_mps, accel_mps2; // true, at the samples
    double peak_mps2 = 0;
};

/// A step: a sampling interval, or a tooth of a 60-2 wheel.
double step_s(const HybridEngine &engine, bool angle_domain) { return angle_domain ? M_PI / 30 / engine.speed_radps : kSampleS; }

/// `told`: the engine whose input the observers are given.
Trace make_trace(const HybridEngine &engine, const HybridEngine &told, const FiringStrength &strength, bool angle_domain, unsigned seed) {
    Trace trace;
    RandomStream noise(seed, 0);
    HybridState now = trace.start = hybrid_periodic_start(engine);
    const double step = step_s(engine, angle_domain);
    for (long k = 1; double(k) * step <= kBenchRunS; ++k) {
        const double from = double(k - 1) * step, to = double(k) * step;
        now = hybrid_advance(engine, strength, now, from, to);
        const double noisy = now.speed_mps + noise.normal() * kNoise * engine.crank_radius_m * engine.speed_radps;
        const long firing = long(std::floor(to / engine.interval_s() - 1e-9));
        trace.samples.push_back({to, noisy, mean_inputs(told, from, to), int(firing % kCylinders), !angle_domain || k % 60 < 58});
        trace.speed_mps.push_back(now.speed_mps);
        trace.accel_mps2.push_back(now.accel_mps2);
        trace.peak_mps2 = std::max(trace.peak_mps2, std::abs(now.accel_mps2));
    }
    return trace;
}

std::vector<double> errors_percent(Observer &observer, const Trace &trace) {
    observer.start(trace.start.speed_mps, trace.start.speed_mps + kStartErrorMps, 0);
    std::vector<double> errors;
    for (std::size_t k = 0; k < trace.samples.size(); ++k)
        errors.push_back(100 * (observer.step(trace.samples[k]) - trace.accel_mps2[k]) / trace.peak_mps2);
    return errors;
}

/// Widens `row` by one run.
void add_run(BenchRow &row, const Trace &trace, const std::vector<double> &errors) {
    for (std::size_t k = 0; k < errors.size(); ++k) {
        const double t = trace.samples[k].time_s, e = errors[k];
        if (t >= 0.6)
            row.low_percent = std::min(row.low_percent, e), row.high_percent = std::max(row.high_percent, e);
        if (t >= 0.1)
            row.early_low_percent = std::min(row.early_low_percent, e),
            row.early_high_percent = std::max(row.early_high_percent, e);
        if (std::abs(e) > 2) row.to_two_percent_s = std::max(row.to_two_percent_s, t);
        if (std::abs(e) > 1) row.to_one_percent_s = std::max(row.to_one_percent_s, t);
    }
}

struct Condition {
    std::string name;
    std::vector<Strengths> truths;
    bool known;
};

std::vector<Condition> conditions() {
    std::vector<Strengths> misfires;
    for (int n = 0; n < kCylinders; ++n) {
        misfires.emplace_back(kCylinders, 1.0);
        misfires.back()[std::size_t(n)] = 0;
    }
    return {{"no fault", {Strengths(kCylinders, 1.0)}, false},
            {"misfire known", misfires, true},
            {"misfire unknown", misfires, false},
            {"offsets unknown", {{1.03, 0.98, 1.05, 0.99}}, false}};
}

using Maker = std::function<std::unique_ptr<Observer>(const Strengths &believed)>;
struct Contender {
    std::string name, domain;
    bool angle_domain;
    Maker make;
};

std::vector<Contender> contenders(const HybridEngine &engine, const BenchGains &gains) {
    const CrankModel model{engine.k1_per_s2, engine.k2_per_s};
    std::vector<Contender> all;
    const auto add = [&](const std::string &name, double roo, double luenberger, double sliding) {
        const auto make_step = [=](bool angle_domain) {
            const double period_s = step_s(engine, angle_domain);
            return roo > 0 ? roo_step(model, roo, period_s) : folsmo_step(model, luenberger, period_s);
        };
        const PlantStep time = make_step(false), angle = make_step(true);
        all.push_back({name, "time", false, [=](const auto &b) { return std::make_unique<Switched<F32>>(time, sliding, b); }});
        all.push_back({name, "time, q31", false, [=](const auto &b) { return std::make_unique<Switched<Q31>>(time, sliding, b); }});
        all.push_back({name, "angle", true, [=](const auto &b) { return std::make_unique<Switched<F32>>(angle, sliding, b); }});
    };
    add("ROO", gains.roo_per_s, 0, 0);
    add("FOSMO", 0, 0, gains.sliding_mps3);
    add("FOLSMO", 0, gains.luenberger_per_s2, gains.sliding_mps3);
    all.push_back(
        {"ours", "time", false, [=](const auto &b) { return std::make_unique<PerCylinder>(engine, b); }});
    return all;
}

FiringStrength repeating(const Strengths &strengths) {
    return [strengths](long firing) { return strengths[std::size_t(firing % kCylinders)]; };
}

} // namespace

std::vector<BenchRow> run_observer_bench(const HybridEngine &engine, const BenchGains &gains, unsigned seed) {
    return run_observer_bench(engine, engine, gains, seed);
}

std::vector<BenchRow> run_observer_bench(const HybridEngine &engine, const HybridEngine &told, const BenchGains &gains, unsigned seed) {
    std::vector<BenchRow> rows;
    for (const Contender &contender : contenders(engine, gains)) {
        for (const Condition &condition : conditions()) {
            BenchRow row{contender.name, contender.domain, condition.name, 0, 0, 0, 0, 0, 0};
            for (const Strengths &truth : condition.truths) {
                const Trace trace = make_trace(engine, told, repeating(truth), contender.angle_domain, seed);
                const auto observer = contender.make(condition.known ? truth : Strengths(kCylinders, 1.0));
                add_run(row, trace, errors_percent(*observer, trace));
            }
            rows.push_back(row);
        }
    }
    return rows;
}

IsolatedMisfire run_isolated_misfire(const HybridEngine &engine, unsigned seed) {
    constexpr long kMissing = 21;
    const Trace trace = make_trace(engine, engine, [](long k) { return k == kMissing ? 0.0 : 1.0; }, false, seed);
    PerCylinder observer(engine, Strengths(kCylinders, 1.0));
    const auto errors = errors_percent(observer, trace);
    IsolatedMisfire result{0, 0};
    for (std::size_t k = 0; k < errors.size(); ++k) {
        const double since = trace.samples[k].time_s - kMissing * engine.interval_s();
        if (since < 0) continue;
        result.peak_percent = std::max(result.peak_percent, std::abs(errors[k]));
        if (std::abs(errors[k]) > 1)
            result.longest_s = std::max(result.longest_s, std::fmod(since, engine.interval_s()));
    }
    return result;
}

std::vector<FigurePoint> figure_trace(const HybridEngine &engine, const BenchGains &gains, unsigned seed, bool misfire, bool known) {
    Strengths truth(kCylinders, 1.0);
    if (misfire) truth[1] = 0;
    const Trace trace = make_trace(engine, engine, repeating(truth), false, seed);
    const PlantStep step = folsmo_step({engine.k1_per_s2, engine.k2_per_s}, gains.luenberger_per_s2, kSampleS);
    Switched<F32> observer(step, gains.sliding_mps3, known ? truth : Strengths(kCylinders, 1.0));
    observer.start(trace.start.speed_mps, trace.start.speed_mps + kStartErrorMps, 0);
    std::vector<FigurePoint> points;
    for (std::size_t k = 0; k < trace.samples.size(); ++k) {
        const double accel = observer.step(trace.samples[k]);
        points.push_back({trace.samples[k].time_s, trace.speed_mps[k], observer.speed(), trace.accel_mps2[k], accel});
    }
    return points;
}

} // namespace sixdeg
