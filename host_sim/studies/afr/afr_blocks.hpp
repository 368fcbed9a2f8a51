// SPDX-License-Identifier: MIT
// The AFR blocks on a trace: document 004's chain, block A alone, or the joint filter, each with the same B and C. V names
// the number type.
#pragma once
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "design/afr/joint_gains.hpp"
#include "design/afr/uego_gains.hpp"
#include "studies/afr/afr_judge.hpp"
extern "C" {
#include "sd_afr_chain.h"
#include "sd_afr_joint.h"
}

namespace sixdeg {

#define SD_AFR_VARIANT(NAME, N, TYPE)                                                                        \
    struct NAME {                                                                                            \
        using Type = TYPE;                                                                                   \
        using Exhaust = sd_exhaust_##N##_t;                                                                  \
        using Now = sd_exhaust_now_##N##_t;                                                                  \
        using Chain = sd_afr_chain_##N##_t;                                                                  \
        static constexpr auto exhaust_init = sd_exhaust_init_##N;                                            \
        static constexpr auto exhaust_shares = sd_exhaust_shares_##N;                                        \
        static constexpr auto exhaust_set = sd_exhaust_set_##N;                                              \
        static constexpr auto exhaust_measured = sd_exhaust_measured_##N;                                    \
        static constexpr auto exhaust_step = sd_exhaust_step_##N;                                            \
        static constexpr auto chain_init = sd_afr_chain_init_##N;                                            \
        static constexpr auto chain_set = sd_afr_chain_set_##N;                                              \
        static constexpr auto chain_step = sd_afr_chain_step_##N;                                            \
        static constexpr auto chain_lambda = sd_afr_chain_lambda_##N;                                        \
        static constexpr auto chain_variance = sd_afr_chain_deviation_variance_##N;                          \
        static constexpr auto observer_step = sd_afr_observer_step_##N;                                      \
        static Type of(double x) { return sd_from_float_##N(float(x)); }                                     \
    };
SD_AFR_VARIANT(F32, f32, float)
SD_AFR_VARIANT(Q31, q31, sd_q31_t)
#undef SD_AFR_VARIANT

inline void must(sd_result_t result) {
    if (result != SD_OK) throw std::logic_error("an AFR block refused its configuration");
}

/// psi as the exhaust block reads it.
template <class V> std::vector<typename V::Type> psi_table() {
    std::vector<typename V::Type> table;
    for (double psi : exhaust_psi()) table.push_back(V::of(psi));
    return table;
}

/// Where a cylinder's gas begins to flow, of a cycle of shares from firing TDC on.
inline std::uint16_t open_position(const std::vector<double> &share) {
    const auto first = std::find_if(share.begin(), share.end(), [](double s) { return s > 0; });
    return std::uint16_t(first == share.end() ? 0 : first - share.begin());
}

/// Such a cycle as the shares of the coming point.
template <class V> void give_shares(typename V::Exhaust &exhaust, const std::vector<double> &share) {
    std::vector<typename V::Type> open(SD_EXHAUST_OPEN);
    for (std::size_t k = 0; k < share.size(); ++k) {
        const double s = share[(k + open_position(share)) % share.size()];
        if (k < open.size()) open[k] = V::of(s);
        else if (s > 0) throw std::logic_error("a valve is open for longer than the block can hold");
    }
    must(V::exhaust_shares(&exhaust, 0, SD_EXHAUST_OPEN, open.data()));
}

inline sd_afr_inflow_t inflow(const sd_exhaust_now_f32_t &now) {
    sd_afr_inflow_t in;
    sd_afr_inflow_of(&now, &in);
    return in;
}

template <class V> class AfrBlocks {
  public:
    AfrBlocks(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace,
              const AfrSetup &setup)
        : engine_(engine), trace_(trace), setup_(setup), n_(engine.cylinders()) {
        const AfrError &error = setup.error;
        const double charge = point.charge_kg * (1 + error.flow);
        sd_exhaust_config_t e{};
        e.cycle_positions = std::uint16_t(trace.cycle_positions);
        e.cylinders = std::uint8_t(n_);
        e.mass_base_kg = float(kBaseCharges * charge);
        for (int i = 0; i < n_; ++i) {
            const double after = (engine.firing_tdc_deg[std::size_t(i)] - engine.position_0_deg + 720) / 360 *
                                 engine.wheel.positions;
            e.firing_position[i] = std::uint16_t(int(std::ceil(after - 1e-9)) % trace.cycle_positions);
        }
        e.open_position = open_position(point.share);
        e.gain_mass = float(setup.gain_mass);
        must(V::exhaust_init(&exhaust_, &e));
        give_shares<V>(exhaust_, point.share);
        const bool at_manifold = setup.method == AfrMethod::true_gas;
        const double wait =
            engine.exhaust->dead_time_s / trace.step_s + error.delay_deg / 360 * engine.wheel.positions +
            double(SD_UEGO_LEAD);
        const double outflow = 1 / (1 - setup.egr_share); // over the turbine's, which alone fills the pipe
        const sd_exhaust_point_t p{float(charge),
                                   float(point.rate_hz * (1 + error.turbine) * outflow),
                                   float(point.z0_kg),
                                   at_manifold ? 0.0f : float(point.transport_kg * outflow),
                                   at_manifold ? 0.0f : float(wait),
                                   float(kBehindBar)};
        must(V::exhaust_set(&exhaust_, &p, float(trace.step_s)));
        init_chain();
        init_joint();
    }

    AfrEstimates run(const std::vector<double> &noise) {
        AfrEstimates result;
        for (std::size_t k = 0; k < trace_.sensor.size(); ++k) {
            const auto position =
                std::uint32_t((trace_.first_cycle_position + k) % std::size_t(trace_.cycle_positions));
            const double measured = setup_.method == AfrMethod::true_gas
                                        ? trace_.gas[k]
                                        : trace_.sensor[k] + (noise.empty() ? 0 : noise[k]);
            step(position, 1 - measured, setup_.gain_mass > 0 ? trace_.pressure_bar[k] : 0);
            if (int(k % std::size_t(trace_.cycle_positions)) == trace_.cycle_positions - 1) read(result);
        }
        return result;
    }

    /// A cycle here ends where the trace's first position comes round again.
    sd_afr_learned_t probe(const std::vector<double> &noise, const std::vector<std::array<double, 8>> &trims) {
        const sd_afr_delay_config_t c{std::uint16_t(trace_.cycle_positions), std::uint8_t(n_), joint_.config.tau1_s, joint_.config.tau2_s};
        sd_afr_delay_t delay;
        must(sd_afr_delay_init(&delay, &c));
        const double radps = 4 * M_PI / (trace_.step_s * trace_.cycle_positions);
        std::size_t cycle = 0;
        for (std::size_t k = 0; k < trace_.sensor.size(); ++k) {
            const auto position = std::uint32_t((trace_.first_cycle_position + k) % std::size_t(trace_.cycle_positions));
            typename V::Now now;
            V::exhaust_step(&exhaust_, psi_.data(), position, &now);
            const double air = 1 - trace_.sensor[k] - (noise.empty() ? 0 : noise[k]);
            if constexpr (std::is_same_v<V, F32>) {
                const sd_afr_inflow_t in = inflow(now);
                sd_afr_delay_step(&delay, &in, position, float(air));
            }
            if (int(k % std::size_t(trace_.cycle_positions)) != trace_.cycle_positions - 1) continue;
            std::array<float, 8> told{}; // of the cycle that ends: its gas arrives from now on
            for (std::size_t i = 0; i < std::size_t(n_); ++i)
                told[i] = float(trims[cycle][i] / (1 + trims[cycle][i]) * (1 - setup_.mean_lambda / (1 + kStoichiometric)));
            const bool begins = trims[cycle][0] != 0 && (cycle == 0 || trims[cycle - 1][0] == 0);
            if (begins) sd_afr_delay_probe(&delay, true);
            const sd_afr_trims_t t{float(radps), told.data(), float(setup_.mean_lambda), 1};
            if (sd_afr_delay_cycle(&delay, &t)) break;
            ++cycle;
        }
        return delay.learned;
    }

  private:
    static constexpr double kBaseCharges = 6, kStoichiometric = 14.6, kBehindBar = 1.013;

    bool is_joint() const { return setup_.method == AfrMethod::joint || setup_.method == AfrMethod::joint_fixed; }

    void init_chain() {
        for (int k = 0; k < trace_.cycle_positions; ++k)
            sine_.push_back(
                std::int32_t(std::lround(2147483647.0 * std::sin(2 * M_PI * k / trace_.cycle_positions))));
        const double tau1 = engine_.exhaust->uego_tau_s[0] * (1 + setup_.error.tau),
                     tau2 = engine_.exhaust->uego_tau_s[1] * (1 + setup_.error.tau);
        sd_afr_chain_config_t c{};
        c.cycle_positions = std::uint16_t(trace_.cycle_positions);
        c.cylinders = std::uint8_t(n_), c.harmonics = std::uint8_t(setup_.harmonics);
        c.tau1_s = float(tau1), c.tau2_s = float(tau2);
        c.gain_air = float(setup_.gain_air), c.gain_cylinder = float(setup_.gain_cylinder);
        c.inversion_gain = float(setup_.inversion_gain), c.inversion_floor = float(setup_.inversion_floor);
        must(V::chain_init(&chain_, &c));
        if (setup_.method == AfrMethod::oscillator)
            gains_ = uego_gains({tau1, tau2, trace_.step_s, trace_.cycle_positions, setup_.harmonics, setup_.noise,
                                 setup_.oscillator_drift});
        cycle_chain();
    }

    void cycle_chain() {
        V::chain_set(&chain_, sine_.data(), float(trace_.step_s), setup_.method == AfrMethod::oscillator ? &gains_ : nullptr,
                     exhaust_.charge);
    }

    void init_joint() {
        const double density = setup_.noise * std::sqrt(2 * trace_.step_s);
        const sd_afr_joint_config_t c{std::uint8_t(n_),
                                      std::uint16_t(trace_.cycle_positions),
                                      float(engine_.exhaust->uego_tau_s[0] * (1 + setup_.error.tau)),
                                      float(engine_.exhaust->uego_tau_s[1] * (1 + setup_.error.tau)),
                                      float(density),
                                      float(setup_.drift * setup_.mean_lambda),
                                      0.1f,
                                      1000};
        must(sd_afr_joint_init(&joint_, &c));
        sd_afr_joint_set(&joint_, float(trace_.step_s), c.drift, float(setup_.jump * setup_.mean_lambda));
        if (setup_.method == AfrMethod::joint_fixed) fix_gains(c);
    }

    /// From the exhaust block's own cycle, once it repeats itself.
    void fix_gains(const sd_afr_joint_config_t &c) {
        constexpr int kSettle = 40; // cycles
        JointDesign d{{}, n_, double(c.tau1_s), double(c.tau2_s), trace_.step_s, setup_.noise, double(c.drift)};
        typename V::Exhaust exhaust = exhaust_;
        for (int k = 0; k < (kSettle + 1) * trace_.cycle_positions; ++k) {
            typename V::Now now;
            V::exhaust_step(&exhaust, psi_.data(), std::uint32_t(k % trace_.cycle_positions), &now);
            if (k < kSettle * trace_.cycle_positions) continue;
            JointPosition position{double(now.mass), {}};
            for (std::size_t i = 0; i < std::size_t(n_); ++i)
                position.inflow[i] = double(now.charge) * double(now.share[i]);
            d.cycle.push_back(position);
        }
        fixed_gains_ = joint_gains(d);
    }

    /// pressure_bar 0: not measured.
    void step(std::uint32_t position, double air, double pressure_bar) {
        typename V::Now now;
        V::exhaust_step(&exhaust_, psi_.data(), position, &now);
        if (pressure_bar > 0) V::exhaust_measured(&exhaust_, V::of(pressure_bar / SD_EXHAUST_BAR));
        if (setup_.method == AfrMethod::true_gas) return V::observer_step(&chain_.observer, &now, V::of(air));
        if (!is_joint()) return V::chain_step(&chain_, sine_.data(), &now, position, V::of(air));
        if constexpr (std::is_same_v<V, F32>) {
            const sd_afr_inflow_t in = inflow(now);
            sd_afr_joint_step(&joint_, &in, float(air), fixed_gains_.empty() ? nullptr : fixed_gains_[position].data());
        }
    }

    void read(AfrEstimates &result) {
        std::array<double, 8> lambda{};
        for (std::uint32_t i = 0; i < std::uint32_t(n_); ++i)
            lambda[i] = double(is_joint() ? sd_afr_joint_lambda(&joint_, i) : V::chain_lambda(&chain_, i));
        result.lambda.push_back(lambda);
        if (!is_joint()) cycle_chain();
        const double variance = is_joint() ? joint_variance() : double(V::chain_variance(&chain_));
        result.sd.push_back(std::sqrt(variance + of_the_model(lambda)));
        if (is_joint()) result.blamed.push_back(blamed(result));
    }

    double joint_variance() const {
        float variance[SD_AFR_CYLINDERS_MAX];
        sd_afr_joint_deviation_variances(&joint_, variance);
        return double(variance[0]);
    }

    AfrBlamed blamed(const AfrEstimates &so_far) const {
        sd_afr_usual_t usual{float(setup_.usual_sd * setup_.mean_lambda), 0, 0};
        const auto lane = [&] { return int(sd_afr_joint_blame(&joint_, &usual).cylinder); };
        AfrBlamed b{lane(), lane()};
        constexpr std::size_t kFrom = 24, kTo = 8; // cycles ago
        if (so_far.lambda.size() <= kFrom) return b;
        for (auto at = so_far.lambda.end() - kFrom; at != so_far.lambda.end() - kTo; ++at)
            for (int i = 0; i < n_; ++i) usual.lambda += float((*at)[std::size_t(i)] / n_ / (kFrom - kTo));
        usual.lambda_sd = float(setup_.usual_mean_sd * setup_.mean_lambda);
        b.with_mean = lane();
        return b;
    }

    /// As sd_afr_read has it.
    double of_the_model(const std::array<double, 8> &lambda) const {
        double mean = 0, square = 0;
        for (int i = 0; i < n_; ++i) mean += lambda[std::size_t(i)] / n_;
        for (int i = 0; i < n_; ++i) square += std::pow(lambda[std::size_t(i)] - mean, 2) / n_;
        return square * double(sd_afr_delay_doubt(&setup_.known, float(4 * M_PI / (trace_.step_s * trace_.cycle_positions)),
                                                  joint_.config.tau1_s, joint_.config.tau2_s));
    }

    const EngineFile &engine_;
    const AfrTrace &trace_;
    AfrSetup setup_;
    int n_;
    std::vector<typename V::Type> psi_ = psi_table<V>();
    std::vector<std::int32_t> sine_;
    typename V::Exhaust exhaust_;
    typename V::Chain chain_;
    sd_uego_gains_t gains_{};
    std::vector<std::vector<float>> fixed_gains_;
    sd_afr_joint_t joint_;
};

} // namespace sixdeg
