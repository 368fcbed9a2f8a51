// SPDX-License-Identifier: MIT
// Which sensors, with numbers: the mean-value engine, the floating-point index, the steady Kalman filter.
#include <cmath>
#include <gtest/gtest.h>

#include "common/error.hpp"
#include "linalg/linalg.hpp"
#include "studies/sensor_sets/kalman.hpp"
#include "studies/sensor_sets/numeric_study.hpp"
#include "studies/sensor_sets/structural.hpp"
#include "studies/sensor_sets/turbo_si.hpp"

using namespace sixdeg;

namespace {

struct Loaded {
    SensorModel model;
    NumericModel numeric;
};

Loaded from(TomlFile file) {
    Loaded loaded;
    loaded.model = read_sensor_model(file);
    loaded.numeric = read_numeric_model(file, loaded.model);
    file.finish();
    return loaded;
}

Loaded load(const std::string &name) { return from(TomlFile(std::filesystem::path(SD_MODELS) / name)); }

TurboSiInputs part_load() {
    TurboSiInputs inputs;
    inputs.speed_radps = 3000 * M_PI / 30;
    inputs.throttle_rad = 20 * M_PI / 180;
    inputs.wastegate = 0.3;
    return inputs;
}

TurboSiState state_of(const LinearPoint &point) {
    TurboSiState state;
    std::copy(point.state.begin(), point.state.end(), state.begin());
    return state;
}

TEST(TurboSiEngine, RestsAtItsSteadyState) {
    const auto point = turbo_si_point(part_load());
    const auto rates = turbo_si_rates(state_of(point), part_load());
    for (std::size_t i = 0; i < rates.size(); ++i) EXPECT_LT(std::abs(rates[i]), 1e-6 * point.state[i]) << i;
    EXPECT_LT(linalg::eigenvalues(point.a).real().maxCoeff(), 0); // and it is stable
}

TEST(TurboSiEngine, JacobianIsTheDerivativeOfItsRates) {
    const auto point = turbo_si_point(part_load());
    const auto at = state_of(point);
    for (int j = 0; j < turbo_si_states; ++j) {
        auto up = at, down = at;
        const double step = 1e-6 * at[std::size_t(j)];
        up[std::size_t(j)] += step;
        down[std::size_t(j)] -= step;
        const auto high = turbo_si_rates(up, part_load()), low = turbo_si_rates(down, part_load());
        for (int i = 0; i < turbo_si_states; ++i) {
            const double difference = (high[std::size_t(i)] - low[std::size_t(i)]) / (2 * step);
            EXPECT_NEAR(point.a(i, j), difference, 1e-4 * point.a.row(i).cwiseAbs().maxCoeff() + 1e-6)
                << i << " " << j;
        }
    }
}

// The engine may use no link that the structure does not have, in its regime; and it uses nearly all.
TEST(TurboSiEngine, UsesTheLinksOfItsStructureOverTheMap) {
    const auto [model, numeric] = load("turbo_si_13.toml");
    std::map<std::string, int> points;
    for (const auto &point : numeric.points) {
        ++points[point.regime];
        const auto &structure = model.regimes[point.regime == "choked" ? 1 : 0].structure;
        const auto links = pattern(model, structure, 0).a;
        int used = 0, allowed = 0;
        for (int i = 0; i < turbo_si_states; ++i) {
            for (int j = 0; j < turbo_si_states; ++j) {
                const bool linked =
                    std::count(links[std::size_t(i)].begin(), links[std::size_t(i)].end(), j) > 0;
                allowed += linked;
                used += linked && point.a(i, j) != 0;
                EXPECT_TRUE(linked || point.a(i, j) == 0) << point.name << " " << i << " " << j;
            }
        }
        EXPECT_GE(used, allowed - 2) << point.name;
    }
    EXPECT_GE(points["choked"], 2);
    EXPECT_GE(points["unchoked"], 2);
}

TEST(TurboSiEngine, ThrottleIsAdiabaticAtRest) {
    const auto point = turbo_si_point(part_load());
    EXPECT_NEAR(point.state[5], point.state[7], 1e-6); // Tic = Tim, why Table 1 misses {Tic, pim, Tim}
}

TEST(TurboSiEngine, SaysWhenThereIsNoSteadyState) {
    auto inputs = part_load();
    inputs.speed_radps = 800;
    inputs.throttle_rad = 1.5;
    EXPECT_THROW(turbo_si_point(inputs), InputError);
}

// --- numeric index
// ------------------------------------------------------------------------------------------------

// With rows of length one and a tolerance near rounding, the numeric index is the exact one of the structure
// with shared flows, nearly everywhere; with plain SI units it is lost.
TEST(NumericIndex, NearRoundingItIsTheExactIndexOfTheSharedFlows) {
    const auto [model, numeric] = load("turbo_si_13.toml");
    TomlFile file{std::filesystem::path(SD_MODELS) / "turbo_si_13_flows.toml"};
    const auto flows = read_sensor_model(file);
    SetQuery query;
    query.targets = model.targets;
    query.least = query.most = 3;
    const auto exact = index_sets(flows, flows.regimes[0].structure, query).sets;
    int looked = 0, rows = 0, si = 0;
    for (std::size_t i = 0; i < exact.size(); i += 4) {
        const auto system = augment(model, numeric.points[0], numeric.scale, exact[i].set);
        ++looked;
        rows += numeric_index(system, query.targets, Scaling::rows, {1e-14})[0] == exact[i].index;
        si += numeric_index(system, query.targets, Scaling::si, {1e-14})[0] == exact[i].index;
    }
    EXPECT_EQ(looked, 170);
    EXPECT_GE(rows, 165);
    EXPECT_LE(si, 40);
}

TEST(NumericIndex, AgreesWithTheKnownAnswersOfTheSatellite) {
    const auto [model, numeric] = load("satellite_orbit.toml");
    const std::vector<int> expected{0, 0, 4, 0}; // r, vr, theta, vtheta
    for (std::size_t i = 0; i < 4; ++i) {
        const auto system = augment(model, numeric.points[0], numeric.scale, SensorSet(1) << i);
        EXPECT_EQ(numeric_index(system, model.targets, Scaling::si, {1e-9})[0], expected[i])
            << model.sensors[i].name;
    }
}

// --- Kalman filter
// ------------------------------------------------------------------------------------------------

// A random walk seen directly, or through a lag.
std::string walk(const std::string &lag) {
    return "name = 'walk'\n[states]\nx = ['x']\n[sensors]\ny = { sees = ['x'], noise = 0.5" + lag +
           " }\n[numeric]\nstep_s = 0.1\nscale = { x = 10 }\nprocess_noise = { x = 2 }\n"
           "[[numeric.jacobians]]\nname = 'p'\na = [0]\nc = [1]\n";
}

TEST(Kalman, RandomWalkHasTheTextbookVariance) {
    const auto [model, numeric] = from(TomlFile("w.toml", walk("")));
    const double q = 2 * 2 * 0.1, r = 0.5 * 0.5;
    const double predicted = (q + std::sqrt(q * q + 4 * q * r)) / 2;
    const auto sigma = steady_sigma(model, numeric, numeric.points[0], 1, {0});
    EXPECT_NEAR(sigma[0], std::sqrt(predicted * r / (predicted + r)), 1e-9);
}

TEST(Kalman, AVeryFastLagChangesNothingAndASlowOneCosts) {
    const auto plain = from(TomlFile("w.toml", walk("")));
    const auto fast = from(TomlFile("w.toml", walk(", lags_s = [1e-5]")));
    const auto slow = from(TomlFile("w.toml", walk(", lags_s = [1]")));
    const auto sigma = [](const Loaded &l) {
        return steady_sigma(l.model, l.numeric, l.numeric.points[0], 1, {0})[0];
    };
    EXPECT_NEAR(sigma(fast), sigma(plain), 1e-3 * sigma(plain));
    EXPECT_GT(sigma(slow), 1.5 * sigma(plain));
}

TEST(Kalman, SolvesTheRiccatiEquationOfTheEngine) {
    const auto [model, numeric] = load("turbo_si_13.toml");
    const auto f = steady_filter(model, numeric, numeric.points[0], 0b11000100); // pcomp pim Tim
    const Eigen::MatrixXd again = f.phi * f.updated * f.phi.transpose() + f.q;
    EXPECT_LT((again - f.predicted).norm(), 1e-8 * f.predicted.norm());
    const Eigen::MatrixXd s = f.c * f.predicted * f.c.transpose() + f.r;
    const Eigen::MatrixXd gain = linalg::solve(s, f.c * f.predicted).transpose(); // P C' S^-1, P and S symmetric
    const Eigen::MatrixXd updated = f.predicted - gain * f.c * f.predicted;
    EXPECT_LT((updated - f.updated).norm(), 1e-8 * f.updated.norm());
}

TEST(Kalman, MoreSensorsNeverHurt) {
    const auto [model, numeric] = load("turbo_si_13.toml");
    const auto sigma = [&, &model = model, &numeric = numeric](SensorSet set) {
        return steady_sigma(model, numeric, numeric.points[1], set, model.targets);
    };
    const SensorSet base = 0b1000000; // pim
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_LE(sigma(base | SensorSet(1) << i)[k], sigma(base)[k] * (1 + 1e-9)) << i;
    }
}

