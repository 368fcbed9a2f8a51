// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

namespace sixdeg {
namespace {

using nlohmann::ordered_json;

std::string index_text(int index) { return index ? std::to_string(index) : "-"; }

std::string index_list(const std::vector<int> &index) {
    std::string text;
    for (const int value : index) text += fmt::format("{:>4}", index_text(value));
    return text;
}

std::string histogram_text(const std::map<int, int> &histogram) {
    std::string text;
    for (const auto &[index, count] : histogram)
        text += fmt::format("{}{}:{}", text.empty() ? "" : " ", index_text(index), count);
    return text;
}

std::string set_name(const Findings &findings, SensorSet set) {
    return fmt::format("{}", fmt::join(findings.model.sensor_names(set), " "));
}

std::vector<std::string> target_names(const Findings &findings) {
    std::vector<std::string> names;
    for (const int state : findings.query.targets) names.push_back(findings.model.states[std::size_t(state)]);
    return names;
}

std::string regime_heads(const SensorModel &model) {
    std::string text;
    for (std::size_t i = 0; i < model.regimes.size(); ++i)
        text += fmt::format("{:>4}", fmt::format("#{}", i + 1));
    return text;
}

void head(const Findings &f, std::string &page) {
    page += fmt::format("model    {}\n         {} states, {} sensors\n", f.model.name, f.model.states.size(),
                        f.model.sensors.size());
    for (std::size_t i = 0; i < f.model.regimes.size(); ++i)
        page += fmt::format("regime   #{} {}\n", i + 1, f.model.regimes[i].name);
    page += fmt::format("targets  {}\n", fmt::join(target_names(f), " "));
}

void alone_table(const Findings &f, std::string &page) {
    page += "\nEvery sensor alone, whole state (structure: Lin / Shields-Pearson; exact index)\n";
    for (std::size_t r = 0; r < f.model.regimes.size(); ++r) {
        const auto count = [&](auto &&holds) {
            return std::count_if(f.alone.begin(), f.alone.end(),
                                 [&](const auto &by_regime) { return holds(by_regime[r]); });
        };
        const auto agree =
            count([](const Alone &a) { return a.lin == a.shields_pearson && a.lin == (a.index > 0); });
        page += fmt::format("  #{}  observable {} / {} of {}; the three answers agree on {}\n", r + 1,
                            count([](const Alone &a) { return a.lin; }),
                            count([](const Alone &a) { return a.shields_pearson; }), f.alone.size(), agree);
    }
    for (std::size_t i = 0; i < f.alone.size(); ++i) {
        std::vector<int> index;
        for (const auto &alone : f.alone[i]) index.push_back(alone.index);
        page += fmt::format("  {:<12}{}\n", f.model.sensors[i].name, index_list(index));
    }
}

void histogram_table(const Findings &f, std::string &page) {
    page +=
        fmt::format("\nIndex of the targets, {} sets of {} to {} sensors (index:sets; - = not observable)\n",
                    f.ranking.sets.size(), f.query.least, f.query.most);
    for (std::size_t r = 0; r < f.model.regimes.size(); ++r) {
        page += fmt::format("  #{}  {}\n", r + 1, histogram_text(f.ranking.histograms[r]));
    }
    page += fmt::format("  sets on which the draws differ: {}\n", f.ranking.disagreements);
}

std::string set_line(const Findings &f, const RankedSet &entry) {
    return fmt::format("  {}{:>9.4g}{:>4}  {}\n", index_list(entry.index), entry.cost, entry.size,
                       set_name(f, entry.set));
}

void set_tables(const Findings &f, std::size_t top, std::string &page) {
    const std::string heads = fmt::format("  {}     cost num  sensors\n", regime_heads(f.model));
    top = std::min(top, f.ranking.sets.size());
    page += fmt::format("\nBest {} sets by worst index, then cost\n{}", top, heads);
    for (std::size_t i = 0; i < top; ++i) page += set_line(f, f.ranking.sets[i]);
    page += fmt::format("\nPareto front of index, cost and number: {} sets\n{}", f.front.size(), heads);
    for (const auto &entry : f.front) page += set_line(f, entry);
    if (f.published.empty()) return;
    page += fmt::format("\nPublished index beside ours\n  pub{}  sensors\n", regime_heads(f.model));
    for (std::size_t i = 0; i < f.published.size(); ++i) {
        page += fmt::format("  {:>3}{}  {}\n", index_text(f.model.published[i].index),
                            index_list(f.published[i]), set_name(f, f.model.published[i].set));
    }
}

// "3" or "3..5" over the points of one regime; "-" for points where the targets are lost.
std::string range_text(const std::vector<int> &index) {
    const auto [low, high] = std::minmax_element(index.begin(), index.end());
    return *low == *high ? index_text(*low) : index_text(*low) + ".." + index_text(*high);
}

std::string studied_line(const Findings &f, std::size_t at) {
    const StudiedSet &studied = f.study.sets[at];
    std::string line =
        fmt::format("  {}{:>7} ", index_list(f.ranking.sets[at].index), range_text(studied.index));
    for (const double sigma : studied.sigma) line += fmt::format("{:>10.4g}", sigma);
    return line + fmt::format("{:>10.3g}  {}\n", studied.relative_sigma, set_name(f, f.ranking.sets[at].set));
}

// How a published index comes and goes with the tolerance.
void published_table(const Findings &f, std::string &page) {
    if (f.published.empty()) return;
    for (std::size_t turn = 0; turn < f.study.published.size(); ++turn) {
        // The tables of `sensitivity` stand in the same order, one regime after the other.
        const std::size_t row = turn * f.study.sensitivity.size() / f.study.published.size();
        page +=
            fmt::format("\nPublished sets by tolerance, scaling {}, {}\n  pub", name_of(reference_scaling),
                        f.numeric->points[f.study.sensitivity[row].point].name);
        for (const double tolerance : f.study.tolerances) page += fmt::format("{:>7g}", tolerance);
        page += "  sensors\n";
        for (std::size_t i = 0; i < f.model.published.size(); ++i) {
            page += fmt::format("  {:>3}", index_text(f.model.published[i].index));
            for (const int index : f.study.published[turn][i])
                page += fmt::format("{:>7}", index_text(index));
            page += "  " + set_name(f, f.model.published[i].set) + "\n";
        }
    }
}

void numeric_tables(const Findings &f, std::size_t top, std::string &page) {
    page += fmt::format(
        "\nNumeric index at {} points (scaling {}, tolerance {:g} of the greatest singular value)\n",
        f.study.points.size(), name_of(reference_scaling), reference_tolerance);
    for (const auto &row : f.study.points) {
        const auto &point = f.numeric->points[row.point];
        page += fmt::format("  {:<24}{:<10} as generic {:>5} of {}  {}\n", point.name, point.regime,
                            row.agree, f.ranking.sets.size(), histogram_text(row.histogram));
    }
    page += "\nSensitivity of the numeric index (first point of each regime)\n";
    for (const auto &row : f.study.sensitivity) {
        page += fmt::format("  {:<24}{:<6} {:>6g} as generic {:>5}  {}\n", f.numeric->points[row.point].name,
                            name_of(row.scaling), row.tolerance, row.agree, histogram_text(row.histogram));
    }
    published_table(f, page);
    std::string heads = fmt::format("  {} numeric ", regime_heads(f.model));
    for (const auto &name : target_names(f)) heads += fmt::format("{:>10}", name);
    heads += "  relative  sensors\n";
    top = std::min(top, f.study.sets.size());
    page += fmt::format(
        "\nGeneric and numeric index, steady Kalman standard deviation (SI, rms over the points)\n{}", heads);
    for (std::size_t i = 0; i < top; ++i) page += studied_line(f, i);
    std::vector<std::size_t> order(f.study.sets.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return f.study.sets[a].relative_sigma < f.study.sets[b].relative_sigma;
    });
    page += fmt::format("\nBest {} sets by that standard deviation\n{}", top, heads);
    for (std::size_t i = 0; i < top; ++i) page += studied_line(f, order[i]);
}

ordered_json histogram_json(const std::map<int, int> &histogram) {
    ordered_json object = ordered_json::object();
    for (const auto &[index, count] : histogram) object[std::to_string(index)] = count;
    return object;
}

ordered_json set_json(const Findings &f, const RankedSet &entry) {
    return {{"sensors", f.model.sensor_names(entry.set)},
            {"index", entry.index},
            {"worst", entry.worst},
            {"cost", entry.cost}};
}

ordered_json comparison_json(const Findings &f, const Comparison &row) {
    const auto &point = f.numeric->points[row.point];
    return {{"point", point.name},
            {"regime", point.regime},
            {"scaling", name_of(row.scaling)},
            {"tolerance", row.tolerance},
            {"as_generic", row.agree},
            {"histogram", histogram_json(row.histogram)}};
}

ordered_json alone_json(const Findings &f, std::size_t sensor) {
    ordered_json entry{{"sensor", f.model.sensors[sensor].name}};
    for (const auto &alone : f.alone[sensor]) {
        entry["lin"].push_back(alone.lin);
        entry["shields_pearson"].push_back(alone.shields_pearson);
        entry["index"].push_back(alone.index);
    }
    return entry;
}

} // namespace

