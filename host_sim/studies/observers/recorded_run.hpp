// SPDX-License-Identifier: MIT
// One simulated run whose events are given to one ecu after the other, and what each of them says of every firing.
#pragma once
#include <cstdint>
#include <vector>

#include "loop/bench_run.hpp"

namespace sixdeg {

/// What an ecu says of one firing.
struct FiringVerdict {
    std::uint32_t tick; ///< Of the crank edge at which it is said.
    int cylinder;       ///< Physical, 1-based.
    int verdict;        ///< sd_verdict_t.
    double index;       ///< Share of the work of a healthy firing: 1 healthy, 0 a misfire; 0 where it is not judged.
    double limit;       ///< Of the index, below which it is a misfire; 0 where it is not judged.
    int health;         ///< sd_health_t of the verdict.
};

/// Hears what an ecu says of firings: a listener of EcuBench.
class FiringListener {
  public:
    void hear(bool out, const sd_event_t &event);
    const std::vector<FiringVerdict> &verdicts() const { return verdicts_; }

  private:
    EcuSaid said_;
    std::size_t firings_ = 0;
    std::vector<FiringVerdict> verdicts_;
};

/// What the plant did and what the ecu was given.
class PlantRecord : public TruthSink {
  public:
    struct Edge { // of the crank
        std::uint32_t tick;
        int tooth;        ///< Position on the wheel.
        double crank_deg; ///< True angle, never wrapping.
    };
    void edge(const EncoderEdge &edge, double crank_deg) override { edges.push_back({edge.tick, edge.tooth, crank_deg}); }
    void cycle(const CycleTruth &cycle) override { cycles.push_back(cycle); }
    void hear(bool out, const sd_event_t &event) {
        if (!out) events.push_back(event);
    }
    std::vector<Edge> edges;
    std::vector<CycleTruth> cycles;
    std::vector<sd_event_t> events;
};

/// The page with another method that judges misfires (misfire.method, misfire.arithmetic); no table depends on it.
sd_calibration_t with_method(sd_calibration_t page, int method, int arithmetic);

/// What another ecu, with the page `page`, says on the same events. `learned` (nullptr: nothing) is what was kept from before; throws
/// InputError when it is of another wheel.
std::vector<FiringVerdict> verdicts_on(const PlantRecord &record, const sd_calibration_t &page, const sd_kept_t *learned = nullptr);

/// Crank angle of each verdict, never wrapping: of the edge at which it was said. Those of no edge, and all behind them, are left out.
std::vector<double> said_at_deg(const std::vector<FiringVerdict> &verdicts, const PlantRecord &record);

/// The score of verdicts in the order of their ticks against what the plant did.
MisfireScore score_of(const std::vector<FiringVerdict> &verdicts, const PlantRecord &record, const EngineFile &engine);

} // namespace sixdeg
