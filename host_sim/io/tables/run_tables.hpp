// SPDX-License-Identifier: MIT
// teeth.csv and cycles.csv of `sixdeg run`: truth and firmware side by side. Columns: docs/reference/files.md.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/engine_file.hpp"
#include "plant/engine/engine_model.hpp"
#include "io/events/ecu_feed.hpp"
#include "io/tables/air_path_table.hpp"
#include "score/misfire_score.hpp"
#include "plant/sensors/pickup.hpp"

namespace sixdeg {

/// Which of its own cycles the firmware counts a combustion to. Its cycle k begins at position 0 of the
/// wheel, crank angle position_0_deg + 720 k, and holds the firings whose first tooth at or after TDC lies in
/// it. `lane` is an index into firing_order, `cycle` the plant's.
std::int64_t firmware_cycle(const EngineFile &engine, std::int64_t cycle, std::size_t lane);
/// Number of the firmware's cycle that an edge at the true angle `crank_deg` (never wraps) has ended. Right
/// for wheels up to half a turn off.
std::int64_t ended_cycle(const EngineFile &engine, double crank_deg);

class RunTables {
  public:
    explicit RunTables(const EngineFile &engine)
        : engine_(engine), verdicts_(engine), limits_(engine), accelerations_(engine), residuals_(engine) {}

    /// A crank edge at the true angle `crank_deg` (never wraps), all that the firmware has said up to it, and whether the
    /// edge ended a cycle of the firmware's.
    void edge(const EncoderEdge &truth, double crank_deg, const EcuSaid &ecu, bool cycle_ended);
    void true_cycle(const CycleTruth &truth) { truths_.push_back(truth); }

    AirPathTable &air_path() { return air_path_; }

    const std::string &teeth_csv() const { return teeth_; }
    std::string cycles_csv() const;

  private:
    void tooth(const EncoderEdge &truth, const EcuSaid &ecu);
    void note_work(double crank_deg, const EcuSaid &ecu);
    struct Work {
        double cycle_j, sd_j;
        std::optional<double> change_j;
    };
    struct FirmwareCycle {
        sd_signals_t signals;
        std::uint8_t health, afr_health;
    };
    EngineFile engine_;
    AirPathTable air_path_;
    MisfireScore verdicts_;
    MisfireScore limits_; ///< misfire.limit, kept by firing as verdicts are.
    MisfireScore accelerations_, residuals_; ///< Of document 000\'s observer, kept by firing as verdicts are.
    std::size_t firings_ = 0; ///< Of which the verdict is taken.
    std::size_t works_ = 0;   ///< Of which the work is.
    std::map<std::pair<std::int64_t, std::size_t>, Work> works_said_; ///< By cycle of the plant and index into firing_order.
    std::string teeth_ =
        "t_s,angle_deg,rpm_true,rpm,torque_true_nm,torque_nm,class,tooth,tooth_true,health,torque_health,waveform_nm,firing_health\n";
    std::vector<CycleTruth> truths_;
    std::map<std::int64_t, FirmwareCycle> firmware_;
};

} // namespace sixdeg
