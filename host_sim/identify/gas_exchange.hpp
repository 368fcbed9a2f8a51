// SPDX-License-Identifier: MIT
// The revolution in which a single cylinder does not fire, as a fuel cut of its own: from behind the blow-down to ahead of compression the
// gas does little, so that the teeth show the wheel. The stretch is a little longer than a revolution: teeth that pass twice in it
// tell load from wheel.
#pragma once
#include "identify/gas_torque.hpp"

namespace sixdeg {

/// Torque of the gas exchange, about its TDC: exhaust pressure ahead of it, intake pressure behind it. Angles of its cycles count from
/// that TDC.
class ExchangeTorque : public GasTorque {
  public:
    /// The intake pressure is taken from the cycles' readings, else from the difference that `pressure` shows between the two strokes, else
    /// from what intakes have. `inertia_sd`: relative, of the engine file's or of what was found.
    ExchangeTorque(const EngineFile &engine, const std::vector<WholeCycle> &cycles, const std::vector<TimedValue> &pressure,
        double inertia_sd);

  private:
    enum { exhaust_bar = shared_unknowns, intake_bar };
    Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const override;
};

/// The gas exchanges of a single cylinder of which no tooth is missing, `deg` from their TDC. Empty for other engines, and where the
/// valves leave no stretch that is longer than a revolution.
std::vector<WholeCycle> gas_exchanges(const EngineFile &engine, const CrankRecord &record);

} // namespace sixdeg
