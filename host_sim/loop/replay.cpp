// SPDX-License-Identifier: MIT
#include "loop/replay.hpp"

#include <cmath>
#include <cstring>
#include <utility>
#include <memory>
#include <utility>

#include "common/error.hpp"
extern "C" {
#include "sd_learned.h"
}

namespace sixdeg {
namespace {

constexpr double kCamTolerance_rev = 0.06;
constexpr double kStandstill_s = 0.5; // Longer between two edges, and the engine is taken to stand.

/// What both kinds of replay do with an event.
template <typename Bench> class Replayer {
  public:
    Replayer(const ReplayPlan &plan, Bench &bench, ReplaySink &sink) : plan_(plan), bench_(bench), sink_(sink), rows_(sink) {}

    ReplayResult run() {
        RecordedEvent event{};
        while (plan_.next(event)) take(event);
        return rows_.finish(bench_.crank());
    }

  private:
    void take(const RecordedEvent &event) {
        switch (event.kind) {
        case RecordedEvent::reading:
            if (event.input == kLoadInput) sink_.load(event.value);
            else bench_.show(sd_input_t(event.input), event.value);
            return;
        case RecordedEvent::cam_edge:
            if (is_telling_cam_edge()) cam_edge(event.t_s);
            return;
        case RecordedEvent::crank_edge: crank_edge(event.t_s); return;
        }
    }

    void crank_edge(double t_s) {
        bench_.tell_time_until(t_s);
        const bool cycle_ended = bench_.exchange(SD_EVENT_CRANK_EDGE, bench_.tick_at(t_s));
        rows_.edge(t_s, cycle_ended, bench_.said());
        if (plan_.parity) count_parity(t_s);
    }

    void cam_edge(double t_s) {
        bench_.exchange(SD_EVENT_CAM_EDGE, bench_.tick_at(t_s));
        rows_.cam_edge();
    }

    bool is_telling_cam_edge() const {
        if (!plan_.cam_position) return true;
        if (!is_placed(bench_.said().signals())) return false;
        const double off = (double(bench_.said().signals().crank_tooth) - *plan_.cam_position) / plan_.positions;
        return std::abs(std::remainder(off, 1.0)) < kCamTolerance_rev;
    }

    /// In place of a cam: the caller knows which revolution is which, so the edge is made where the page expects it.
    void count_parity(double t_s) {
        const sd_signals_t &s = bench_.said().signals();
        if (!is_placed(s)) {
            if (s.crank_edge_class == SD_EDGE_UNSYNCED) parity_lost_ = revolution_ >= 0;
            return;
        }
        if (parity_lost_) return;
        const int tooth = int(s.crank_tooth), place = plan_.parity_position % plan_.positions;
        if (last_tooth_ > tooth || revolution_ < 0) revolution_ = revolution_ < 0 ? *plan_.parity : revolution_ + 1;
        const bool passes = last_tooth_ <= tooth ? last_tooth_ < place && place <= tooth : place <= tooth;
        if (passes && revolution_ % 2 == plan_.parity_position / plan_.positions) cam_edge(t_s);
        last_tooth_ = tooth;
    }

    const ReplayPlan &plan_;
    Bench &bench_;
    ReplaySink &sink_;
    ReplayRows rows_;
    int revolution_ = -1, last_tooth_ = -1;
    bool parity_lost_ = false;
};

} // namespace

void ReplayRows::edge(double t_s, bool cycle_ended, const EcuSaid &said) {
    const ToothRow row{t_s, said.signals(), said.health(SD_OWNER_CRANK), said.health(SD_OWNER_TORQUE), said.health(SD_OWNER_FIRING)};
    count_time(row);
    count_revolutions(row);
    sink_.tooth(result_.edges++, row);
    if (std::exchange(works_, said.works()) != said.works())
        sink_.work(result_.works++, {t_s, row.signals, said.health(SD_OWNER_WORK)});
    if (std::exchange(firings_, said.firings()) != said.firings()) {
        count_misfires(row.signals);
        sink_.firing(result_.firings++, {t_s, row.signals, row.firing_health, said.health(SD_OWNER_MISFIRE), said.health(SD_OWNER_AFR)});
    }
    if (cycle_ended)
        sink_.cycle(result_.cycles++, {t_s, row.signals, said.health(SD_OWNER_CYLINDER), row.firing_health, said.health(SD_OWNER_AFR)});
    result_.last = row.signals;
}

/// Of standing still nobody expects an angle.
void ReplayRows::count_time(const ToothRow &row) {
    const double since_s = last_edge_s_ ? row.t_s - *last_edge_s_ : 0;
    last_edge_s_ = row.t_s;
    if (since_s > kStandstill_s) return;
    result_.turned_s += since_s;
    if (row.signals.crank_edge_class == SD_EDGE_UNSYNCED) return;
    result_.synced_s += since_s;
    if (row.signals.crank_phase_known > 0.5f) result_.phased_s += since_s;
}

/// Whole revolutions, from tooth 0 to tooth 0 without losing sync between.
void ReplayRows::count_revolutions(const ToothRow &row) {
    const int edge_class = int(row.signals.crank_edge_class);
    if (edge_class == SD_EDGE_UNSYNCED) last_zero_s_.reset(), placed_ = 0;
    if (edge_class == SD_EDGE_UNSYNCED || edge_class == SD_EDGE_SPURIOUS) return;
    if (!result_.first_sync_edge) result_.first_sync_edge = result_.edges;
    const float tooth = row.signals.crank_tooth;
    ++placed_;
    if (tooth != 0 && tooth <= last_tooth_) last_zero_s_.reset(); // tooth 0 was passed without an edge, or the angle was put right
    last_tooth_ = tooth;
    if (tooth != 0) return;
    const std::size_t placed = std::exchange(placed_, 0);
    if (last_zero_s_) most_placed_ = std::max(most_placed_, placed);
    if (last_zero_s_ && placed * 5 >= most_placed_ * 4) { // fewer: the angle was put right on the way
        ++result_.revolutions;
        result_.rpm_last = 60 / (row.t_s - *last_zero_s_);
        result_.rpm_last_s = row.t_s;
    }
    last_zero_s_ = row.t_s;
}

void ReplayRows::count_misfires(const sd_signals_t &s) {
    const int cylinder = int(s.misfire_cylinder), verdict = int(s.misfire_verdict);
    if (cylinder < 1 || cylinder > int(result_.misfires.size()) || verdict == 3) return;
    MisfireCounts &counts = result_.misfires[std::size_t(cylinder - 1)];
    ++counts.judged;
    counts.partial += verdict == 1;
    counts.misfires += verdict == 2;
}

ReplayResult ReplayRows::finish(const sd_crank_t &crank) {
    result_.counts = crank.counts;
    for (int m = 0; m < crank.mark_count; ++m) result_.mark_spacings.push_back(double(crank.mark_spacings[m]) / SD_SPACING_ONE);
    return std::move(result_);
}

CrankAlone::CrankAlone(const std::string &name, const EngineFile &engine, double stall_s)
    : EcuFeed(engine.tick_hz), position_0_deg_(engine.position_0_deg), tick_hz_(engine.tick_hz) {
    sd_crank_config_t config{};
    config.positions = std::uint8_t(engine.wheel.positions);
    config.missing_count = std::uint8_t(engine.wheel.missing.size());
    bool fits = engine.wheel.missing.size() <= SD_CRANK_MISSING_MAX;
    for (std::size_t i = 0; fits && i < engine.wheel.missing.size(); ++i) config.missing[i] = std::uint8_t(engine.wheel.missing[i]);
    config.stall_ticks = std::uint32_t(stall_s * engine.tick_hz);
    fits = fits && sd_crank_init(&crank_, &config) == SD_OK;
    if (!fits)
        throw InputError(
            name, describe(engine.wheel),
            "is the wheel, and the decoder does not take it: marks are 1 to 3 missing teeth, at most 4 of them, at least 4 teeth "
            "apart or two alike with 1 between");
}

void CrankAlone::say(sd_signal_t signal, double value, std::uint32_t tick, std::uint8_t health) {
    const float number = float(value);
    sd_event_t event{tick, SD_EVENT_SIGNAL, std::uint16_t(signal), 0, health};
    std::memcpy(&event.value, &number, sizeof number);
    said_.take(event);
}

void CrankAlone::send(const sd_event_t &event) {
    if (event.kind == SD_EVENT_TIME) sd_crank_poll(&crank_, event.tick);
    if (event.kind != SD_EVENT_CRANK_EDGE) return;
    sd_tooth_t tooth{};
    sd_crank_edge(&crank_, event.tick, &tooth);
    const double deg = position_0_deg_ + 360.0 * tooth.cycle_position / crank_.config.positions;
    say(SD_SIGNAL_CRANK_EDGE_CLASS, tooth.edge_class, event.tick, tooth.health);
    say(SD_SIGNAL_CRANK_TOOTH, tooth.position, event.tick, tooth.health);
    say(SD_SIGNAL_CRANK_ANGLE, std::fmod(deg, 720), event.tick, tooth.health);
    say(SD_SIGNAL_CRANK_SPEED, double(sd_crank_speed_radps(&crank_, &tooth, float(tick_hz_))) * 30 / M_PI, event.tick, tooth.health);
    say(SD_SIGNAL_TORQUE_MASS, 0, event.tick, SD_INVALID);
    say(SD_SIGNAL_FIRING_WAVEFORM, 0, event.tick, SD_INVALID);
}

namespace {

/// The decoder alone behind the calls of a bench.
struct DecoderBench {
    CrankAlone &alone;
    void show(sd_input_t, double) {}
    void tell_time_until(double t_s) { alone.tell_time_until(t_s); }
    std::uint32_t tick_at(double t_s) const { return alone.tick_at(t_s); }
    bool exchange(std::uint16_t kind, std::uint32_t tick) { return alone.send({tick, kind, 0, 0, 0}), false; }
    const EcuSaid &said() const { return alone.said(); }
    const sd_crank_t &crank() const { return alone.crank(); }
};

} // namespace

ReplayResult replay(const std::string &file, const ReplayPlan &plan, const sd_calibration_t &calibration, ReplaySink &sink) {
    const auto bench = std::make_unique<EcuBench>(calibration);
    if (plan.learned && !bench->resume(*plan.learned)) throw InputError(file, "--learned",
        "is of another wheel or another lambda sensor, or the engine file has neither heat release nor exhaust");
    ReplayResult result = Replayer<EcuBench>(plan, *bench, sink).run();
    result.learned = bench->learned();
    result.evidence = bench->evidence();
    return result;
}

ReplayResult replay(const ReplayPlan &plan, CrankAlone &crank, ReplaySink &sink) {
    DecoderBench bench{crank};
    return Replayer<DecoderBench>(plan, bench, sink).run();
}

} // namespace sixdeg
