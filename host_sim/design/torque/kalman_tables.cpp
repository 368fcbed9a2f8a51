// SPDX-License-Identifier: MIT
#include "design/torque/kalman_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "design/calibration.hpp"
#include "design/crank/crank_modes.hpp"
#include "design/torque/fired_tables.hpp"
#include "design/torque/interval_tables.hpp"
#include "design/torque/late_in_fuel_cut.hpp"
#include "design/torque/model_error.hpp"
#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180, kRadpsPerRpm = M_PI / 30;
/// A firing's coefficient is free from here on, and read where its pulse is long over.
constexpr double kInjectDeg = -12, kReadDeg = 300;
/// On rough roads a firing may change by this much more: what it lacks must not be taken for load, which may change too.
constexpr double kRoughChange = 4;
/// Cylinders' zeros are learned here: fuel cut, and of its speeds the lowest counts most.
constexpr double kLearnedRpm = 1500;
/// Indicated mean effective pressure below which the pulses' shape is not learned.
constexpr double kShapeFromPa = 0.5e5;

/// First cycle position at or after `deg` past the TDC of a firing.
int position_after(const EngineFile &engine, std::size_t firing, double deg) {
    const int cycle = 2 * engine.wheel.positions;
    const double off = (engine.firing_tdc_deg[firing] + deg - engine.position_0_deg) / 360 * engine.wheel.positions;
    const int k = int(std::ceil(off - 1e-9)) % cycle;
    return k < 0 ? k + cycle : k;
}

/// Modes do not go with the Fourier basis, which does not know whose torque it is.
std::vector<CrankMode> modes_of(const EngineFile &engine, const KnownTorque &torque) {
    return torque.firings ? crank_modes(engine, SD_KALMAN_MODES_MAX) : std::vector<CrankMode>{};
}

sd_kalman_mode_t mode_table(const CrankMode &mode) {
    sd_kalman_mode_t t{float(mode.frequency_radps), float(mode.damping), float(mode.constant_radpnm), {}, float(mode.spring_nmprad),
                       float(mode.damper_nmprad)};
    std::copy(mode.cylinder_radpnm.begin(), mode.cylinder_radpnm.end(), t.cylinder_radpnm);
    return t;
}

/// Twist of the wheel that the interval's mean known torques hold: rad, and rad a w^2 for the torque of the reciprocating
/// masses, -J'/2 w^2.
std::pair<double, double> held_by_known(const EngineFile &engine, const KnownTorque &torque, const CrankMode &mode, int k) {
    double known = 0, ripple = 0;
    for (std::size_t i = 0; i < mode.cylinder_radpnm.size(); ++i) {
        const auto inertia = [&](int at) { return reciprocating_inertia_kgm2(engine, i, tooth_angle(engine, at)); };
        known += mode.cylinder_radpnm[i] * over_interval(engine, torque.motored[i], k).mean;
        ripple -= mode.cylinder_radpnm[i] * (inertia(k) - inertia(k - 1)) / 2 / (2 * M_PI / engine.wheel.positions);
    }
    return {known, ripple};
}

/// Pulses below this share of their mean torque count as over: 2e-4 of 300 N m is 0.06 N m over some teeth.
constexpr double kPulseOver = 2e-4;

bool pulse_is_over(const EngineFile &engine, const KnownTorque &torque, std::size_t j, int k) {
    const auto over = [&](const TorqueOverAngle &f) {
        const Interval at = over_interval(engine, f, k);
        return std::max({std::abs(at.mean), std::abs(at.moment), std::abs(at.point)}) < kPulseOver;
    };
    return over(torque.basis[j]) && (torque.shape.empty() || over(torque.shape[j]));
}

/// The pulses that last at a position: the first of them round the firing order, and how many from there.
struct Lasting {
    int first = 0, count = 0;
};

