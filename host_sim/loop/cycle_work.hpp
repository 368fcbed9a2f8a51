// SPDX-License-Identifier: MIT
// Work of a cycle from crank teeth alone: how much faster the same tooth passes a cycle later. Needs neither tooth pattern nor pulse nor
// cam; the tooth's own error, the inertia's course over the angle and the reciprocating masses are the same both times.
#pragma once
#include <optional>
#include <utility>
#include <vector>

#include "common/engine_file.hpp"
#include "loop/replay.hpp"

namespace sixdeg {

/// Energy that the crank has gained over the last cycle, from the teeth of the last 60 deg.
class CycleWork {
  public:
    /// Of a wheel with so many positions. `inertia_kgm2` 0: not known, and no work is told.
    CycleWork(int positions, double inertia_kgm2) : positions_(positions), inertia_kgm2_(inertia_kgm2), passes_(std::size_t(positions)) {}
    void tooth(const ToothRow &row);
    /// J, positive where the crank has become faster: work of all firings of the 720 deg less that of load and friction. With its standard
    /// deviation from how the teeth differ, which is more than it is, because neighbours err in opposite ways. Nothing before the first
    /// whole cycle, over faults, and where the inertia is not known.
    std::optional<std::pair<double, double>> last() const;

  private:
    struct Pass {
        long revolution = -1;
        double squared = 0; ///< Of the speed in rad/s.
    };
    int positions_;
    double inertia_kgm2_;
    std::vector<std::pair<Pass, Pass>> passes_; ///< Of each tooth: the last and the one before.
    std::vector<std::pair<long, double>> gains_; ///< Absolute position and energy gained there, of the last 60 deg.
    long revolution_ = 0;
    int last_tooth_ = -1;
};

/// Which of two revolutions begins the cycle, from how the crank speeds up behind the firing TDCs and behind those a revolution later.
class PhaseFinder : public ReplaySink {
  public:
    explicit PhaseFinder(const EngineFile &engine) : engine_(engine) {}
    void tooth(std::size_t, const ToothRow &row) override;
    /// Whether more teeth would still be looked at: not after the angle was lost, nor after 400 revolutions.
    bool wants_more() const { return !ended_; }

    struct Answer {
        int parity = 0;      ///< 0: the first revolution in sync is the cycle's first.
        double sds = 0;      ///< How many standard deviations speak for it.
        std::size_t cycles = 0;
        bool clear = false;
        bool fires_alike = false; ///< A revolution later the engine fires at the same angles: nothing can tell.
    };
    Answer answer() const;

  private:
    double mean_squared(double from, double to) const;
    EngineFile engine_;
    std::vector<double> squared_; ///< Speed, rad/s, squared, by position from the first revolution in sync on; 0: no tooth.
    long revolution_ = -1;
    int last_tooth_ = -1;
    bool ended_ = false;
};

} // namespace sixdeg
