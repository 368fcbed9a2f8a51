// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/numeric_study.hpp"

#include <algorithm>
#include <cmath>

#include "common/progress.hpp"
#include "studies/sensor_sets/kalman.hpp"

namespace sixdeg {
namespace {

const std::vector<Scaling> scalings{Scaling::si, Scaling::sized, Scaling::rows};
const std::vector<double> tolerances{1e-6, 1e-8, 1e-10, 1e-12, 1e-14};

std::size_t regime_number(const SensorModel &model, const std::string &name) {
    std::size_t i = 0;
    while (model.regimes[i].name != name) ++i;
    return i;
}

class Study {
  public:
    Study(const SensorModel &model, const NumericModel &numeric, const Ranking &ranking,
          const std::vector<int> &targets)
        : model_(model), numeric_(numeric), ranking_(ranking), targets_(targets) {}

    NumericStudy run() {
        NumericStudy result;
        result.sets.resize(ranking_.sets.size());
        result.tolerances = tolerances;
        std::vector<std::string> seen;
        for (std::size_t point = 0; point < numeric_.points.size(); ++point) {
            result.points.push_back(
                compare(point, reference_scaling, {reference_tolerance}, &result.sets).front());
            if (std::count(seen.begin(), seen.end(), numeric_.points[point].regime)) continue;
            seen.push_back(numeric_.points[point].regime);
            for (const Scaling scaling : scalings) {
                const auto rows = compare(point, scaling, tolerances, nullptr);
                result.sensitivity.insert(result.sensitivity.end(), rows.begin(), rows.end());
            }
            result.published.emplace_back();
            for (const auto &published : model_.published) {
                const Augmented system =
                    augment(model_, numeric_.points[point], numeric_.scale, published.set);
                result.published.back().push_back(
                    numeric_index(system, targets_, reference_scaling, tolerances));
            }
        }
        Progress progress("set", double(result.sets.size()));
        for (std::size_t i = 0; i < result.sets.size(); ++i, progress.next()) add_sigma(ranking_.sets[i].set, result.sets[i]);
        return result;
    }

  private:
    // One comparison a tolerance; with `sets`, the first tolerance's index is noted there too.
    std::vector<Comparison> compare(std::size_t point, Scaling scaling, const std::vector<double> &wanted,
                                    std::vector<StudiedSet> *sets) const {
        std::vector<Comparison> rows;
        for (const double tolerance : wanted) rows.push_back({point, scaling, tolerance, {}, 0});
        const LinearPoint &at = numeric_.points[point];
        const std::size_t regime = regime_number(model_, at.regime);
        Progress progress("set", double(ranking_.sets.size()));
        for (std::size_t i = 0; i < ranking_.sets.size(); ++i, progress.next()) {
            const Augmented system = augment(model_, at, numeric_.scale, ranking_.sets[i].set);
            const auto index = numeric_index(system, targets_, scaling, wanted);
            for (std::size_t k = 0; k < rows.size(); ++k) {
                ++rows[k].histogram[index[k]];
                rows[k].agree += index[k] == ranking_.sets[i].index[regime];
            }
            if (sets) (*sets)[i].index.push_back(index.front());
        }
        return rows;
    }

    void add_sigma(SensorSet set, StudiedSet &studied) const {
        std::vector<double> square(targets_.size(), 0);
        for (const auto &point : numeric_.points) {
            const auto sigma = steady_sigma(model_, numeric_, point, set, targets_);
            for (std::size_t i = 0; i < sigma.size(); ++i)
                square[i] += sigma[i] * sigma[i] / double(numeric_.points.size());
        }
        double relative = 0;
        for (std::size_t i = 0; i < square.size(); ++i) {
            studied.sigma.push_back(std::sqrt(square[i]));
            const double scale = numeric_.scale[targets_[i]];
            relative += square[i] / (scale * scale) / double(square.size());
        }
        studied.relative_sigma = std::sqrt(relative);
    }

    const SensorModel &model_;
    const NumericModel &numeric_;
    const Ranking &ranking_;
    const std::vector<int> &targets_;
};

} // namespace

NumericStudy study(const SensorModel &model, const NumericModel &numeric, const Ranking &ranking,
                   const std::vector<int> &targets) {
    return Study(model, numeric, ranking, targets).run();
}

const char *name_of(Scaling scaling) {
    switch (scaling) {
    case Scaling::si:
        return "si";
    case Scaling::sized:
        return "sized";
    case Scaling::rows:
        return "rows";
    }
    return "";
}

} // namespace sixdeg
