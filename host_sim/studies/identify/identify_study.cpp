// SPDX-License-Identifier: MIT
#include "studies/identify/identify_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <map>
#include <vector>

#include "identify/identify.hpp"
#include "studies/identify/drawn_engine.hpp"

namespace sixdeg {
namespace {

/// One number over all engines.
class Row {
  public:
    void take(const Found &found, double truth, double scale) {
        ++asked_;
        if (!found.told()) return;
        half_.push_back(found.half_width * scale);
        error_.push_back((found.value - truth) * scale);
        held_ += std::abs(found.value - truth) <= found.half_width;
    }
    std::size_t told() const { return half_.size(); }
    std::size_t asked() const { return asked_; }
    double held_percent() const { return told() ? 100.0 * double(held_) / double(told()) : 0; }
    double half() const { return quantile(half_, 0.5); }
    double largest_half() const { return quantile(half_, 0.95); }
    double rms() const {
        double sum = 0;
        for (double e : error_) sum += e * e;
        return std::sqrt(sum / double(std::max<std::size_t>(error_.size(), 1)));
    }

  private:
    static double quantile(std::vector<double> values, double share) {
        if (values.empty()) return std::nan("");
        std::sort(values.begin(), values.end());
        return values[std::size_t(share * double(values.size() - 1))];
    }
    std::size_t asked_ = 0, held_ = 0;
    std::vector<double> half_, error_;
};

struct Table {
    std::map<std::string, Row> rows;
};

/// Mean of load and friction in the cycles that an answer is of.
double mean_load(const EngineTruth &truth, const std::vector<TimeWindow> &cycles) {
    const auto earlier = [](const std::pair<double, double> &point, double t) { return point.first < t; };
    double sum = 0;
    for (const TimeWindow &cycle : cycles) {
        auto at = std::lower_bound(truth.load_nm.begin(), truth.load_nm.end(), cycle.from_s, earlier);
        double own = 0, count = 0;
        for (; at != truth.load_nm.end() && at->first < cycle.to_s; ++at) own += at->second, count += 1;
        sum += own / count;
    }
    return sum / double(cycles.size());
}

void score_drag(const std::string &mode, const Identified &found, const EngineTruth &truth, Table &table) {
    double low = 1e9, high = 0;
    for (const DragAt &d : found.drag) {
        if (!d.motored) continue;
        low = std::min(low, d.rpm), high = std::max(high, d.rpm);
    }
    for (const DragAt &d : found.drag) {
        if (!d.motored || d.cycles.size() < 10 || (d.rpm > 1.1 * low && d.rpm < high / 1.1)) continue;
        const double nm = mean_load(truth, d.cycles);
        if (d.nm.told()) table.rows[mode + "load and friction, N m"].take(d.nm, nm, 1);
        else table.rows[mode + "load and friction over J0, rad/s2"].take(d.over_inertia, nm / truth.inertia_kgm2, 1);
    }
}

void score(const std::string &mode, const Identified &found, const EngineTruth &truth, Table &table) {
    table.rows[mode + "J0, %"].take(found.inertia_kgm2, truth.inertia_kgm2, 100 / truth.inertia_kgm2);
    Found offset = found.position_0_deg;
    offset.value = std::remainder(offset.value - truth.position_0_deg, 360);
    table.rows[mode + "mark to TDC, deg"].take(offset, 0, 1);
    Found pressure = found.compression_0_deg;
    pressure.value = std::remainder(pressure.value - truth.position_0_deg, 360);
    table.rows[mode + "mark to TDC by compression, deg"].take(pressure, 0, 1);
    score_drag(mode, found, truth, table);
    table.rows[mode + "exponent"].take(found.exponent, truth.exponent, 1);
    for (std::size_t p = 0; p < found.pattern_deg.size(); ++p)
        if (found.pattern_deg[p].refused != "no tooth") table.rows[mode + "tooth, deg"].take(found.pattern_deg[p], truth.pattern_deg[p], 1);
}

void print_each(const char *mode, const Identified &f, const EngineTruth &truth) {
    double rms = 0, half = 0, n = 0;
    for (std::size_t p = 0; p < f.pattern_deg.size(); ++p)
        if (f.pattern_deg[p].told()) rms += std::pow(f.pattern_deg[p].value - truth.pattern_deg[p], 2),
            half += f.pattern_deg[p].half_width, n += 1;
    fmt::print("  {:9} {} of {} cycles; J {:+.2f} +-{:.2f} %; TDC {:+.3f} +-{:.3f} deg; n {:+.4f} +-{:.4f}; "
               "tooth {:.4f} +-{:.4f} deg ({:.0f}); "
               "scatter {:.4f}, unexplained {:.4f} deg {:.2f} %; share {:.3f} +-{:.3f}\n",
               mode, f.used, f.cycles, 100 * (f.inertia_kgm2.value / truth.inertia_kgm2 - 1),
                   100 * f.inertia_kgm2.half_width / truth.inertia_kgm2,
               std::remainder(f.position_0_deg.value - truth.position_0_deg, 360), f.position_0_deg.half_width,
                   f.exponent.value - truth.exponent,
               f.exponent.half_width, std::sqrt(rms / n), half / n, n, f.scatter_deg, f.unexplained_deg, f.unexplained_percent,
                   f.compression_share.value,
               f.compression_share.half_width);
}

} // namespace

void print_identify_study(const IdentifyStudy &study) {
    Table table;
    for (int i = 0; i < study.engines; ++i) {
        const DrawnEngine engine = draw_engine(study.seed + std::uint64_t(i));
        const DrawnRun run = run_engine(engine);
        const Identified with = identify(engine.first, run.record, {}, "drawn");
        CrankRecord bare = run.record;
        bare.pressure.clear();
        const Identified without = identify(engine.first, bare, {}, "drawn");
        score("pressure: ", with, run.truth, table);
        score("teeth: ", without, run.truth, table);
        if (!study.each) continue;
        fmt::print("{}: {}\n", study.seed + std::uint64_t(i), engine.what);
        print_each("pressure", with, run.truth);
        print_each("teeth", without, run.truth);
        std::fflush(stdout);
    }
    fmt::print("{:30} {:>12} {:>9} {:>12} {:>12} {:>12}\n", "", "told", "held, %", "half-width", "of 95 %", "rms error");
    for (const auto &[name, row] : table.rows)
        fmt::print("{:30} {:>5} of {:>5} {:>8.1f} {:>12.4f} {:>12.4f} {:>12.4f}\n", name, row.told(), row.asked(), row.held_percent(),
            row.half(),
                   row.largest_half(), row.rms());
}

} // namespace sixdeg
