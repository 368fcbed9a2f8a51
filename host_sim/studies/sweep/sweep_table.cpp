// SPDX-License-Identifier: MIT
#include "studies/sweep/sweep_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "common/nearest.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;
using Figures = std::vector<std::pair<std::string, double>>;

// What went in is no figure.
constexpr const char *kInputs[] = {"parameters", "thresholds", "seed", "engine", "versions", "files", "calibration", "set"};

void collect(const Json &json, const std::string &prefix, Figures &figures) {
    for (const auto &[name, value] : json.items()) {
        if (std::find(std::begin(kInputs), std::end(kInputs), name) != std::end(kInputs)) continue;
        if (value.is_object()) collect(value, prefix + name + ".", figures);
        if (value.is_number()) figures.emplace_back(prefix + name, value.get<double>());
        if (value.is_boolean()) figures.emplace_back(prefix + name, value.get<bool>() ? 1 : 0);
    }
}

Figures figures_of(const SweepCell &cell) {
    Figures figures;
    if (!cell.summary.empty()) collect(Json::parse(cell.summary), "", figures);
    return figures;
}

std::optional<double> find(const Figures &figures, const std::string &name) {
    for (const auto &[key, value] : figures) {
        if (key == name) return value;
    }
    return std::nullopt;
}

std::string quoted(const std::string &text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string result = "\"";
    for (char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
    return result + "\"";
}

std::string value_of(const std::string &setting) { return setting.substr(setting.find('=') + 1); }

/// Black on light, white on dark.
std::string box(double x, double y, double width, double height, double share, const std::string &text) {
    const auto mix = [share](int light, int dark) { return int(std::lround(light + share * (dark - light))); };
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"rgb({},{},{})\"/>"
                       "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\">{}</text>\n",
                       x, y, width - 2, height - 2, mix(244, 23), mix(247, 78), mix(250, 124), x + width / 2 - 1,
                       y + height / 2 + 4, share > 0.55 ? "#fff" : "#222", text);
}

} // namespace

std::string sweep_csv(const std::vector<Axis> &axes, const std::vector<SweepCell> &cells) {
    std::vector<std::string> names;
    std::vector<Figures> figures;
    for (const SweepCell &cell : cells) {
        figures.push_back(figures_of(cell));
        for (const auto &[name, value] : figures.back()) {
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        }
    }
    std::string text;
    for (const Axis &axis : axes) text += quoted(axis.field) + ",";
    for (const std::string &name : names) text += name + ",";
    text += "error\n";
    for (std::size_t i = 0; i < cells.size(); ++i) {
        for (const std::string &setting : cells[i].settings) text += quoted(value_of(setting)) + ",";
        for (const std::string &name : names) {
            if (const auto value = find(figures[i], name)) fmt::format_to(std::back_inserter(text), "{:.9g}", *value);
            text += ",";
        }
        text += quoted(cells[i].error) + "\n";
    }
    return text;
}

std::string figure_fault(const std::vector<SweepCell> &cells, const std::string &figure) {
    std::vector<std::string> names;
    for (const SweepCell &cell : cells) {
        for (const auto &[name, value] : figures_of(cell)) {
            if (name == figure) return "";
            names.push_back(name);
        }
    }
    const std::string hint = nearest_hint(figure, names);
    return hint.empty() ? "" : "is no figure of a summary" + hint;
}

std::optional<std::string> sweep_picture(const std::vector<Axis> &axes, const std::vector<SweepCell> &cells,
                                         const std::string &figure) {
    const auto axis = [&](const char *field) {
        return std::find_if(axes.begin(), axes.end(), [&](const Axis &a) { return a.field == field; }) - axes.begin();
    };
    const auto speed = std::size_t(axis("speed.rpm")), load = std::size_t(axis("load.bmep_bar"));
    if (speed == axes.size() || load == axes.size()) return std::nullopt;
    std::map<std::pair<std::string, std::string>, double> values; // speed, load
    double largest = 0;
    for (const SweepCell &cell : cells) {
        bool first = true; // of every axis that is not drawn
        for (std::size_t a = 0; a < axes.size(); ++a)
            first &= a == speed || a == load || value_of(cell.settings[a]) == axes[a].values.front();
        const auto value = find(figures_of(cell), figure);
        if (!first || !value) continue;
        values[{value_of(cell.settings[speed]), value_of(cell.settings[load])}] = *value;
        largest = std::max(largest, std::abs(*value));
    }
    if (values.empty()) return std::nullopt;
    constexpr double kLeft = 70, kTop = 50, kWidth = 74, kHeight = 40;
    const auto &speeds = axes[speed].values, &loads = axes[load].values;
    const double width = kLeft + kWidth * double(speeds.size()) + 20, height = kTop + kHeight * double(loads.size()) + 60;
    std::string svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 "
                                  "{0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"13\" text-anchor=\"middle\" "
                                  "fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
                                  "<text x=\"{2:.0f}\" y=\"24\" text-anchor=\"start\" font-size=\"15\">{3}</text>\n",
                                  width, height, kLeft, figure);
    for (std::size_t row = 0; row < loads.size(); ++row) {
        const std::string &bmep = loads[loads.size() - 1 - row]; // high load on top
        const double y = kTop + kHeight * double(row);
        svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"end\">{}</text>\n", kLeft - 8, y + kHeight / 2 + 4, bmep);
        for (std::size_t column = 0; column < speeds.size(); ++column) {
            const auto value = values.find({speeds[column], bmep});
            const bool there = value != values.end();
            svg += box(kLeft + kWidth * double(column), y, kWidth, kHeight,
                       there && largest > 0 ? std::abs(value->second) / largest : 0,
                       there ? fmt::format("{:.3g}", value->second) : "-");
        }
    }
    const double bottom = kTop + kHeight * double(loads.size());
    for (std::size_t column = 0; column < speeds.size(); ++column)
        svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n", kLeft + kWidth * (double(column) + 0.5), bottom + 18,
                           speeds[column]);
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">speed, rpm</text>\n<text transform=\"translate(18 {:.0f}) rotate(-90)\">load, "
                       "bar bmep</text>\n</svg>\n", kLeft + kWidth * double(speeds.size()) / 2, bottom + 42, (kTop + bottom) / 2);
    return svg;
}

} // namespace sixdeg
