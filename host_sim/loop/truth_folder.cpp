// SPDX-License-Identifier: MIT
#include "loop/truth_folder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <map>
#include <sstream>

#include "common/error.hpp"
#include "common/files.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

std::vector<std::string> cells(const std::string &line) {
    std::vector<std::string> out(1);
    for (char c : line) {
        if (c == ',') out.emplace_back();
        else out.back() += c;
    }
    return out;
}

/// Rows of a table with a header, cells by the name of their column.
class Table {
  public:
    explicit Table(const std::filesystem::path &path) : path_(path.string()), text_(read_file(path)) {
        std::string header;
        std::getline(text_, header);
        for (const std::string &name : cells(header)) {
            const std::size_t at = columns_.size();
            columns_[name] = at;
        }
    }
    bool next() {
        std::string line;
        if (!std::getline(text_, line)) return false;
        row_ = cells(line);
        ++rows_;
        if (row_.size() != columns_.size()) fail("", fmt::format("has {} cells, the header {}", row_.size(), columns_.size()));
        return true;
    }
    bool empty(const char *column) const { return cell(column).empty(); }
    double number(const char *column) const {
        const std::string &text = cell(column);
        char *end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        if (text.empty() || *end != 0 || !std::isfinite(value)) fail(column, fmt::format("holds \"{}\", a number is needed", text));
        return value;
    }
    std::size_t rows() const { return rows_; }
    const std::string &path() const { return path_; }

  private:
    [[noreturn]] void fail(const std::string &column, const std::string &what) const {
        throw InputError(path_, fmt::format("row {}{}{}", rows_, column.empty() ? "" : ", ", column), what);
    }
    const std::string &cell(const char *column) const {
        const auto at = columns_.find(column);
        if (at == columns_.end()) throw InputError(path_, column, "is missing: not a table of sixdeg run");
        return row_[at->second];
    }
    std::string path_;
    std::istringstream text_;
    std::map<std::string, std::size_t> columns_;
    std::vector<std::string> row_;
    std::size_t rows_ = 0;
};

EncoderEdge edge_of(const Table &row) {
    EncoderEdge edge;
    edge.time_s = row.number("t_s");
    edge.angle_deg = row.number("angle_deg");
    edge.speed_radps = row.number("rpm_true") * kRadpsPerRpm;
    edge.net_torque_nm = row.number("torque_true_nm");
    edge.spurious = row.empty("tooth_true");
    if (!edge.spurious) edge.tooth = int(row.number("tooth_true"));
    return edge;
}

CycleTruth cycle_of(const Table &row) {
    CycleTruth cycle;
    cycle.cycle = std::int64_t(row.number("cycle"));
    cycle.cylinder = int(row.number("cylinder"));
    cycle.combustion_torque_nm = row.number("torque_true_nm");
    cycle.imep_pa = row.number("imep_true_bar") * kPaPerBar;
    cycle.misfire = row.number("misfire_true") != 0;
    if (!row.empty("burned_true")) cycle.exhaust_lambda = row.number("burned_true");
    cycle.tdc_time_s = row.number("t_s");
    return cycle;
}

} // namespace

RunTables beside_truth(const std::filesystem::path &folder, const EngineFile &engine, const LogReplay &replayed) {
    RunTables tables(engine);
    Answers answers;
    answers.add(replayed.said);
    EcuSaid said;
    double crank_deg = 0;
    Table teeth(folder / "teeth.csv");
    while (teeth.next()) {
        if (teeth.rows() > replayed.edge_ticks.size()) break;
        EncoderEdge edge = edge_of(teeth);
        edge.tick = replayed.edge_ticks[teeth.rows() - 1];
        // The angle that never wraps: from edge to edge the crank turns by less than a revolution.
        crank_deg = teeth.rows() == 1 ? edge.angle_deg : crank_deg + std::remainder(edge.angle_deg - crank_deg, 720);
        const bool cycle_ended = answers.take(edge.tick, said);
        tables.edge(edge, crank_deg, said, cycle_ended);
    }
    if (teeth.rows() != replayed.edge_ticks.size())
        throw InputError(teeth.path(), "", fmt::format("is of another run: the log has {} crank edges", replayed.edge_ticks.size()));
    Table cycles(folder / "cycles.csv");
    while (cycles.next()) {
        const CycleTruth truth = cycle_of(cycles);
        if (std::find(engine.firing_order.begin(), engine.firing_order.end(), truth.cylinder) == engine.firing_order.end())
            throw InputError(cycles.path(), fmt::format("row {}, cylinder", cycles.rows()), "is no cylinder of the log's engine");
        tables.true_cycle(truth);
    }
    return tables;
}

} // namespace sixdeg