std::string text(const Findings &findings, std::size_t top) {
    std::string page;
    head(findings, page);
    alone_table(findings, page);
    histogram_table(findings, page);
    set_tables(findings, top, page);
    if (findings.numeric) numeric_tables(findings, top, page);
    return page;
}

ordered_json json(const Findings &f) {
    ordered_json all{{"model", f.model.name}, {"targets", target_names(f)}};
    for (std::size_t r = 0; r < f.model.regimes.size(); ++r) {
        all["regimes"].push_back(
            {{"name", f.model.regimes[r].name}, {"histogram", histogram_json(f.ranking.histograms[r])}});
    }
    for (std::size_t i = 0; i < f.alone.size(); ++i) all["alone"].push_back(alone_json(f, i));
    all["draws_differ"] = f.ranking.disagreements;
    all["sets"] = ordered_json::array();
    for (std::size_t i = 0; i < f.ranking.sets.size(); ++i) {
        auto entry = set_json(f, f.ranking.sets[i]);
        if (f.numeric) {
            entry["numeric_index"] = f.study.sets[i].index;
            entry["sigma"] = f.study.sets[i].sigma;
            entry["relative_sigma"] = f.study.sets[i].relative_sigma;
        }
        all["sets"].push_back(std::move(entry));
    }
    all["pareto"] = ordered_json::array();
    for (const auto &entry : f.front) all["pareto"].push_back(set_json(f, entry));
    all["published"] = ordered_json::array();
    for (std::size_t i = 0; i < f.published.size(); ++i) {
        all["published"].push_back({{"sensors", f.model.sensor_names(f.model.published[i].set)},
                                    {"published", f.model.published[i].index},
                                    {"index", f.published[i]}});
    }
    if (!f.numeric) return all;
    for (const auto &row : f.study.points) all["numeric"]["points"].push_back(comparison_json(f, row));
    for (const auto &row : f.study.sensitivity)
        all["numeric"]["sensitivity"].push_back(comparison_json(f, row));
    return all;
}

} // namespace sixdeg
