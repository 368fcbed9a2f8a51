// SPDX-License-Identifier: MIT
#include "studies/afr/afr_errors.hpp"

#include <algorithm>
#include <cmath>

#include "common/progress.hpp"

namespace sixdeg::afr_study {

Errors errors_of(const Run &run, const Case &c, const AfrEstimates &e) {
    Errors x;
    const std::size_t from = run.at / 120 + std::size_t(c.scored_from());
    double count = 0;
    for (std::size_t k = from; k < e.lambda.size(); ++k) {
        double mean = 0;
        for (std::size_t i = 0; i < kLanes; ++i) mean += run.error(e, k, i) / kLanes;
        for (std::size_t i = 0; i < kLanes; ++i, ++count) {
            const double error = run.error(e, k, i);
            x.rms += error * error, x.deviations += std::pow(error - mean, 2);
            x.stated += std::pow(100 * e.sd[k] / run.mean, 2);
            if (k == from) x.first += error * error / kLanes;
        }
    }
    return {std::sqrt(x.rms / count), std::sqrt(x.first), std::sqrt(x.deviations / count), std::sqrt(x.stated / count)};
}

std::vector<Errors> errors_of_seeds(const Run &run, AfrSetup setup, const Case &c, double correlation_s, bool perturbed,
                                    int seeds, const Probe *probe) {
    std::vector<Errors> all;
    Progress progress("seed", seeds);
    for (int seed = 0; seed < seeds; ++seed, progress.next()) {
        if (perturbed) perturb(setup, c, seed, probe);
        all.push_back(errors_of(
            run, c, run.run(setup, sensor_noise(run.trace, c.noise, correlation_s, std::uint64_t(seed)))));
    }
    return all;
}

double percentile(const std::vector<Errors> &all, double Errors::*what, double p) {
    std::vector<double> x;
    for (const Errors &e : all) x.push_back(e.*what);
    std::sort(x.begin(), x.end());
    return x[std::size_t(p * double(x.size() - 1))];
}

double rms(const std::vector<Errors> &all, double Errors::*what) {
    double sum = 0;
    for (const Errors &e : all) sum += std::pow(e.*what, 2) / double(all.size());
    return std::sqrt(sum);
}

} // namespace sixdeg::afr_study
