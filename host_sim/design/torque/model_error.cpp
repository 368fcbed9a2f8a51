// SPDX-License-Identifier: MIT
#include "design/torque/model_error.hpp"

#include <cmath>

#include "design/torque/pulse.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Table = std::vector<double>;

constexpr double kRadPerDeg = M_PI / 180;
const double kEven = 1 / std::sqrt(3.0);        // standard deviation of what is as likely anywhere within +-1
/// Power of a cylinder's own fuel by which its wall loss, in Hohenberg's, may differ. Gas temperature stands in correlations with powers
/// from -0.5 (Woschni) to 0.5 (Eichelberg), and the loss itself may be twice Hohenberg's.
constexpr double kOwnFuelSd = 1;
constexpr double kChargeSdK = 20;               // of the charge's temperature at intake closing
/// Of compression's exponent: leaks, another gas or wall loss; engines by other equations lie between 1.30 and 1.38.
const std::string kExponentName = "compression exponent";
const double kExponentSd = 0.04 * kEven;
/// Of the intake's pressure: a sensor of 1.5 % of its range at half of it.
const double kIntakeSd = 0.03 * kEven;
constexpr double kFuelLow = 0.2, kFuelHigh = 1; // equivalence ratio
constexpr double kIntakeLow = 0.4, kIntakeHigh = 2;   // bar
constexpr double kSpeedLow = 80, kSpeedHigh = 600;    // rad/s

class Doubts {
  public:
    explicit Doubts(const EngineFile &engine) : engine_(engine), usual_(cylinder_pulse(engine, 0)), bend_(pulse_bend(engine, 0, usual_)) {}

    /// Half the difference between the ends of a range is its largest error.
    void range(const std::string &name, const CylinderPulse &low, const CylinderPulse &high) {
        add(name, difference(high.combustion, low.combustion, kEven / 2), difference(high.motored_per_bar, low.motored_per_bar, kEven / 2),
            true, 0);
    }
    void apart(const std::string &name, const CylinderPulse &other, double factor, bool common) {
        add(name, difference(other.combustion, usual_.combustion, factor),
            difference(other.motored_per_bar, usual_.motored_per_bar, factor), common, 0);
    }
    void add(const std::string &name, const Table &pulse, const Table &motored, bool common, double scale) {
        const auto [pulse_mean, pulse_moment] = over_cylinders(pulse);
        const auto [motored_mean, motored_moment] = over_cylinders(motored);
        all.push_back({name, pulse_mean, pulse_moment, motored_mean, motored_moment, common, scale, false});
    }
    Table motored(double factor) const { return difference(usual_.motored_per_bar, Table(kPulsePoints, 0.0), factor); }
    Table exponent(double factor) const { return difference(motored_over_exponent(engine_, 0), none(), factor); }
    Table bent(double factor) const { return difference(bend_, none(), factor); }
    Table none() const { return Table(kPulsePoints, 0.0); }
    const CylinderPulse &usual() const { return usual_; }
    static Table turned(const Table &table, double by_rad) {
        Table out(table.size());
        for (std::size_t i = 0; i < table.size(); ++i) out[i] = pulse_at(table, 4 * M_PI * double(i) / kPulsePoints + by_rad) - table[i];
        return out;
    }

    std::vector<ModelDoubt> all;

  private:
    static Table difference(const Table &a, const Table &b, double factor) {
        Table out(a.size());
        for (std::size_t i = 0; i < a.size(); ++i) out[i] = factor * (a[i] - b[i]);
        return out;
    }
    std::pair<MatrixXd, MatrixXd> over_cylinders(const Table &table) const {
        std::vector<TorqueOverAngle> of;
        for (double tdc : engine_.firing_tdc_deg) of.push_back([&table, tdc](double a) { return pulse_at(table, a - tdc * kRadPerDeg); });
        return interval_tables(engine_, of);
    }

    const EngineFile &engine_;
    CylinderPulse usual_;
    Table bend_;
};

