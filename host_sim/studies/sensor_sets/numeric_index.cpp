// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/numeric_index.hpp"

#include <algorithm>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index rank(const VectorXd &singular, double tolerance) {
    if (singular.size() == 0) return 0;
    return (singular.array() > tolerance * singular[0]).count();
}

MatrixXd without_columns(const MatrixXd &matrix, const std::vector<int> &columns) {
    MatrixXd rest(matrix.rows(), matrix.cols() - Index(columns.size()));
    Index to = 0;
    for (Index from = 0; from < matrix.cols(); ++from) {
        if (!std::count(columns.begin(), columns.end(), int(from))) rest.col(to++) = matrix.col(from);
    }
    return rest;
}

Augmented sized(const Augmented &system) {
    Augmented result = system;
    result.a = system.scale.cwiseInverse().asDiagonal() * system.a * system.scale.asDiagonal();
    result.c = system.c * system.scale.asDiagonal();
    for (auto row : result.c.rowwise()) row /= row.cwiseAbs().maxCoeff() > 0 ? row.cwiseAbs().maxCoeff() : 1;
    return result;
}

} // namespace

std::vector<int> numeric_index(const Augmented &raw, const std::vector<int> &targets, Scaling scaling,
                               const std::vector<double> &tolerances) {
    const Augmented system = scaling == Scaling::si ? raw : sized(raw);
    const Index n = system.a.rows(), m = system.c.rows();
    std::vector<int> found(tolerances.size(), 0);
    MatrixXd observability(0, n), block = system.c;
    for (Index derivatives = 1; derivatives <= n; ++derivatives) {
        observability.conservativeResize(derivatives * m, n);
        if (scaling == Scaling::rows) block.rowwise().normalize();
        observability.bottomRows(m) = block;
        block = block * system.a;
        if (derivatives * m < Index(targets.size())) continue;
        const VectorXd all = linalg::singular_values(observability);
        const VectorXd rest = linalg::singular_values(without_columns(observability, targets));
        for (std::size_t i = 0; i < tolerances.size(); ++i) {
            const bool full = rank(all, tolerances[i]) == Index(targets.size()) + rank(rest, tolerances[i]);
            if (found[i] == 0 && full) found[i] = int(derivatives);
        }
        if (std::count(found.begin(), found.end(), 0) == 0) break;
    }
    return found;
}

} // namespace sixdeg
