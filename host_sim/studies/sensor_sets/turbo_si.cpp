// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/turbo_si.hpp"

#include <cmath>
#include <fmt/format.h>
#include <unsupported/Eigen/AutoDiff>

#include "common/error.hpp"
#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using std::abs, std::exp, std::pow, std::sqrt;

struct Gas {
    double r, cp; ///< J/(kg K)
    double cv() const { return cp - r; }
    double gamma() const { return cp / cv(); }
};
// cp and gamma are published; R follows from them, so that the volumes conserve energy exactly.
constexpr Gas air{1005.2 * (1 - 1 / 1.4), 1005.2};
constexpr Gas exhaust{1256.67 * (1 - 1 / 1.3), 1256.67};

struct Volumes_m3 {
    double af = 15.085e-3, comp = 6e-3, ic = 4.7e-3, im = 1.8e-3, em = 1.59e-3, t = 20e-3;
};
constexpr Volumes_m3 volume;

// Quadratic pressure loss dp = H T W^2 / p, linear below `linear_pa` so that its slope stays finite at rest.
struct Restriction {
    double h, linear_pa;
};
constexpr Restriction air_filter{1.59598e8, 1600}, intercooler{3.4678e8, 800}, exhaust_system{2.1027e8, 100};
constexpr double intercooler_fit[3] = {-0.564164, 4.65003e-3, -2.99972}; // share of heat removed: 1, K, kg/s

constexpr double throttle_area[3] = {5.18849e-6, -6.38593e-5, 1.23068e-3}; // m2 by powers of rad
constexpr double wastegate_area_m2 = 4.9087e-4;
constexpr double linear_ratio = 0.99; // pressure ratio above which a nozzle's flow is made linear

constexpr double displacement_m3 = 1.953e-3, compression_ratio = 10.8;
constexpr double filling[5] = {1.7338e-9, -8.3904e-7, 1.3625e-4, -7.4009e-3,
                               0.93581}; // falling powers of kPa
constexpr double stoichiometric = 14.0;
constexpr double engine_out_k = 1146.83, engine_out_k_per_kgps = 843.36;
constexpr double pipe_loss_w_per_k = 36.46 * M_PI * 0.040 * 0.170; // one of four exhaust pipes

constexpr double compressor_d_m = 0.0394, compressor_k1 = 0.31972, compressor_k2 = 18.1518;
constexpr double compressor_eta_max = 0.736335, compressor_eta_min = 0.3;
constexpr double compressor_best_kgps = 0.13473, compressor_best_ratio = 2.09997; // of 1 + sqrt(ratio - 1)
constexpr double compressor_q11 = 35.0283, compressor_q12 = -3.31011, compressor_q22 = 0.730446;
constexpr double map_pa = 101300, map_k = 293.15;

constexpr double turbine_d_m = 0.0383, turbine_k1 = 0.0292, turbine_k2 = 1.931710380902679;
constexpr double turbine_eta_max = 0.637445, turbine_eta_min = 0.3, turbine_best_speed_ratio = 0.41274;
constexpr double shaft_inertia_kgm2 = 1.252e-4, shaft_friction_nms = 9.7187e-7;

template <class T> T at_least(const T &x, double low) { return x < low ? T(low) : x; }

template <class T>
T quadratic_loss(const Restriction &loss, const T &up_pa, const T &down_pa, const T &up_k) {
    const T drop = up_pa - down_pa;
    const T conductance = sqrt(up_pa / (loss.h * up_k));
    // Turned round for backflow, which only occurs on the way to the steady state.
    if (drop > loss.linear_pa) return conductance * sqrt(drop);
    if (drop < -loss.linear_pa) return -conductance * sqrt(-drop);
    return conductance * drop / std::sqrt(loss.linear_pa);
}

double critical_ratio(const Gas &gas) {
    return std::pow(2 / (gas.gamma() + 1), gas.gamma() / (gas.gamma() - 1));
}

