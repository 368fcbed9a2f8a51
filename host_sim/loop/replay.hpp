// SPDX-License-Identifier: MIT
// Recorded edges through HAL, ecu, decoder and observers; what the ecu says, row by row.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/engine_file.hpp"
#include "io/recording/events.hpp"
#include "loop/ecu_bench.hpp"

namespace sixdeg {

/// What the ecu said of one crank edge. Values as in hal/signals.toml.
struct ToothRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t crank_health, torque_health, firing_health; ///< sd_health_t
};

/// What it said at the end of a cycle.
struct CycleRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t cylinder_health, firing_health, afr_health;
};

/// What it said of one firing.
struct FiringRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t firing_health, misfire_health, afr_health;
};

/// What it said of the work of a cycle.
struct WorkRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t health;
};

/// Takes rows as they come. Each call has the row's index from 0.
struct ReplaySink {
    virtual ~ReplaySink() = default;
    virtual void tooth(std::size_t, const ToothRow &) {}
    virtual void cycle(std::size_t, const CycleRow &) {}
    virtual void firing(std::size_t, const FiringRow &) {}
    virtual void work(std::size_t, const WorkRow &) {}
    virtual void load(double /*nm*/) {} ///< The torque that the engine works against, from now on.
};

/// Verdicts of the misfire monitor on one cylinder.
struct MisfireCounts {
    std::size_t judged = 0, misfires = 0, partial = 0;
};

struct ReplayResult {
    std::size_t edges = 0, cycles = 0, firings = 0, works = 0;
    sd_crank_counts_t counts{};
    std::vector<double> mark_spacings; ///< Learned width of each mark, in tooth spacings.
    std::optional<std::size_t> first_sync_edge;
    std::size_t revolutions = 0;      ///< Whole revolutions from tooth 0 to tooth 0 in sync.
    std::optional<double> rpm_last;   ///< Mean over the last of them.
    double rpm_last_s = 0;            ///< When that one ended.
    double turned_s = 0, synced_s = 0; ///< Time with edges, and that part of it in which the angle was known.
    double phased_s = 0;              ///< And that in which the revolution of the cycle was.
    std::size_t cam_edges = 0;        ///< Told to the ecu.
    std::array<MisfireCounts, 8> misfires{}; ///< By physical cylinder.
    sd_kept_t learned{};              ///< At the end; empty where only the decoder ran.
    Evidence evidence;                ///< Of how well the calibration fits; none where only the decoder ran.
    sd_signals_t last{};              ///< What was said last.
};

/// Counts and hands on what a bench says while edges go through it.
class ReplayRows {
  public:
    explicit ReplayRows(ReplaySink &sink) : sink_(sink) {}
    /// The bench has just answered a crank edge.
    void edge(double t_s, bool cycle_ended, const EcuSaid &said);
    void cam_edge() { ++result_.cam_edges; }
    ReplayResult finish(const sd_crank_t &crank);

  private:
    void count_time(const ToothRow &row);
    void count_revolutions(const ToothRow &row);
    void count_misfires(const sd_signals_t &signals);

    ReplaySink &sink_;
    ReplayResult result_;
    std::size_t firings_ = 0, works_ = 0; ///< As the ecu has said them, of which the rows are taken.
    std::optional<double> last_edge_s_, last_zero_s_;
    float last_tooth_ = 0;
    std::size_t placed_ = 0, most_placed_ = 0; ///< Edges since tooth 0; most between two.
};

/// The decoder without the rest of an ecu, for wheels that the observers do not take. Says angle, speed and their health.
class CrankAlone : public EcuFeed {
  public:
    /// Throws InputError naming `name` for a wheel that the decoder does not take.
    CrankAlone(const std::string &name, const EngineFile &engine, double stall_s);
    void send(const sd_event_t &event) override;
    const EcuSaid &said() const { return said_; }
    const sd_crank_t &crank() const { return crank_; }

  private:
    void say(sd_signal_t signal, double value, std::uint32_t tick, std::uint8_t health);
    double position_0_deg_, tick_hz_;
    sd_crank_t crank_{};
    EcuSaid said_;
};

/// Stands for a load among the inputs; the ecu has none, so it goes to the sink.
constexpr int kLoadInput = -1;

/// How recorded events reach the ecu.
struct ReplayPlan {
    /// The next event in order of time; false at the end. `input` of a reading is an sd_input_t, or kLoadInput.
    std::function<bool(RecordedEvent &)> next;
    /// Of a cam with several teeth: only edges within 0.06 of a revolution of this position tell; nothing: all do.
    std::optional<double> cam_position;
    /// Without a cam: the first whole revolution in sync counts as the cycle's first (0) or second (1); no phase any more once the angle
    /// was lost.
    std::optional<int> parity;
    int positions = 60, parity_position = 0; ///< Of the wheel; where the cam edge belongs, [0, 2 positions).
    const sd_kept_t *learned = nullptr; ///< What was kept from before, to begin with.
};

/// Feeds the events and a time event every 10 ms to a fresh ecu through the in-process port. Throws InputError naming `file` when what
/// was learned is of another wheel or lambda sensor.
ReplayResult replay(const std::string &file, const ReplayPlan &plan, const sd_calibration_t &calibration, ReplaySink &sink);
/// The same through the decoder alone.
ReplayResult replay(const ReplayPlan &plan, CrankAlone &crank, ReplaySink &sink);

} // namespace sixdeg