Lasting lasting(const EngineFile &engine, const KnownTorque &torque, int k) {
    const int n = int(torque.basis.size());
    std::vector<bool> lasts;
    for (int j = 0; j < n; ++j) lasts.push_back(!torque.firings || !pulse_is_over(engine, torque, std::size_t(j), k));
    Lasting best{0, n};
    for (int first = 0; first < n; ++first) {
        int count = 0;
        for (int i = 0; i < n; ++i)
            if (lasts[std::size_t((first + i) % n)]) count = i + 1;
        if (count < best.count) best = {first, count};
    }
    return best;
}

/// What the firmware weighs two speeds with, together.
constexpr double kWeight = 16384;

std::int16_t quantised(double gain, float scale) {
    return scale > 0 ? std::int16_t(std::clamp(std::round(gain / (kWeight * double(scale))), -32767.0, 32767.0)) : std::int16_t(0);
}

/// Which of a set's scales a column of its gains has.
std::size_t scale_of(const sd_kalman_tables_t &t, int column) {
    const int modes_from = 2 + t.coefficients + t.shapes;
    if (column >= modes_from) return std::size_t(5 + column - modes_from);
    if (column >= 2 + t.coefficients) return 4;
    return std::size_t(std::min(column, 3));
}

/// So that the largest gain of a set just fits into 16 bits.
void set_scales(const std::vector<PeriodicGains> &gains, sd_kalman_tables_t &t) {
    for (std::size_t i = 0; i < gains.size(); ++i) {
        for (int j = 0; j < gains[i].gain.cols(); ++j) {
            float &scale = t.gain_scale[i / t.speeds][scale_of(t, j)];
            scale = std::max(scale, float(gains[i].gain.col(j).cwiseAbs().maxCoeff() / 32767 / kWeight));
        }
    }
}

void fill_gains(const std::vector<PeriodicGains> &gains, int k, const sd_kalman_tables_t &t, sd_kalman_word_t *word) {
    const std::size_t columns = sd_motion_columns(&t);
    for (std::size_t i = 0; i < gains.size(); ++i) {
        for (int j = 0; j < gains[i].gain.cols(); ++j) {
            const std::size_t set = i / t.speeds, at = (set * columns + std::size_t(j)) * t.speeds + i % t.speeds;
            word[at / 2].gain[at % 2] = quantised(gains[i].gain(k, j), t.gain_scale[set][scale_of(t, j)]);
        }
    }
}

void fill_row(const EngineFile &engine, const KnownTorque &torque, const std::vector<CrankMode> &modes, int k, const sd_kalman_tables_t &t,
              sd_kalman_word_t *word) {
    word[SD_ROW_INTERVAL].value = float(2 / interval_inertia_kgm2(engine, k));
    word[SD_ROW_TOOTH].value = float(2 / turning_inertia_kgm2(engine, tooth_angle(engine, k)));
    Interval known;
    for (const TorqueOverAngle &motored : torque.motored) {
        const Interval at = over_interval(engine, motored, k);
        known.mean += at.mean, known.moment += at.moment, known.point += at.point;
    }
    sd_kalman_word_t *to = word + SD_ROW_KNOWN;
    const auto put = [&](const Interval &at) {
        for (double value : {at.mean, at.moment, at.point}) (to++)->value = float(value);
    };
    put(known);
    put(torque.exponent ? over_interval(engine, torque.exponent, k) : Interval{});
    ++to; // SD_ROW_LATE
    for (const TorqueOverAngle &motored : torque.motored_per_bar) put(over_interval(engine, motored, k));
    for (int i = 0; i < t.window; ++i) {
        const std::size_t j = std::size_t(word[SD_ROW_AT].at.first + i) % torque.basis.size();
        put(over_interval(engine, torque.basis[j], k));
        put(torque.shape.empty() ? Interval{} : over_interval(engine, torque.shape[j], k));
    }
    for (const CrankMode &mode : modes) {
        const auto [held, ripple] = held_by_known(engine, torque, mode, k);
        (to++)->value = float(held), (to++)->value = float(ripple);
    }
}

