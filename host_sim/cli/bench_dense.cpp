// SPDX-License-Identifier: MIT
// The same work as dense linear algebra, with Eigen's matrices of a size known at run time: what a block's structure is worth.
#include <Eigen/Core>
#include <benchmark/benchmark.h>
#include <cmath>
#include <random>

#include "cli/bench.hpp"
#include "cli/bench_drive.hpp"

namespace sixdeg {
namespace {

constexpr int kCycle = 120, kCylinders = 4;

/// Numbers of no meaning; a contraction, so that states neither grow nor fade into numbers that cost more.
Eigen::MatrixXf contraction(int n, std::mt19937 &random) {
    std::uniform_real_distribution<float> number(-1, 1);
    return Eigen::MatrixXf::NullaryExpr(n, n, [&] { return 0.9f / float(n) * number(random); });
}

/// x <- A_k x + B_k u, a matrix a position of the cycle, and what is read from x.
void linear(benchmark::State &state, int states, int inputs, int matrices) {
    std::mt19937 random(1);
    std::vector<Eigen::MatrixXf> a, b;
    for (int k = 0; k < matrices; ++k) a.push_back(contraction(states, random)), b.push_back(Eigen::MatrixXf::Ones(states, inputs));
    const Eigen::VectorXf read = Eigen::VectorXf::Ones(states), u = Eigen::VectorXf::Constant(inputs, 0.3f);
    Eigen::VectorXf x = Eigen::VectorXf::Zero(states), next(states);
    std::size_t k = 0;
    for (auto _ : state) {
        next.noalias() = a[k] * x;
        next.noalias() += b[k] * u;
        x.swap(next);
        benchmark::DoNotOptimize(read.dot(x));
        k = k + 1 == a.size() ? 0 : k + 1;
    }
}

void fourier(benchmark::State &state) {
    const int harmonics = int(bench_page()->parameters.torque_harmonics);
    linear(state, 2 * harmonics + 2, 1, kCycle);
}
/// v1 and v2, from input and speed.
void switched(benchmark::State &state) { linear(state, 2, 2, 1); }
/// The manifold's air and each cylinder's, which come and go by position.
void observer(benchmark::State &state) { linear(state, kCylinders + 1, 1, kCycle); }
/// Two lags and the gas as a mean and two harmonics.
void inversion(benchmark::State &state) { linear(state, 7, 1, kCycle); }

/// Kalman's filter of manifold, cylinders and two lags, with its covariance.
void joint(benchmark::State &state) {
    const int n = kCylinders + 3;
    std::mt19937 random(1);
    std::vector<Eigen::MatrixXf> a;
    for (int k = 0; k < kCycle; ++k) a.push_back(contraction(n, random));
    const Eigen::MatrixXf walk = Eigen::MatrixXf::Identity(n, n) * 1e-3f;
    Eigen::MatrixXf p = walk, product(n, n);
    Eigen::VectorXf x = Eigen::VectorXf::Zero(n), next(n), gain(n);
    std::size_t k = 0;
    for (auto _ : state) {
        next.noalias() = a[k] * x;
        product.noalias() = a[k] * p;
        p.noalias() = product * a[k].transpose();
        p += walk;
        gain = p.col(n - 1) / (p(n - 1, n - 1) + 1e-2f);
        x = next + gain * (0.3f - next(n - 1));
        product.noalias() = gain * p.row(n - 1);
        p -= product;
        benchmark::DoNotOptimize(x.data());
        k = k + 1 == a.size() ? 0 : k + 1;
    }
}

void add(const char *block, void (*body)(benchmark::State &)) {
    benchmark::RegisterBenchmark((std::string(block) + "|dense").c_str(), body);
}

} // namespace

void add_dense_benches() {
    add("Fourier observer", fourier);
    for (const char *name : {"FOLSMO", "FOSMO", "ROO"}) add(name, switched);
    add("A, observer of cylinders", observer);
    add("D, sensor inverted, oscillators", inversion);
    add("joint filter", joint);
}

} // namespace sixdeg
