// SPDX-License-Identifier: MIT
// What a block costs on this host, and a dense Eigen version of the same torque observer in the same run.
#include <Eigen/Core>
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>

#include "cli/bench.hpp"
#include "common/toml_file.hpp"
#include "design/calibration.hpp"
extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

namespace sixdeg {
namespace {

constexpr int kPositions = 60, kCycle = 2 * kPositions;
constexpr double kPitch = 2 * M_PI / kPositions, kTickHz = 1e7;

/// Made once: it costs a thousand times what is timed here.
const sd_calibration_t &bench_calibration(int harmonics) {
    static std::map<int, sd_calibration_t> pages;
    const auto made = pages.find(harmonics);
    if (made != pages.end()) return made->second;
    TomlFile file(std::filesystem::path(SD_DATA "/engines/diesel_22.toml"));
    EngineFile engine = read_engine(file);
    engine.tick_hz = kTickHz;
    TomlFile tune("bench", fmt::format("[torque]\nharmonics = {}\ngain_energy = 4\n", harmonics));
    return pages.emplace(harmonics, calibrate(engine, read_tune(tune), "bench")).first->second;
}

/// Tooth periods of 1500 rpm with the ripple of a four-cylinder, ticks.
std::vector<std::uint32_t> periods() {
    std::vector<std::uint32_t> ticks;
    for (int k = 0; k < kCycle; ++k) {
        ticks.push_back(std::uint32_t(kPitch / (157.08 * (1 + 0.02 * std::sin(2 * kPitch * k))) * kTickHz));
    }
    return ticks;
}

template <class State, class Init, class Step> void observer(benchmark::State &state, Init init, Step step) {
    const sd_calibration_t &calibration = bench_calibration(int(state.range(0)));
    const sd_fourier_config_t config = sd_calibration_torque(&calibration, &calibration.parameters);
    auto self = std::make_unique<State>();
    if (init(self.get(), &config, &calibration.fourier) != SD_OK) state.SkipWithError("refused");
    const auto ticks = periods();
    unsigned k = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(step(self.get(), &calibration.fourier, k, 1, ticks[k], 1));
        k = (k + 1) % kCycle;
    }
}

/// The same observer as dense linear algebra: x <- A_k x + b_k E, one matrix a position.
void dense(benchmark::State &state) {
    const int harmonics = int(state.range(0)), n = 2 * harmonics + 2;
    const sd_calibration_t &calibration = bench_calibration(harmonics);
    const sd_parameters_t &tune = calibration.parameters;
    std::vector<Eigen::MatrixXf> a;
    std::vector<Eigen::VectorXf> b, f;
    for (int k = 0; k < kCycle; ++k) {
        Eigen::VectorXd basis(n - 1), gain(n);
        basis(0) = 1;
        gain(0) = double(tune.torque_gain_energy_per_rad);
        gain(1) = double(tune.torque_gain_mean_per_rad2);
        for (int i = 1; i <= harmonics; ++i) {
            basis(2 * i - 1) = std::cos(i * kPitch * k / 2);
            basis(2 * i) = std::sin(i * kPitch * k / 2);
            gain(2 * i) = i * double(tune.torque_gain_reference_per_rad2) * basis(2 * i - 1);
            gain(2 * i + 1) = i * double(tune.torque_gain_reference_per_rad2) * basis(2 * i);
        }
        Eigen::MatrixXd correct = Eigen::MatrixXd::Identity(n, n), predict = correct;
        correct.col(0) -= kPitch * gain;
        predict.block(0, 1, 1, n - 1) = kPitch * basis.transpose();
        a.push_back((predict * correct).cast<float>());
        b.push_back((predict * (kPitch * gain)).cast<float>());
        f.push_back(basis.cast<float>());
    }
    const auto ticks = periods();
    std::vector<float> inertia_kgm2;
    for (int k = 0; k < kPositions; ++k)
        inertia_kgm2.push_back(calibration.fourier.inertia_base_kgm2 * float(calibration.fourier.inertia_q31[k]) / 2147483648.0f);
    Eigen::VectorXf x = Eigen::VectorXf::Zero(n), next(n);
    unsigned k = 0;
    for (auto _ : state) {
        const float speed = float(kPitch * kTickHz) / float(ticks[k]);
        const float energy = 0.5f * inertia_kgm2[k % kPositions] * speed * speed;
        next.noalias() = a[k] * x;
        next += b[k] * energy;
        x.swap(next);
        benchmark::DoNotOptimize(f[k].dot(x.tail(n - 1)));
        k = (k + 1) % kCycle;
    }
}

/// Ticks of the present edges of a 60-2 wheel, one after the other.
class Edges {
  public:
    std::uint32_t next() {
        do {
            tick_ += ticks_[position_];
            position_ = (position_ + 1) % kCycle;
        } while (position_ % kPositions >= 58);
        return tick_;
    }

  private:
    std::vector<std::uint32_t> ticks_ = periods();
    std::uint32_t tick_ = 0;
    unsigned position_ = 0;
};

void decoder(benchmark::State &state) {
    const sd_calibration_t &calibration = bench_calibration(5);
    const sd_crank_config_t config = sd_calibration_crank(&calibration, &calibration.parameters);
    sd_crank_t crank;
    sd_crank_init(&crank, &config);
    Edges edges;
    sd_tooth_t tooth;
    for (auto _ : state) {
        sd_crank_edge(&crank, edges.next(), &tooth);
        benchmark::DoNotOptimize(tooth);
    }
}

void whole_ecu(benchmark::State &state) {
    const sd_calibration_t &calibration = bench_calibration(int(state.range(0)));
    auto ecu = std::make_unique<sd_ecu_t>();
    sd_ecu_init(ecu.get(), &calibration);
    auto wire = std::make_unique<sd_inproc_t>();
    const sd_port_t ecu_side = sd_inproc_ecu_side(wire.get()), host_side = sd_inproc_host_side(wire.get());
    Edges edges;
    sd_event_t answers[64];
    for (auto _ : state) {
        const sd_event_t event{edges.next(), SD_EVENT_CRANK_EDGE, 0, 0, 0};
        host_side.send(host_side.context, &event, 1);
        sd_ecu_run(ecu.get(), &calibration, &ecu_side);
        host_side.receive(host_side.context, answers, 64);
        benchmark::DoNotOptimize(answers);
    }
}

} // namespace

void add_block_benches() {
    using benchmark::RegisterBenchmark;
    RegisterBenchmark("crank decoder, per edge", decoder);
    for (const int harmonics : {5, 12}) {
        const auto with = [&](benchmark::internal::Benchmark *b) { b->Arg(harmonics); };
        const auto f32 = [](benchmark::State &s) { observer<sd_fourier_f32_t>(s, sd_fourier_init_f32, sd_fourier_step_f32); };
        const auto q31 = [](benchmark::State &s) { observer<sd_fourier_q31_t>(s, sd_fourier_init_q31, sd_fourier_step_q31); };
        with(RegisterBenchmark("torque f32, per tooth", f32));
        with(RegisterBenchmark("torque q31, per tooth", q31));
        with(RegisterBenchmark("torque dense Eigen, per tooth", dense));
        with(RegisterBenchmark("whole ecu, per edge", whole_ecu));
    }
}

} // namespace sixdeg