/// What happens at each position.
void fill_positions(const EngineFile &engine, const KnownTorque &torque, sd_kalman_tables_t &t) {
    for (int k = 0; k < 2 * t.positions; ++k) {
        sd_kalman_word_t &word = t.pool[k * t.row_words + SD_ROW_AT];
        word.at.first = std::uint8_t(lasting(engine, torque, k).first);
        word.at.tooth = std::uint8_t(std::count(engine.wheel.missing.begin(), engine.wheel.missing.end(), k % t.positions) == 0);
    }
    for (std::size_t i = 0; i < t.cylinders; ++i) {
        t.pool[position_after(engine, i, engine.intake_close_deg) * t.row_words + SD_ROW_AT].at.close |= std::uint8_t(1 << i);
        if (i < t.firings) t.pool[position_after(engine, i, kReadDeg) * t.row_words + SD_ROW_AT].at.read = std::uint8_t(1 + i);
    }
}

void fill_pool(const EngineFile &engine, const KnownTorque &torque, const std::vector<PeriodicGains> &gains, sd_kalman_tables_t &t) {
    const auto modes = modes_of(engine, torque);
    set_scales(gains, t);
    fill_positions(engine, torque, t);
    for (int k = 0; k < 2 * t.positions; ++k) {
        sd_kalman_word_t *word = t.pool + k * t.row_words;
        fill_row(engine, torque, modes, k, t, word);
        fill_gains(gains, k, t, word + t.gains_at);
    }
    if (torque.exponent) {
        const auto late = late_in_fuel_cut(engine, torque.exponent);
        for (int k = 0; k < 2 * t.positions; ++k) t.pool[k * t.row_words + SD_ROW_LATE].value = float(late[std::size_t(k % t.positions)]);
    }
}

/// Takes over how many words a row has; false when the pool has no room for all rows.
bool rows_fit(sd_kalman_tables_t &t) {
    t.gains_at = std::uint16_t(sd_motion_gains_at(&t));
    t.row_words = std::uint16_t(sd_motion_row_words(&t));
    return sd_kalman_pool_used(&t) <= SD_KALMAN_POOL;
}

/// Nothing where the crank twists, whose modes tooth times show too, and with the Fourier basis.
std::optional<FiredTables> fired_of(const EngineFile &engine, const KnownTorque &torque) {
    if (!torque.firings || !modes_of(engine, torque).empty()) return std::nullopt;
    return fired_tables(engine, torque);
}

sd_kalman_tables_t sizes(const EngineFile &engine, const KnownTorque &torque, const KalmanTune &tune,
                         const std::optional<FiredTables> &fired) {
    sd_kalman_tables_t t{};
    t.positions = std::uint8_t(engine.wheel.positions);
    t.coefficients = std::uint8_t(1 + torque.basis.size());
    t.speeds = std::uint8_t(tune.speeds_rpm.size());
    t.firings = std::uint8_t(torque.firings ? engine.cylinders() : 0);
    t.cylinders = std::uint8_t(engine.cylinders());
    for (const CrankMode &mode : modes_of(engine, torque)) t.mode[t.modes++] = mode_table(mode);
    t.shapes = torque.shape.empty() ? 0 : 1;
    t.shape_min_nm = float(kShapeFromPa * engine.displaced_m3() / M_PI);
    t.teeth = std::uint8_t(engine.wheel.teeth());
    if (fired) t.parts = std::uint8_t(3 + t.firings), t.hidden = std::uint8_t(fired->hidden.size());
    for (int k = 0; k < 2 * t.positions; ++k) t.window = std::max(t.window, std::uint8_t(lasting(engine, torque, k).count));
    t.tick_hz = float(engine.tick_hz);
    t.pitch_rad = float(2 * M_PI / t.positions);
    t.inertia_mean_kgm2 = float(mean_inertia_kgm2(engine));
    // Cranks that twist have gains at so many speeds that a second set finds no room.
    t.sets = t.firings > 0 && tune.rough_walk_nm > 0 ? 2 : 1;
    if (!rows_fit(t)) t.sets = 1;
    if (!rows_fit(t)) {
        throw InputError(engine.name, "wheel",
                         fmt::format("{} positions with {} coefficients at {} speeds need {} table entries, allowed {}",
                                                           int(t.positions), int(t.coefficients), int(t.speeds), sd_kalman_pool_used(&t),
                                                               SD_KALMAN_POOL));
    }
    return t;
}

