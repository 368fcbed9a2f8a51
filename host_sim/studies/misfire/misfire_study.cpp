// SPDX-License-Identifier: MIT
#include "studies/misfire/misfire_study.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <map>

#include "common/files.hpp"
#include "common/progress.hpp"
#include "design/calibration.hpp"
#include "studies/misfire/equal_alarms.hpp"
#include "studies/misfire/open_ecus.hpp"
#include "studies/misfire/set_files.hpp"

namespace sixdeg {
namespace {

constexpr std::array<const char *, 6> kMethods{"monitor", "FOLSMO", "FOSMO", "ROO", "speed delta", "running mean"};
constexpr std::size_t kWithLimit = 4; ///< The first so many decide by themselves; the others only give a score.
constexpr std::int64_t kSettleCycles = 20, kOpenCycles = 3; ///< At a run's begin and end, that count for nobody.
constexpr std::array<double, 2> kEqualShares{0.0002, 0.001};
constexpr std::array<double, 10> kCurveShares{1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1};

/// One detector at one condition.
struct Tally {
    AlarmCurve curve;
    AlarmCurve::Found own; ///< By its own limit.
    std::uint64_t judged = 0, valid = 0, valid_alarms = 0; ///< Firings; those whose verdict counts as valid, and false alarms among them.
    Tally &operator+=(const Tally &other) {
        own += other.own;
        judged += other.judged, valid += other.valid, valid_alarms += other.valid_alarms;
        return *this;
    }
};

struct Cell {
    EngineKind kind;
    Physics physics;
    SetPoint point;
    std::array<Tally, kMethods.size()> methods{};
    int stalled = 0;
};

bool counts(const SetFiring &firing, const SetRun &run) {
    return firing.cycle >= kSettleCycles && firing.cycle <= run.firings.back().cycle - kOpenCycles;
}

void tally_verdicts(Tally &tally, const SetRun &run, const std::vector<FiringVerdict> &verdicts, const EngineFile &engine) {
    std::map<std::pair<std::int64_t, int>, const FiringVerdict *> of_firing;
    const std::vector<double> at_deg = said_at_deg(verdicts, run.record);
    for (std::size_t i = 0; i < at_deg.size(); ++i)
        of_firing[{MisfireScore::cycle_of(engine, at_deg[i], verdicts[i].cylinder), verdicts[i].cylinder}] = &verdicts[i];
    for (const SetFiring &firing : run.firings) {
        if (!counts(firing, run)) continue;
        const auto found = of_firing.find({firing.cycle, firing.cylinder});
        const FiringVerdict none{0, firing.cylinder, SD_NOT_JUDGED, 0, 0, SD_INVALID};
        const FiringVerdict &v = found == of_firing.end() ? none : *found->second;
        const bool judged = v.verdict != SD_NOT_JUDGED, alarm = v.verdict == SD_MISFIRE, valid = judged && v.health == SD_VALID;
        tally.curve.add(v.index - v.limit, judged, firing.misfire);
        tally.judged += judged, tally.valid += valid;
        tally.valid_alarms += valid && alarm && !firing.misfire;
        if (firing.misfire) ++tally.own.missed, tally.own.found += alarm;
        else ++tally.own.healthy, tally.own.alarms += alarm;
    }
}

void tally_scores(Tally &tally, const SetRun &run, const std::vector<double> &scores) {
    for (std::size_t i = 0; i < scores.size(); ++i) {
        if (!counts(run.firings[i], run)) continue;
        const bool judged = !std::isnan(scores[i]);
        tally.curve.add(scores[i], judged, run.firings[i].misfire);
        tally.judged += judged;
        ++(run.firings[i].misfire ? tally.own.missed : tally.own.healthy);
    }
}

void take_run(Cell &cell, const SetRun &run, const EngineFile &engine, const sd_calibration_t &page) {
    cell.stalled += run.stalled;
    if (run.firings.empty()) return;
    tally_verdicts(cell.methods[0], run, run.verdicts, engine);
    for (int method = 1; method < int(kWithLimit); ++method)
        tally_verdicts(cell.methods[std::size_t(method)], run, verdicts_on(run.record, with_method(page, method, 0)), engine);
    tally_scores(cell.methods[kWithLimit], run, speed_delta(run, engine));
    tally_scores(cell.methods[kWithLimit + 1], run, running_mean(run, engine));
}

double percent(std::uint64_t hits, std::uint64_t of) { return of ? 100 * double(hits) / double(of) : 0; }

std::string with_bounds(std::uint64_t hits, std::uint64_t of) {
    const RateBounds bounds = rate_bounds(hits, of);
    return fmt::format("{:.3f} [{:.3f}, {:.3f}]", percent(hits, of), 100 * bounds.low, 100 * bounds.high);
}

/// Of all cells together, the limit of each by itself.
AlarmCurve::Found found_in(const std::vector<const Cell *> &cells, std::size_t method, double share) {
    AlarmCurve::Found sum;
    for (const Cell *cell : cells) sum += cell->methods[method].curve.found_at(share);
    return sum;
}

/// The cell in which least is found.
std::pair<const Cell *, double> worst_of(const std::vector<const Cell *> &cells, std::size_t method, double share) {
    std::pair<const Cell *, double> worst{cells.front(), 101};
    for (const Cell *cell : cells) {
        const AlarmCurve::Found at = cell->methods[method].curve.found_at(share);
        if (percent(at.found, at.missed) < worst.second) worst = {cell, percent(at.found, at.missed)};
    }
    return worst;
}

std::string group_name(const Cell &cell) {
    const std::string road = cell.point.road_rms_nm > 0 ? fmt::format("rough road {:g} N m", cell.point.road_rms_nm) : "smooth road";
    return fmt::format("{}, {} physics, {}, jitter {:g} deg", name_of(cell.kind), name_of(cell.physics), road, cell.point.jitter_deg);
}

void print_group(const std::vector<const Cell *> &cells, int engines) {
    fmt::print("\n{}: {} engines, {} points\n", group_name(*cells.front()), engines, cells.size());
    fmt::print("  {:<13}{:>24}{:>27}{:>8}{:>7}{:>27}{:>27}   {}\n", "", "false by own limit, %", "found by own limit, %", "judged", "valid",
               "found at 0.02 % false, %", "found at 0.1 % false, %", "least found at 0.1 %");
    for (std::size_t method = 0; method < kMethods.size(); ++method) {
        Tally sum;
        for (const Cell *cell : cells) sum += cell->methods[method];
        const std::uint64_t firings = sum.own.healthy + sum.own.missed;
        const bool decides = method < kWithLimit;
        const auto at = [&](double share) {
            const AlarmCurve::Found f = found_in(cells, method, share);
            return with_bounds(f.found, f.missed);
        };
        const auto [worst, least] = worst_of(cells, method, kEqualShares[1]);
        fmt::print("  {:<13}{:>24}{:>27}{:>8.2f}{:>7}{:>27}{:>27}   {:.1f} at {} rpm {:g} bar\n", kMethods[method],
                   decides ? with_bounds(sum.own.alarms, sum.own.healthy) : "", decides ? with_bounds(sum.own.found, sum.own.missed) : "",
                   percent(sum.judged, firings), decides ? fmt::format("{:.2f}", percent(sum.valid, firings)) : "", at(kEqualShares[0]),
                   at(kEqualShares[1]), least, worst->point.rpm, worst->point.bmep_bar);
    }
    for (const Cell *cell : cells) {
        if (cell->stalled) fmt::print("  {} rpm {:g} bar: {} runs stalled\n", cell->point.rpm, cell->point.bmep_bar, cell->stalled);
    }
    std::fflush(stdout);
}

std::string cells_csv(const std::vector<Cell> &cells) {
    std::string csv = "kind,physics,road_rms_nm,jitter_deg,rpm,bmep_bar,method,healthy,missed,judged,valid,alarms,valid_alarms,found,"
                      "found_at_0.02,found_at_0.1\n";
    for (const Cell &c : cells) {
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
            const Tally &t = c.methods[m];
            fmt::format_to(std::back_inserter(csv), "{},{},{:g},{:g},{},{:g},{},{},{},{},{},{},{},{},{},{}\n", name_of(c.kind),
                           name_of(c.physics), c.point.road_rms_nm, c.point.jitter_deg, c.point.rpm, c.point.bmep_bar, kMethods[m],
                           t.own.healthy, t.own.missed, t.judged, t.valid, t.own.alarms, t.valid_alarms, t.own.found,
                           t.curve.found_at(kEqualShares[0]).found, t.curve.found_at(kEqualShares[1]).found);
        }
    }
    return csv;
}

using Groups = std::vector<std::vector<const Cell *>>;

/// Those from `first` on that differ by speed and load alone.
Groups groups_of(const std::vector<Cell> &cells, std::size_t first) {
    Groups groups;
    for (std::size_t i = first; i < cells.size(); ++i) {
        const Cell &cell = cells[i];
        if (groups.empty() || group_name(*groups.back().front()) != group_name(cell)) groups.emplace_back();
        groups.back().push_back(&cell);
    }
    return groups;
}

/// What each method finds over the share of false alarms; the monitor's own limit as a row of its own, method "monitor's limit".
std::string curves_csv(const Groups &groups) {
    std::string csv = "kind,physics,road_rms_nm,jitter_deg,method,false_percent,found,missed\n";
    for (const auto &cells : groups) {
        const Cell &c = *cells.front();
        const auto row = [&](const char *method, double false_percent, const AlarmCurve::Found &f) {
            fmt::format_to(std::back_inserter(csv), "{},{},{:g},{:g},{},{:g},{},{}\n", name_of(c.kind), name_of(c.physics),
                           c.point.road_rms_nm, c.point.jitter_deg, method, false_percent, f.found, f.missed);
        };
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
            for (const double share : kCurveShares) row(kMethods[m], 100 * share, found_in(cells, m, share));
        }
        AlarmCurve::Found own;
        for (const Cell *cell : cells) own += cell->methods[0].own;
        row("monitor's limit", percent(own.alarms, own.healthy), own);
    }
    return csv;
}

