// SPDX-License-Identifier: MIT
#include "cli/recorded_teeth.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kStoichiometric = 14.6; // of --lambda, which nobody asks for here
constexpr double kStall_s = 0.5;
constexpr std::size_t kLeastTeeth = 120;

/// Teeth between two losses of the angle; `place` counts from the first one's revolution.
struct Stretch {
    std::vector<PlacedTooth> teeth;
    std::optional<int> parity; ///< What to add to the revolutions.
};

class Collector : public ReplaySink {
  public:
    explicit Collector(int positions) : positions_(positions) {}
    void tooth(std::size_t, const ToothRow &row) override {
        if (int(row.signals.crank_edge_class) == SD_EDGE_UNSYNCED) open_ = false;
        if (!is_placed(row.signals)) return;
        const int tooth = int(row.signals.crank_tooth);
        if (tooth >= positions_) return;
        if (!open_) stretches.emplace_back(), turn_ = 0, last_ = -1, open_ = true;
        if (tooth < last_) ++turn_;
        last_ = tooth;
        stretches.back().teeth.push_back({row.t_s, turn_ * positions_ + tooth});
    }
    std::vector<Stretch> stretches;

  private:
    int positions_, last_ = -1;
    long turn_ = 0;
    bool open_ = false;
};

double place_at(const Stretch &stretch, double t_s) {
    const auto &teeth = stretch.teeth;
    const auto after = std::upper_bound(teeth.begin(), teeth.end(), t_s, [](double t, const PlacedTooth &p) { return t < p.t_s; });
    if (after == teeth.begin() || after == teeth.end()) return std::nan("");
    const PlacedTooth &a = *(after - 1), &b = *after;
    return double(a.place) + double(b.place - a.place) * (t_s - a.t_s) / (b.t_s - a.t_s);
}

/// By votes: positive for the revolution that the first tooth was taken for, negative for the other. Nothing where they are divided.
std::optional<int> elected(double votes, double cast) {
    if (cast < 1 || std::abs(votes) < 0.5 * cast) return std::nullopt;
    return votes > 0 ? 0 : 1;
}

std::optional<int> parity_by_cam(const Stretch &stretch, const std::vector<double> &cam_s, const EngineFile &engine) {
    double votes = 0, cast = 0;
    for (double t : cam_s) {
        const double place = place_at(stretch, t), deg = engine.position_0_deg + place * 360 / engine.wheel.positions;
        if (std::isnan(place) || std::abs(std::remainder(deg - engine.cam_edge_deg, 360)) > 60) continue;
        votes += std::abs(std::remainder(deg - engine.cam_edge_deg, 720)) < 180 ? 1 : -1;
        cast += 1;
    }
    return elected(votes, cast);
}

/// The pressure is higher about the firing TDC than a revolution away. A reading holds until the next one.
std::optional<int> parity_by_pressure(const Stretch &stretch, const std::vector<TimedValue> &pressure, const EngineFile &engine) {
    double votes = 0, cast = 0, high[2] = {0, 0}, before = 0;
    std::optional<long> cycle;
    for (const TimedValue &reading : pressure) {
        const double place = place_at(stretch, reading.t_s), deg = engine.position_0_deg + place * 360 / engine.wheel.positions;
        if (std::isnan(place)) continue;
        const long now = long(std::floor((deg + 180) / 720));
        if (now != cycle) {
            if (cycle && high[0] != high[1]) votes += high[0] > high[1] ? 1 : -1, cast += 1;
            high[0] = high[1] = cycle ? before : reading.value;
            cycle = now;
        }
        double &most = high[std::abs(std::remainder(deg, 720)) < 180 ? 0 : 1];
        most = std::fmax(most, reading.value);
        before = reading.value;
    }
    return elected(votes, cast);
}

struct Read {
    FoundRecording found;
    std::vector<Stretch> stretches;
    std::vector<double> cam_s;
    CrankRecord record;
    ReplayResult result;
};

Read read_all(const ReplayOptions &options, double bar, const EngineFile &engine) {
    const TextLayout layout = RowReader(std::filesystem::path(options.file)).layout();
    Read read{find_recording(options.file, recording_constraints(options, layout, &engine)), {}, {}, {}, {}};
    const auto sensors = sensor_sources(options, layout, kStoichiometric);
    RecordedEvents events(options.file, read.found.guess, sensors);
    Collector collector(engine.wheel.positions);
    ReplayPlan plan;
    plan.positions = engine.wheel.positions;
    plan.next = [&](RecordedEvent &event) {
        while (events.next(event)) {
            if (event.kind == RecordedEvent::crank_edge) return true;
            if (event.kind == RecordedEvent::cam_edge) read.cam_s.push_back(event.t_s);
            else if (event.input == kPressureInput) read.record.pressure.push_back({event.t_s, event.value * bar});
            else if (event.input == SD_INPUT_AIR_INTAKE_PRESSURE) read.record.intake.push_back({event.t_s, event.value});
            else if (event.input == SD_INPUT_FUEL_INJECTED) read.record.fuel.push_back({event.t_s, event.value});
        }
        return false;
    };
    CrankAlone crank(options.file, engine, kStall_s);
    read.result = replay(plan, crank, collector);
    read.stretches = std::move(collector.stretches);
    return read;
}

/// Of each stretch, or a sentence on why there is none.
std::string find_phases(const ReplayOptions &options, const EngineFile &engine, Read &read) {
    std::string why;
    for (Stretch &stretch : read.stretches) {
        if (engine.has_cam) stretch.parity = parity_by_cam(stretch, read.cam_s, engine);
        if (!stretch.parity) stretch.parity = parity_by_pressure(stretch, read.record.pressure, engine);
    }
    if (read.stretches.empty() || read.stretches.front().parity) return why;
    if (!options.parity.empty()) {
        read.stretches.front().parity = options.parity == "second" ? 1 : 0;
        return "the revolution of the cycle is as --parity says";
    }
    const ParityFound found = find_parity(options.file, read.found.guess, engine, kStall_s);
    read.stretches.front().parity = found.parity.value_or(0);
    return found.parity ? found.note
                        : found.note + "; the first one in sync is taken, which matters only to which cylinder is which";
}

} // namespace

RecordedTeeth read_recorded_teeth(const ReplayOptions &options, double bar, const EngineFile &engine) {
    Read read = read_all(options, bar, engine);
    if (const auto why = why_not_followed(read.found, read.result)) throw NotFollowed(options.file, *why);
    RecordedTeeth teeth;
    teeth.notes = notes_of(read.found);
    if (const std::string note = find_phases(options, engine, read); !note.empty()) teeth.notes.push_back(note);
    teeth.edges = read.result.edges;
    teeth.record = std::move(read.record);
    long after = 0; // a stretch begins a whole cycle behind the one before, so that no cycle holds teeth of both
    std::size_t lost = 0;
    const long cycle = 2L * engine.wheel.positions;
    for (const Stretch &stretch : read.stretches) {
        if (!stretch.parity || stretch.teeth.size() < kLeastTeeth) {
            lost += stretch.teeth.size();
            continue;
        }
        for (const PlacedTooth &tooth : stretch.teeth)
            teeth.record.teeth.push_back({tooth.t_s, after + *stretch.parity * engine.wheel.positions + tooth.place});
        after = (teeth.record.teeth.back().place / cycle + 2) * cycle;
    }
    if (lost > 0) teeth.notes.push_back(fmt::format("{} teeth are left out: the revolution of the cycle is not known there", lost));
    return teeth;
}

} // namespace sixdeg