/// tooth_model() at several speeds.
class ModelAt {
  public:
    ModelAt(const EngineFile &engine, const KnownTorque &torque);
    ToothModel operator()(double speed_radps) const;

  private:
    ToothModel still_; ///< Without modes, whose turn depends on speed.
    std::vector<CrankMode> modes_;
    int cylinders_;
    double inertia_kgm2_;
};

/// Designs the gains of each speed, behind those that are there.
void add_set(const EngineFile &engine, const ModelAt &model_at, const KalmanTune &tune, KalmanTables &out) {
    sd_kalman_tables_t &t = out.tables;
    for (std::size_t i = 0; i < tune.speeds_rpm.size(); ++i) {
        const double speed = tune.speeds_rpm[i] * kRadpsPerRpm;
        const ToothModel model = model_at(speed);
        const ToothNoise noise = tooth_noise(engine, tune, speed);
        const std::size_t at = out.gains.size();
        out.gains.push_back(design_gains(model, noise, SD_KALMAN_MEAN));
        const PeriodicGains &gains = out.gains[at];
        t.speed_radps[i] = float(speed);
        t.noise_rad[at] = float(noise.edge_rad);
        t.expected_rad[at] = float(noise.edge_rad * gains.innovation);
        t.single_sd[at] = float(gains.single_sd), t.mean_sd[at] = float(gains.mean_sd), t.pattern_sd[at] = float(gains.pattern_sd);
        t.load_sd_nm[at] = float(gains.load_sd * mean_inertia_kgm2(engine) * speed * speed);
        if (i == 0) continue;
        for (double share : {0.25, 0.5, 0.75}) {
            const double between = speed + share * (tune.speeds_rpm[i - 1] * kRadpsPerRpm - speed);
            const Eigen::MatrixXd mixed = gains.gain + share * (out.gains[at - 1].gain - gains.gain);
            out.radius_between = std::max(out.radius_between, cycle_radius(model_at(between), mixed));
        }
    }
}

/// A set's gains at any speed, as the firmware mixes them.
GainsAt gains_at(const ModelAt &model_at, const KalmanTables &from, std::size_t set, double speed_radps) {
    const float *speeds = from.tables.speed_radps;
    std::size_t at = 0;
    while (at + 1 < from.tables.speeds && speed_radps >= double(speeds[at + 1])) ++at;
    const std::size_t next = at + 1 < from.tables.speeds && speed_radps > double(speeds[at]) ? at + 1 : at;
    const double share = next > at ? (speed_radps - double(speeds[at])) / double(speeds[next] - speeds[at]) : 0;
    const Eigen::MatrixXd &low = from.gains[set * from.tables.speeds + at].gain, &high = from.gains[set * from.tables.speeds + next].gain;
    return {model_at(speed_radps), low + share * (high - low)};
}

/// What is not known of the engine goes into the deviations.
void state_doubts(const EngineFile &engine, const KnownTorque &torque, const ModelAt &model_at, KalmanTables &out) {
    sd_kalman_tables_t &t = out.tables;
    const std::vector<ModelDoubt> doubts = model_doubts(engine);
    const auto zeros = zeros_learned(doubts, gains_at(model_at, out, 0, kLearnedRpm * kRadpsPerRpm)); // by the first filter
    for (std::size_t i = 0; i < out.gains.size(); ++i) {
        const GainsAt here = gains_at(model_at, out, i / t.speeds, double(t.speed_radps[i % t.speeds]));
        const ModelError error = model_error(engine, torque, doubts, here, zeros);
        t.mean_share[i] = float(error.mean_share), t.spread_share[i] = float(error.spread_share);
        t.charge_nm_per_bar[i] = float(error.charge_nm_per_bar), t.learned_nm_per_bar[i] = float(error.learned_nm_per_bar);
    }
}