template <class T> T nozzle_psi(const Gas &gas, const T &ratio) {
    const double gamma = gas.gamma(), factor = 2 * gamma / (gamma - 1);
    const auto psi = [&](const auto &r) {
        return sqrt(factor * (pow(r, 2 / gamma) - pow(r, (gamma + 1) / gamma)));
    };
    if (ratio < critical_ratio(gas)) return T(psi(critical_ratio(gas)));
    if (ratio > linear_ratio) return psi(linear_ratio) * (1 - ratio) / (1 - linear_ratio);
    return psi(ratio);
}

template <class T> T nozzle(const Gas &gas, double area_m2, const T &up_pa, const T &down_pa, const T &up_k) {
    return area_m2 * up_pa / sqrt(gas.r * up_k) * nozzle_psi<T>(gas, down_pa / up_pa);
}

// A flow and the temperature it arrives with.
template <class T> struct Stream { T kgps, k; };

template <class T>
Stream<T> compressor(const T &up_pa, const T &up_k, const T &down_pa, const T &speed_radps) {
    const T ratio = down_pa / up_pa, tip_mps = speed_radps * (compressor_d_m / 2);
    const T heating = pow(ratio, 1 - 1 / air.gamma()) - 1;
    const T psi = 2 * air.cp * up_k * heating / (tip_mps * tip_mps);
    // Beyond the ellipse the compressor surges: nearly no flow.
    const T phi = sqrt(at_least<T>((1 - compressor_k1 * psi * psi) / compressor_k2, 1e-6));
    const T kgps = phi * (M_PI / 2 * compressor_d_m * compressor_d_m) * tip_mps * up_pa / (air.r * up_k);
    const T off_flow = kgps * sqrt(up_k / map_k) / (up_pa / map_pa) - compressor_best_kgps;
    // The root has no slope at ratio 1; below 1.0001 the efficiency no longer follows the ratio.
    const T off_ratio = 1 + sqrt(at_least<T>(ratio - 1, 1e-4)) - compressor_best_ratio;
    const T eta = compressor_eta_max -
                  (compressor_q11 * off_flow * off_flow + 2 * compressor_q12 * off_flow * off_ratio +
                   compressor_q22 * off_ratio * off_ratio);
    return {kgps, up_k * (1 + heating / at_least<T>(eta, compressor_eta_min))};
}

template <class T> struct Turbine { T kgps, out_k, power_w; };

template <class T> Turbine<T> turbine(const T &up_pa, const T &up_k, const T &down_pa, const T &speed_radps) {
    const T ratio = down_pa / up_pa;
    // The root has no slope at ratio 1.
    const T kgps =
        turbine_k1 * (up_pa / 1e3) / sqrt(up_k) * sqrt(at_least<T>(1 - pow(ratio, turbine_k2), 1e-6));
    const T cooling = at_least<T>(1 - pow(ratio, 1 - 1 / exhaust.gamma()), 1e-6);
    const T speed_ratio = speed_radps * (turbine_d_m / 2) / sqrt(2 * exhaust.cp * up_k * cooling);
    const T off = speed_ratio / turbine_best_speed_ratio - 1;
    const T eta = at_least<T>(turbine_eta_max * (1 - off * off), turbine_eta_min);
    const T drop_k = up_k * eta * cooling;
    return {kgps, up_k - drop_k, kgps * exhaust.cp * drop_k};
}

template <class T>
T cylinder_air(const T &intake_pa, const T &intake_k, const T &exhaust_pa, double speed_radps) {
    const T kpa = at_least<T>(intake_pa, 25e3) / 1e3;
    T fit(0.0);
    for (const double coefficient : filling) fit = fit * kpa + coefficient;
    const T eta =
        fit * (compression_ratio - pow(exhaust_pa / intake_pa, 1 / air.gamma())) / (compression_ratio - 1);
    return eta * (displacement_m3 * speed_radps / (4 * M_PI)) * intake_pa / (air.r * intake_k);
}