/// [firing][cylinder]; nothing acts, nothing is read.
MatrixXd answers(const GainsAt &at, const MatrixXd &mean, const MatrixXd &moment) {
    if (mean.isZero(0)) return MatrixXd::Zero(mean.cols(), mean.cols());
    return steady_reading(at.model, at.gain, mean, moment);
}

/// Answers of the firings to one doubt: [firing][cylinder]. Where the pulses have a shape to learn, that takes what all
/// cylinders share, and acts on each cylinder's pulse as large as it is.
MatrixXd pulse_answers(const ModelDoubt &doubt, const GainsAt &at, const GainsAt &still, const MatrixXd &bend_mean,
                       const MatrixXd &bend_moment) {
    const auto n = doubt.pulse_mean.cols();
    const MatrixXd full = answers(at, doubt.pulse_mean, doubt.pulse_moment);
    if (full.rows() == n || !doubt.common) return full.topRows(n);
    const double shape = full.row(n).sum();
    return answers(still, doubt.pulse_mean - shape * bend_mean, doubt.pulse_moment - shape * bend_moment);
}

/// The same filter, whose pulses' shape stands still: a filter without it, behind whose firings no other coefficient comes.
GainsAt without_shape(GainsAt at) {
    const auto shape = 1 + Eigen::Index(at.model.read_at.size()), after = at.gain.cols() - (2 + shape + 1);
    MatrixXd gain(at.gain.rows(), at.gain.cols() - 1);
    gain << at.gain.leftCols(2 + shape), at.gain.rightCols(after);
    at.gain = gain;
    for (MatrixXd *basis : {&at.model.mean, &at.model.moment}) basis->conservativeResize(Eigen::NoChange, shape);
    for (ToothMode &mode : at.model.modes) mode.compliance.conservativeResize(shape);
    return at;
}

} // namespace

std::vector<ModelDoubt> model_doubts(const EngineFile &engine) {
    Doubts doubts(engine);
    const Tolerance &off = engine.tolerance;
    std::vector<PulseConditions> conditions;
    const auto under = [&](double PulseConditions::*field, double value) {
        PulseConditions at;
        at.*field = value;
        conditions.push_back(at);
    };
    const auto with = [&](auto change) {
        EngineFile other = engine;
        change(other);
        return cylinder_pulse(other, 0);
    };
    under(&PulseConditions::equivalence_ratio, kFuelLow), under(&PulseConditions::equivalence_ratio, kFuelHigh);
    under(&PulseConditions::intake_bar, kIntakeLow), under(&PulseConditions::intake_bar, kIntakeHigh);
    under(&PulseConditions::speed_radps, kSpeedLow), under(&PulseConditions::speed_radps, kSpeedHigh);
    under(&PulseConditions::charge_k, PulseConditions{}.charge_k + kChargeSdK);
    under(&PulseConditions::wall_factor, 1 + kEven * off.wall_loss_percent / 100);
    const auto pulses = cylinder_pulses(engine, conditions);
    doubts.range("fuel", pulses[0], pulses[1]);
    doubts.range("intake pressure", pulses[2], pulses[3]);
    doubts.range("speed", pulses[4], pulses[5]);
    doubts.apart("charge temperature", pulses[6], 1, true);
    doubts.apart("wall loss", pulses[7], 1, true);
    doubts.add("wall loss over own fuel", doubts.bent(kOwnFuelSd), doubts.none(), false, 0);
    doubts.all.back().spread_only = true;
    doubts.apart("burn start", with([&](EngineFile &e) { for (HeatPulse &p : e.pulses) p.start_deg += kEven * off.burn_start_deg; }), 1,
                 true);
    doubts.apart("burn duration", with([&](EngineFile &e) { for (HeatPulse &p : e.pulses) p.duration_deg *= 1
                                                           + kEven * off.burn_duration_percent / 100; }), 1, true);
    if (off.compression_percent > 0)
        doubts.apart("compression", with([&](EngineFile &e) { e.compression_ratio *= 1 + kEven * off.compression_percent / 100; }), 1,
                     false);
    if (off.trapped_mass_percent > 0) doubts.add("trapped mass", doubts.none(), doubts.motored(kEven * off.trapped_mass_percent / 100),
                                                 false, 0);
    doubts.add(kExponentName, doubts.none(), doubts.exponent(kExponentSd), true, 0);
    doubts.add("intake sensor", doubts.none(), doubts.motored(kIntakeSd), true, 0);
    // The filter takes what turns it for torque in proportion to the inertia that it believes.
    const double inertia = kEven * off.inertia_percent / 100;
    if (inertia > 0) doubts.add("inertia", doubts.none(), doubts.motored(inertia), true, inertia);
    const double turn = kEven * off.wheel_offset_deg * kRadPerDeg;
    if (turn > 0) doubts.add("wheel offset", Doubts::turned(doubts.usual().combustion, turn),
                             Doubts::turned(doubts.usual().motored_per_bar, turn), true, 0);
    return doubts.all;
}