ModelAt::ModelAt(const EngineFile &engine, const KnownTorque &torque)
    : modes_(modes_of(engine, torque)), cylinders_(engine.cylinders()), inertia_kgm2_(mean_inertia_kgm2(engine)) {
    std::vector<TorqueOverAngle> basis = torque.basis;
    if (!torque.shape.empty()) basis.push_back(sum_of(torque.shape));
    const int n = engine.wheel.positions, m = 1 + int(basis.size());
    still_.positions = n;
    still_.present.assign(std::size_t(n), true);
    for (int k : engine.wheel.missing) still_.present[std::size_t(k)] = false;
    for (int k = 0; k < n; ++k) still_.inertia_ratio.push_back(interval_inertia_kgm2(engine, k) / inertia_kgm2_);
    still_.mean = Eigen::MatrixXd::Constant(2 * n, m, 1);
    still_.moment = Eigen::MatrixXd::Constant(2 * n, m, 0.5);
    const auto [mean_of, moment_of] = interval_tables(engine, basis);
    still_.mean.rightCols(m - 1) = mean_of, still_.moment.rightCols(m - 1) = moment_of;
    for (std::size_t i = 0; torque.firings && i < std::size_t(engine.cylinders()); ++i) {
        still_.inject_at.push_back(position_after(engine, i, kInjectDeg));
        still_.read_at.push_back(position_after(engine, i, kReadDeg));
    }
}

ToothModel ModelAt::operator()(double speed_radps) const {
    ToothModel model = still_;
    const int m = model.torques();
    const double scale = inertia_kgm2_ * speed_radps * speed_radps;
    for (const CrankMode &mode : modes_) {
        Eigen::RowVectorXd compliance(m);
        compliance(0) = scale * mode.constant_radpnm;
        // Behind a dual-mass flywheel all cylinders share one compliance, and so does the sum of their pulses.
        for (int j = 1; j < m; ++j) compliance(j) = scale * mode.cylinder_radpnm[std::size_t(std::min(j, cylinders_) - 1)];
        model.modes.push_back(tooth_mode(mode.frequency_radps * model.pitch() / speed_radps, mode.damping, compliance));
    }
    return model;
}

} // namespace

ToothModel tooth_model(const EngineFile &engine, const KnownTorque &torque, double speed_radps) {
    return ModelAt(engine, torque)(speed_radps);
}

ToothNoise tooth_noise(const EngineFile &engine, const KalmanTune &tune, double speed_radps) {
    const double scale = mean_inertia_kgm2(engine) * speed_radps * speed_radps;
    const double edge = tune.edge_deg * kRadPerDeg, timer = speed_radps / engine.tick_hz / std::sqrt(12);
    return {std::hypot(edge, timer), tune.load_walk_nm / scale, tune.firing_torque_change_nm / scale, tune.basis_walk_nm / scale};
}

KalmanTables kalman_tables(const EngineFile &engine, const KnownTorque &torque, const KalmanTune &tune) {
    const std::optional<FiredTables> fired = fired_of(engine, torque);
    KalmanTables out{sizes(engine, torque, tune, fired), {}, 0};
    sd_kalman_tables_t &t = out.tables;
    const ModelAt model_at(engine, torque);
    add_set(engine, model_at, tune, out);
    if (t.sets > 1) {
        KalmanTune rough = tune;
        rough.load_walk_nm = std::max(tune.rough_walk_nm, tune.load_walk_nm);
        rough.firing_torque_change_nm *= kRoughChange;
        add_set(engine, model_at, rough, out);
    }
    if (t.firings > 0 && !engine.pulses.empty()) state_doubts(engine, torque, model_at, out);
    fill_pool(engine, torque, out.gains, t);
    if (fired) put_fired(*fired, t);
    return out;
}

} // namespace sixdeg