template <class T> using State = std::array<T, turbo_si_states>;

// dp/dt and dT/dt of a volume from its mass and energy balance; both stand in the balances through the same
// flows.
template <class T>
void fill(T *rates, const T &pa, const T &k, double m3, const Gas &gas, const Stream<T> &in,
          const T &out_kgps) {
    const T mass = pa * m3 / (gas.r * k);
    const T energy_w = gas.cp * (in.kgps * in.k - out_kgps * k);
    rates[0] = energy_w * (gas.r / (gas.cv() * m3));
    rates[1] = (energy_w - gas.cv() * k * (in.kgps - out_kgps)) / (mass * gas.cv());
}

template <class T> struct Engine {
    State<T> rates;
    std::array<T, 4> flows; ///< Waf, Wcomp, Wic, Wth
};

template <class T> Engine<T> evaluate(const State<T> &x, const TurboSiInputs &u) {
    const auto &[paf, taf, pcomp, tcomp, pic, tic, pim, tim, pem, tem, pt, tt, wtc] = x;
    const T ambient_pa(u.ambient_pa), ambient_k(u.ambient_k);
    const double area_m2 =
        throttle_area[0] + u.throttle_rad * (throttle_area[1] + u.throttle_rad * throttle_area[2]);

    const T waf = quadratic_loss(air_filter, ambient_pa, paf, ambient_k);
    const Stream<T> comp = compressor(paf, taf, pcomp, wtc);
    const T wic = quadratic_loss(intercooler, pcomp, pic, tcomp);
    const T removed =
        intercooler_fit[0] + intercooler_fit[1] * (tcomp + ambient_k) / 2 + intercooler_fit[2] * wic;
    const T cooled_k = tcomp - (tcomp - ambient_k) * at_least<T>(removed, 0);
    const T wth = nozzle(air, area_m2, pic, pim, tic);
    const T wcyl = cylinder_air(pim, tim, pem, u.speed_radps);

    const T burnt = wcyl * (1 + 1 / (u.lambda * stoichiometric));
    const T engine_out = engine_out_k + engine_out_k_per_kgps * burnt;
    const T into_em_k =
        ambient_k + (engine_out - ambient_k) * exp(-pipe_loss_w_per_k * 4 / (burnt * exhaust.cp));
    const Turbine<T> turb = turbine(pem, tem, pt, wtc);
    const T wwg = nozzle(exhaust, wastegate_area_m2 * u.wastegate, pem, pt, tem);
    const T past = turb.kgps + wwg;
    const Stream<T> mixed{past, (turb.kgps * turb.out_k + wwg * tem) / past};
    const T wes = quadratic_loss(exhaust_system, pt, ambient_pa, tt);
    const T compressor_w = comp.kgps * air.cp * (comp.k - taf);

    Engine<T> engine;
    engine.flows = {waf, comp.kgps, wic, wth};
    T *rates = engine.rates.data();
    fill<T>(rates, paf, taf, volume.af, air, {waf, ambient_k}, comp.kgps);
    fill<T>(rates + 2, pcomp, tcomp, volume.comp, air, comp, wic);
    fill<T>(rates + 4, pic, tic, volume.ic, air, {wic, cooled_k}, wth);
    fill<T>(rates + 6, pim, tim, volume.im, air, {wth, tic}, wcyl);
    fill<T>(rates + 8, pem, tem, volume.em, exhaust, {burnt, into_em_k}, past);
    fill<T>(rates + 10, pt, tt, volume.t, exhaust, mixed, wes);
    rates[12] = ((turb.power_w - compressor_w) / wtc - shaft_friction_nms * wtc) / shaft_inertia_kgm2;
    return engine;
}

using Vector = Eigen::Matrix<double, turbo_si_states, 1>;
using Matrix = Eigen::Matrix<double, turbo_si_states, turbo_si_states>;
using Dual = Eigen::AutoDiffScalar<Vector>;