TEST(Kalman, ADriftNobodySeesHasNoSteadyDeviation) {
    const auto [model, numeric] = load("satellite_orbit.toml");
    const auto radius = steady_sigma(model, numeric, numeric.points[0], 0b0001, model.targets);
    EXPECT_TRUE(std::isinf(radius[2]));
    EXPECT_LT(radius[0], 1e-3);
    for (const double sigma : steady_sigma(model, numeric, numeric.points[0], 0b0100, model.targets))
        EXPECT_LT(sigma, 1e-2);
}

// --- reading
// ------------------------------------------------------------------------------------------------------

std::string complaint(std::string text, const std::string &what, const std::string &by) {
    text.replace(text.find(what), what.size(), by);
    try {
        from(TomlFile("w.toml", text));
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

TEST(NumericModelFile, NamesWhatIsWrong) {
    EXPECT_EQ(complaint(walk(""), "a = [0]", "a = [0, 1]"),
              "w.toml: numeric.jacobians[0].a: has 2 entries, not 1");
    EXPECT_EQ(complaint(walk(""), ", noise = 0.5", ""),
              "w.toml: sensors.y.noise: is missing; a model with \"numeric\" needs it");
    EXPECT_EQ(complaint(walk(""), "name = 'p'", "name = 'p'\nregime = 'q'"),
              "w.toml: numeric.jacobians[0].regime: 'q' is not a regime of the model");
    EXPECT_EQ(
        complaint(walk(""), "[[numeric.jacobians]]", "[[numeric.turbo_si_points]]"),
        "w.toml: numeric.turbo_si_points[0].name: needs the states, sensors and regimes of turbo_si_13.toml");
    EXPECT_EQ(complaint(walk(""), "step_s = 0.1", "step_s = 0"),
              "w.toml: numeric.step_s: 0 is outside [1e-06, 10] s");
    EXPECT_EQ(complaint(walk(""), "c = [1]", "c = [1]\nd = 3"),
              "w.toml: numeric.jacobians[0].d: is not a known field");
}

} // namespace
