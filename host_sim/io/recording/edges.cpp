// SPDX-License-Identifier: MIT
#include "io/recording/edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/error.hpp"

namespace sixdeg {
namespace {

// Of the range: no crank signal that takes five rows from level to level does that.
constexpr double kJump = 0.6;
// Half the dead band, of the swing: wide enough for noise, narrow enough for the small swing of a variable-reluctance sensor at
// cranking speed in a recording that ends at idle.
constexpr double kBand = 0.06;
// The same where the threshold is the sensor's rest, and noise alone is to be kept out.
constexpr double kZeroBand = 0.015, kNoiseBand = 6;
// Where the two levels lie within a block: so little of its rows is beyond.
constexpr double kBlockBeyond = 0.04;
constexpr double kBlockBand = 0.12;
constexpr std::size_t kBlocks[] = {512, 4096, 32768};

/// The range of a recorder that lets a voltage above it come out at its bottom; 0 where this one does not. In a slow voltage that
/// shows as a jump down between two rows and a jump back up soon after.
double folded_range(const std::vector<double> &value) {
    const auto [low, high] = std::minmax_element(value.begin(), value.end());
    const double range = *high - *low, jump = kJump * range, middle = *low + range / 2;
    long down = 0, up = 0, crossings = 0;
    for (std::size_t i = 1; i < value.size(); ++i) {
        down += value[i] - value[i - 1] < -jump;
        up += value[i] - value[i - 1] > jump;
        crossings += (value[i] < middle) != (value[i - 1] < middle);
    }
    // A logic signal sampled as a voltage jumps at nearly every crossing, and that is no overflow.
    if (down == 0 || up == 0 || std::abs(down - up) > 1 || down + up > crossings / 2) return 0;
    return range;
}

double quantile(std::vector<double> &values, double share) {
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

} // namespace

std::string to_string(Edge edge) { return edge == Edge::falling ? "falling" : "rising"; }

Edge parse_edge(const std::string &text, const std::string &from) {
    if (text == "falling") return Edge::falling;
    if (text == "rising") return Edge::rising;
    throw InputError(from, "", "'" + text + "' is not an edge: falling or rising");
}

Levels levels(const Recording &recording, int column) {
    column_kind(recording, column);
    const std::vector<double> &value = recording.columns[std::size_t(column)];
    std::vector<double> sorted = value;
    Levels found{quantile(sorted, 0.001), quantile(sorted, 0.999), 0};
    sorted.clear();
    for (std::size_t i = 1; i + 1 < value.size() && sorted.size() < 200000; ++i)
        sorted.push_back(std::abs(value[i] - (value[i - 1] + value[i + 1]) / 2));
    if (!sorted.empty()) found.noise = quantile(sorted, 0.5);
    return found;
}

std::vector<Slicing> slicings(const Recording &recording, int column, std::optional<double> threshold) {
    const ColumnKind kind = column_kind(recording, column);
    if (kind != ColumnKind::level && kind != ColumnKind::sampled) return {};
    const std::vector<double> &value = recording.columns[std::size_t(column)];
    const Levels swing = levels(recording, column);
    const double span = swing.high - swing.low;
    Slicing usual{kind == ColumnKind::level, (swing.low + swing.high) / 2, kBand * span, 0, 0, 0, "half-way"};
    if (usual.is_level) {
        const auto [low, high] = std::minmax_element(value.begin(), value.end());
        usual.threshold = (*low + *high) / 2, usual.band = 0;
        if (!threshold) return {usual};
    }
    usual.folded_range = usual.is_level ? 0 : folded_range(value);
    usual.folded_from = usual.folded_range > 0 ? *std::min_element(value.begin(), value.end()) : 0;
    const auto fixed = [&](double at, double band, const char *name) {
        Slicing other = usual;
        other.threshold = at, other.band = band, other.name = name;
        return other;
    };
    const double least = std::max(kNoiseBand * swing.noise, kZeroBand * span);
    if (threshold) return {fixed(*threshold, usual.is_level ? 0 : std::min(least, usual.band), "given")};
    std::vector<Slicing> ways{usual};
    if (swing.low < 0 && swing.high > 0) ways.push_back(fixed(0, std::min(least, usual.band), "zero crossing"));
    ways.push_back(fixed(swing.low + 0.3 * span, usual.band, "low"));
    ways.push_back(fixed(swing.low + 0.7 * span, usual.band, "high"));
    for (std::size_t rows : kBlocks) {
        if (rows * 3 > value.size()) break;
        ways.push_back(fixed(usual.threshold, least, "following"));
        ways.back().follow = rows;
    }
    return ways;
}

/// What lies between a jump down and the jump back up belongs above the range.
double EdgeFinder::unfolded(double value) {
    if (slicing_.folded_range <= 0) return value;
    if (has_before_) {
        const double step = value - raw_.value, jump = kJump * slicing_.folded_range;
        if (step < -jump) folded_ = true;
        if (step > jump) folded_ = false;
    }
    raw_.value = value;
    return folded_ ? value + slicing_.folded_range : value;
}

void EdgeFinder::row(double time, double value) {
    if (std::isnan(value)) value = has_before_ || !block_.empty() ? raw_.value : 0;
    if (slicing_.folded_range <= 0) raw_.value = value;
    const Row row{time, unfolded(value)};
    if (slicing_.follow == 0) return compare(row, slicing_.threshold, slicing_.band);
    block_.push_back(row);
    if (block_.size() == slicing_.follow) block_is_full();
}

void EdgeFinder::compare(const Row &row, double threshold, double band) {
    const double now = row.value - threshold, before = before_.value - before_threshold_;
    if (!has_before_) {
        side_ = now > band ? above : now < -band ? below : unknown;
    } else if (slicing_.is_level) {
        if (before <= 0 && now > 0) rising.push_back(row.time);
        if (before > 0 && now <= 0) falling.push_back(row.time);
    } else {
        const auto crossing = [&] { return before_.time + (row.time - before_.time) * (before / (before - now)); };
        if (before < 0 && now >= 0) up_time_ = crossing();
        if (before > 0 && now <= 0) down_time_ = crossing();
        if (now > band) {
            if (side_ == below) rising.push_back(up_time_);
            side_ = above;
        } else if (now < -band) {
            if (side_ == above) falling.push_back(down_time_);
            side_ = below;
        }
    }
    before_ = row, before_threshold_ = threshold, has_before_ = true;
}

/// The threshold goes in a straight line from the middle of one block to that of the next, so a block waits for the one behind it.
void EdgeFinder::block_is_full() {
    std::vector<double> values;
    for (const Row &row : block_) values.push_back(row.value);
    const double low = quantile(values, kBlockBeyond), high = quantile(values, 1 - kBlockBeyond), middle = (low + high) / 2;
    const double own_band = std::max(slicing_.band, kBlockBand * (high - low));
    if (has_waiting_) run_block(waiting_, (waiting_from_ + waiting_middle_) / 2, (waiting_middle_ + middle) / 2);
    waiting_from_ = has_waiting_ ? waiting_middle_ : middle;
    waiting_middle_ = middle;
    band_ = own_band;
    waiting_.swap(block_);
    block_.clear();
    has_waiting_ = true;
}

/// From the threshold at its first row over its middle to that at its last.
void EdgeFinder::run_block(const std::vector<Row> &rows, double from, double to) {
    const double half = double(rows.size()) / 2;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double at = double(i) / half;
        const double threshold = at < 1 ? from + (waiting_middle_ - from) * at : waiting_middle_ + (to - waiting_middle_) * (at - 1);
        compare(rows[i], threshold, band_);
    }
}

void EdgeFinder::finish() {
    if (slicing_.follow == 0) return;
    if (has_waiting_) run_block(waiting_, (waiting_from_ + waiting_middle_) / 2, waiting_middle_);
    for (const Row &row : block_) compare(row, has_waiting_ ? waiting_middle_ : slicing_.threshold, has_waiting_ ? band_ : slicing_.band);
    waiting_.clear(), block_.clear();
}

std::vector<double> edges(const Recording &recording, int column, Edge edge) {
    if (column_kind(recording, column) == ColumnKind::edge_times) return recording.time;
    const auto ways = slicings(recording, column);
    if (ways.empty()) return {};
    EdgeFinder finder(ways.front());
    for (std::size_t i = 0; i < recording.rows(); ++i) finder.row(recording.time[i], recording.columns[std::size_t(column)][i]);
    finder.finish();
    return edge == Edge::rising ? std::move(finder.rising) : std::move(finder.falling);
}

} // namespace sixdeg
