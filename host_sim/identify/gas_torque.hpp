// SPDX-License-Identifier: MIT
// Gas torque of a cycle over the crank angle: measured in one cylinder, or of compression by the calibration's model; and what each
// unknown changes about it.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "identify/crank_motion.hpp"

namespace sixdeg {

/// A number to be found.
struct Unknown {
    std::string name;
    double start;      ///< What it is taken for at first.
    double prior_sd;   ///< What is known of it beforehand, about `start`; 0: nothing.
    double unit;       ///< One of these is a usual change: columns of the fit are scaled by it.
};

/// Names of those that both kinds have, in this order. `log_inertia`: ln of J0 over the file's; `offset`: rad by which every tooth stands
/// at a larger crank angle than the file says; `ripple`: relative error of the reciprocating mass.
enum SharedUnknown { log_inertia, wheel_offset, ripple_mass, shared_unknowns };

class GasTorque {
  public:
    virtual ~GasTorque() = default;
    const std::vector<Unknown> &unknowns() const { return unknowns_; }
    /// `grid_s`: predicted times of the grid. `values`: one an unknown.
    CycleTorque torque(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const;

  protected:
    explicit GasTorque(const EngineFile &engine);
    struct Nm {
        Eigen::VectorXd gas;   ///< N m over the grid.
        Eigen::MatrixXd slope; ///< Over every unknown; what is inertia or ripple stays 0.
    };
    virtual Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const = 0;
    /// Index of a cylinder's firing TDC on the grid's angles, deg from the first one's.
    double tdc_deg(std::size_t lane) const { return engine_.firing_tdc_deg[lane]; }

    const EngineFile &engine_;
    std::vector<Unknown> unknowns_;

  private:
    Eigen::VectorXd squared_arms(double offset_rad) const; ///< m2, sum over cylinders.
};

/// Of a cylinder whose pressure is recorded. The others are taken to have the same pressure in the same cycle, times a factor each: true
/// without combustion. With one cylinder it holds in any cycle.
class MeasuredTorque : public GasTorque {
  public:
    /// `pressure`: bar, as recorded. Both outlive it.
    MeasuredTorque(const EngineFile &engine, const std::vector<TimedValue> &pressure);

    /// Pressure over the grid, bar as recorded, at these times.
    Eigen::VectorXd recorded_bar(const Eigen::VectorXd &grid_s) const;
    /// What to add to it: by the intake's pressure ahead of compression where that is known, else by the polytropic line of compression.
    double level_bar(const WholeCycle &cycle, const Eigen::VectorXd &recorded, double offset_rad) const;
    static bool covers(const std::vector<TimedValue> &pressure, const WholeCycle &cycle);

  private:
    Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const override;
    const std::vector<TimedValue> &pressure_;
};

/// Of compression without combustion, by design/torque/pulse.hpp. Without an intake pressure 1 bar is taken, and the inertia found is
/// that over the charge.
class CompressionTorque : public GasTorque {
  public:
    explicit CompressionTorque(const EngineFile &engine);

  private:
    enum { exponent = shared_unknowns, wall_loss, compression, exchange, first_factor };
    struct Tables {
        std::vector<double> per_bar, rest; ///< At kPulsePoints from the cylinder's TDC.
    };
    struct At {
        Tables base;
        std::vector<Tables> moved; ///< By exponent, wall loss, compression; as slopes.
    };
    Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const override;
    const At &tables(double speed_radps, const Eigen::VectorXd &values) const;
    Tables model(double speed_radps, const Eigen::Vector3d &moved) const;
    mutable std::map<int, At> kept_; ///< By speed, for `kept_for_`.
    mutable Eigen::VectorXd kept_for_;
};

} // namespace sixdeg
