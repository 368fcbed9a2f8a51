// SPDX-License-Identifier: MIT
#include "studies/engines/engine_figures.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/random.hpp"

namespace sixdeg {
namespace {

constexpr int kDraws = 4000;
constexpr std::uint32_t kDrawnAgainStream = 303; ///< Of random numbers; beside those of common/streams.hpp.

bool meets(const FigureGoal &goal, double value) { return std::abs(value) >= goal.low && std::abs(value) <= goal.high; }

double rms(const std::vector<double> &squares) {
    double sum = 0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum / double(squares.size()));
}

bool has_goal(const FigureGoal &goal) { return goal.low > 0 || std::isfinite(goal.high); }

std::string goal_text(const FigureRow &row) {
    const FigureGoal &g = row.goal;
    if (!has_goal(g)) return "-";
    if (g.low <= 0) return fmt::format("<= {:g}{}", g.high, row.unit);
    return std::isinf(g.high) ? fmt::format(">= {:g}{}", g.low, row.unit) : fmt::format("{:g} to {:g}{}", g.low, g.high, row.unit);
}

std::string rms_text(const FigureRow &row, Physics physics) {
    const FigureRms r = rms_of(row, physics);
    if (r.engines == 0) return "-";
    const std::string text = fmt::format("{:.2f} [{:.2f}, {:.2f}]", r.rms, r.low, r.high);
    if (!has_goal(row.goal)) return fmt::format("{}; {:+.2f}", text, r.largest);
    return fmt::format("{}; {:+.2f}; {} of {}", meets(row.goal, r.rms) ? text : "**" + text + "**", r.largest, r.met, r.engines);
}

} // namespace

FigureRms rms_of(const FigureRow &row, Physics physics) {
    FigureRms result;
    std::vector<double> squares;
    for (const FigureRow::Value &v : row.values) {
        if (v.engine.physics != physics) continue;
        squares.push_back(v.value * v.value);
        result.met += meets(row.goal, v.value);
        if (std::abs(v.value) > std::abs(result.largest)) result.largest = v.value;
    }
    result.engines = int(squares.size());
    if (squares.empty()) return result;
    result.rms = rms(squares);
    RandomStream random(1, kDrawnAgainStream);
    std::vector<double> drawn, again(squares.size());
    for (int i = 0; i < kDraws; ++i) {
        for (double &square : again) square = squares[std::size_t(random.uniform() * double(squares.size()))];
        drawn.push_back(rms(again));
    }
    std::sort(drawn.begin(), drawn.end());
    result.low = drawn[std::size_t(0.025 * kDraws)], result.high = drawn[std::size_t(0.975 * kDraws)];
    return result;
}

void EngineFigures::add(const SetEngine &engine, const std::string &what, const std::string &at, const std::string &unit, FigureGoal goal,
                        double value) {
    const auto same = [&](const FigureRow &row) { return row.what == what && row.at == at; };
    auto row = std::find_if(rows_.begin(), rows_.end(), same);
    if (row == rows_.end()) row = rows_.insert(rows_.end(), {what, at, unit, goal, {}});
    row->values.push_back({engine, value});
}

std::string EngineFigures::table() const {
    std::string text = "| figure | at | goal | own physics: rms [95 %]; largest; met by | other physics |\n|---|---|---|---|---|\n";
    for (const FigureRow &row : rows_) {
        text += fmt::format("| {} | {} | {} | {} | {} |\n", row.what, row.at, goal_text(row), rms_text(row, Physics::own),
                            rms_text(row, Physics::other));
    }
    return text;
}

std::string EngineFigures::csv() const {
    std::string text = "figure,at,unit,goal_low,goal_high,physics,seed,gamma,wall_factor,pattern_rms_deg,value\n";
    for (const FigureRow &row : rows_) {
        for (const FigureRow::Value &v : row.values) {
            const SetEngine &e = v.engine;
            text += fmt::format("\"{}\",{},{},{:g},{:g},{},{},{:g},{:g},{:g},{:g}\n", row.what, row.at, row.unit, row.goal.low,
                                row.goal.high, name_of(e.physics), e.seed, e.gamma, e.wall_factor, e.pattern_rms_deg, v.value);
        }
    }
    return text;
}

} // namespace sixdeg
