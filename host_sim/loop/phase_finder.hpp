// SPDX-License-Identifier: MIT
// Which of two revolutions begins the cycle, from how the crank speeds up: for recordings without a cam.
#pragma once
#include <vector>

#include "common/engine_file.hpp"
#include "loop/replay.hpp"

namespace sixdeg {

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