bool wanted(const MisfireStudy &study, const SetPoint &point) {
    return (study.rpm == 0 || point.rpm == study.rpm) && (study.bar == 0 || point.bmep_bar == study.bar);
}

void run_kind(const MisfireStudy &study, EngineKind kind, Physics physics, SetWriter &writer, std::vector<Cell> &cells,
              Progress &progress) {
    const EngineFile file = nominal_engine(kind);
    TomlFile tune("tune", "");
    for (const std::string &assignment : study.set) tune.set(assignment);
    const sd_calibration_t page = calibrate(file, read_tune(tune), "tune");
    const std::size_t first = cells.size();
    for (const SetPoint &point : set_points(kind, physics)) {
        if (wanted(study, point)) cells.push_back({kind, physics, point});
    }
    for (const SetEngine &engine : draw_engines(kind, physics, study.engines, study.seed)) {
        const sd_kept_t learned = learn_engine(engine, page);
        for (std::size_t i = first; i < cells.size(); ++i) {
            const SetRun run = run_set(engine, cells[i].point, study.cycles, page, learned);
            take_run(cells[i], run, file, page);
            writer.add(engine, cells[i].point, run, file);
        }
        progress.next();
    }
    for (std::size_t i = first; i < cells.size(); ++i) {
        for (Tally &tally : cells[i].methods) tally.curve.sort();
    }
    for (const auto &group : groups_of(cells, first)) print_group(group, study.engines);
}

constexpr EngineKind kKinds[] = {EngineKind::rigid, EngineKind::twisting, EngineKind::dual_mass};

} // namespace

std::vector<std::string> misfire_study_parts() {
    std::vector<std::string> parts;
    for (const EngineKind kind : kKinds) parts.emplace_back(name_of(kind));
    return parts;
}

void print_misfire_study(const MisfireStudy &study) {
    SetWriter writer(study.write);
    std::vector<Cell> cells;
    Progress progress("engine", 2.0 * study.engines * (study.part.empty() ? std::size(kKinds) : 1));
    for (const EngineKind kind : kKinds) {
        if (!study.part.empty() && study.part != name_of(kind)) continue;
        for (const Physics physics : {Physics::own, Physics::other}) run_kind(study, kind, physics, writer, cells, progress);
    }
    writer.commit();
    if (study.out.empty()) return;
    OutputFolder out(study.out);
    out.add("cells.csv", cells_csv(cells));
    out.add("curves.csv", curves_csv(groups_of(cells, 0)));
    out.commit();
}

} // namespace sixdeg
