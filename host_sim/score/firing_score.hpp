// SPDX-License-Identifier: MIT
// Torque of single firings and of cylinders against the plant's own. Torques are mean combustion torque over the 180 deg
// after TDC; percent are of its mean over all firings scored. Each error is taken less the mean error of its cycle, since
// load, friction and the common part of the motored torque are unknown; what that leaves out is bias_percent.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/engine_file.hpp"
#include "plant/engine/engine_model.hpp"

namespace sixdeg {

struct FiringFigures {
    int cycles = 0;                 ///< Whole ones scored, the first kSettleCycles left out.
    double mean_nm = 0;             ///< True mean combustion torque.
    double mean_radps = 0;          ///< Mean speed at their TDCs.
    double bias_percent = 0;        ///< Mean estimate less truth.
    double single_percent = 0, single_max_percent = 0;       ///< Of one firing: rms, largest.
    double imbalance_percent = 0, imbalance_max_percent = 0; ///< Of the mean over 10 cycles.
    double single_honesty = 0, imbalance_honesty = 0;        ///< Rms error over rms of the stated deviation.
    std::size_t invalid = 0;        ///< Firings said, but not to be valid, after settling.
};

class FiringScore {
  public:
    static constexpr int kSettleCycles = 15;
    static constexpr int kMeanCycles = 10; ///< As the firmware's.

    explicit FiringScore(const EngineFile &engine) : engine_(engine) {}

    /// What the firmware said of a firing at the true angle `crank_deg`, which never wraps.
    void said(double crank_deg, int cylinder, double torque_nm, double sd_nm, double mean_nm, double mean_sd_nm, bool valid);
    void truth(const CycleTruth &cycle);
    /// Nothing when no cycle is whole.
    std::optional<FiringFigures> result() const;

  private:
    struct Said {
        double torque_nm, sd_nm, mean_nm, mean_sd_nm;
        bool valid;
    };
    using Key = std::pair<std::int64_t, std::size_t>; // cycle of the plant, index into firing_order
    struct Cycle;
    std::optional<double> mean_truth(const Key &last) const;
    std::optional<Cycle> cycle_at(std::int64_t number) const;

    EngineFile engine_;
    std::map<Key, Said> said_;
    struct Truth {
        double torque_nm, speed_radps;
    };
    std::map<Key, Truth> truth_;
};

} // namespace sixdeg