std::vector<MatrixXd> zeros_learned(const std::vector<ModelDoubt> &doubts, GainsAt at) {
    const auto n = Eigen::Index(at.model.read_at.size());
    if (at.model.torques() > 1 + n) at = without_shape(at);
    std::vector<MatrixXd> zeros;
    for (const ModelDoubt &doubt : doubts) zeros.push_back(answers(at, doubt.motored_mean, doubt.motored_moment));
    return zeros;
}

FuelCutPrior fuel_cut_prior(const EngineFile &engine, const KnownTorque &torque, const KalmanTune &tune) {
    constexpr double kSpeedRadps = 1500 * M_PI / 30;
    const ToothModel model = tooth_model(engine, torque, kSpeedRadps);
    const std::vector<ModelDoubt> doubts = model_doubts(engine);
    const auto read = zeros_learned(doubts, {model, design_gains(model, tooth_noise(engine, tune, kSpeedRadps), 1).gain});
    FuelCutPrior prior;
    for (std::size_t i = 0; i < doubts.size(); ++i) {
        const RowVectorXd mean = read[i].colwise().mean(); // of all cylinders, by an error of each
        prior.sd_nm_per_bar += doubts[i].common ? std::pow(mean.sum(), 2) : mean.squaredNorm();
        if (doubts[i].name == kExponentName) prior.exponent_nm_per_bar = mean.sum() / kExponentSd;
    }
    prior.sd_nm_per_bar = std::sqrt(prior.sd_nm_per_bar);
    return prior;
}

ModelError model_error(const EngineFile &engine, const KnownTorque &torque, const std::vector<ModelDoubt> &doubts, const GainsAt &here,
                       const std::vector<MatrixXd> &zeros) {
    const auto n = engine.cylinders();
    // Of one cylinder nothing is taken out, since its mean is itself.
    const MatrixXd less_mean = MatrixXd::Identity(n, n) - MatrixXd::Constant(n, n, n > 1 ? 1.0 / n : 0);
    const auto [bend_mean, bend_moment] = interval_tables(engine, torque.shape);
    const GainsAt still = torque.shape.empty() ? here : without_shape(here);
    ModelError sum;
    for (std::size_t i = 0; i < doubts.size(); ++i) {
        const ModelDoubt &doubt = doubts[i];
        const auto square = [&](const MatrixXd &answers) { // of cylinders that all have a torque of 1
            const MatrixXd less = less_mean * answers;
            return (doubt.common ? less.rowwise().sum().squaredNorm() : less.squaredNorm()) / n;
        };
        const MatrixXd pulse = pulse_answers(doubt, here, still, bend_mean, bend_moment) + doubt.scale * MatrixXd::Identity(n, n);
        const MatrixXd charge = answers(here, doubt.motored_mean, doubt.motored_moment).topRows(n);
        if (!doubt.spread_only) sum.mean_share += square(pulse);
        if (n > 1) sum.spread_share += (less_mean * pulse * less_mean).squaredNorm() / (n - 1);
        sum.charge_nm_per_bar += square(charge);
        sum.learned_nm_per_bar += square(charge - zeros[i]);
    }
    return {std::sqrt(sum.mean_share), std::sqrt(sum.spread_share), std::sqrt(sum.charge_nm_per_bar), std::sqrt(sum.learned_nm_per_bar)};
}

} // namespace sixdeg