struct Linearised {
    Vector rates;
    Matrix a;
    Eigen::MatrixXd c;
};

Linearised linearise(const Vector &x, const TurboSiInputs &inputs) {
    State<Dual> state;
    for (int i = 0; i < turbo_si_states; ++i) state[std::size_t(i)] = Dual(x[i], turbo_si_states, i);
    const auto engine = evaluate(state, inputs);
    Linearised result{{}, {}, Eigen::MatrixXd::Identity(turbo_si_sensors, turbo_si_states)};
    for (int i = 0; i < turbo_si_states; ++i) {
        result.rates[i] = engine.rates[std::size_t(i)].value();
        result.a.row(i) = engine.rates[std::size_t(i)].derivatives().transpose();
    }
    for (int i = 0; i < 4; ++i)
        result.c.row(turbo_si_states + i) = engine.flows[std::size_t(i)].derivatives().transpose();
    return result;
}

Vector unit_sizes() {
    Vector size;
    size << 1e5, 300, 1e5, 300, 1e5, 300, 1e5, 300, 1e5, 1000, 1e5, 1000, 1e4;
    return size;
}

// Backward Euler with a step that grows as it succeeds: robust like simulation at first, Newton's method at
// last.
Vector steady_state(const TurboSiInputs &inputs) {
    const double pa = inputs.ambient_pa, k = inputs.ambient_k;
    Vector x;
    x << pa - 500, k, pa, k, pa - 500, k, 0.6 * pa, k, pa + 6e3, 900, pa + 2e3, 880, 4000;
    const Vector size = unit_sizes();
    double step_s = 1e-3;
    for (int round = 0; round < 2000; ++round) {
        const auto here = linearise(x, inputs);
        if (!here.rates.allFinite()) break;
        if (step_s > 1e6 && (here.rates.array() / size.array()).abs().maxCoeff() < 1e-9) return x;
        const Vector move = linalg::solve(Matrix::Identity() / step_s - here.a, here.rates);
        const double share = (move.array() / size.array()).abs().maxCoeff();
        // A step that would leave the region where the linearisation holds is cut instead of taken.
        if (!(share < 0.1)) {
            step_s /= 4;
            if (step_s < 1e-9) break;
            continue;
        }
        x += move;
        step_s *= 1.5;
    }
    throw InputError("turbo_si", "point",
                     fmt::format("no steady state at {:.0f} rpm, throttle {:.1f} deg, wastegate {:.2f}",
                                 inputs.speed_radps * 30 / M_PI, inputs.throttle_rad * 180 / M_PI,
                                 inputs.wastegate));
}

} // namespace

TurboSiState turbo_si_rates(const TurboSiState &state, const TurboSiInputs &inputs) {
    return evaluate(state, inputs).rates;
}

LinearPoint turbo_si_point(const TurboSiInputs &inputs) {
    const Vector x = steady_state(inputs);
    const auto here = linearise(x, inputs);
    const bool choked = x[6] / x[4] < critical_ratio(air);
    return {"", choked ? "choked" : "unchoked", here.a, here.c, {x.data(), x.data() + x.size()}};
}

bool turbo_si_fits(const SensorModel &model) {
    const std::vector<std::string> states{"paf", "Taf", "pcomp", "Tcomp", "pic", "Tic", "pim",
                                          "Tim", "pem", "Tem",   "pt",    "Tt",  "wtc"};
    auto sensors = states;
    sensors.insert(sensors.end(), {"Waf", "Wcomp", "Wic", "Wth"});
    const auto all = model.sensor_names((SensorSet(1) << model.sensors.size()) - 1);
    return model.states == states && all == sensors && model.regimes.size() == 2 &&
           model.regimes[0].name == "unchoked" && model.regimes[1].name == "choked";
}

} // namespace sixdeg
