// SPDX-License-Identifier: MIT
// Gas torque of a cycle over the crank angle: measured in one cylinder, or of compression by the calibration's model; and what each
// unknown changes about it.
#pragma once
#include <map>
#include <utility>
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

/// Half orders of the crank in which a torque may act that nobody explains: orders 1/2 to 4, cosine and sine each.
constexpr int kUnexplainedOrders = 8, kUnexplained = 2 * kUnexplainedOrders;

class GasTorque {
  public:
    virtual ~GasTorque() = default;
    /// The last kUnexplained of them are of the unexplained torque, over the rms of the gas torque; how large these may be is the
    /// fit's to find, not below least_unexplained().
    const std::vector<Unknown> &unknowns() const { return unknowns_; }
    double least_unexplained() const { return least_unexplained_; }
    /// Whether the gas torque is a model's, so that its mean may be wrong too, and not a pressure's.
    virtual bool is_model() const { return false; }
    /// `grid_s`: when the crank passed the angles of the grid. `values`: one an unknown.
    CycleTorque torque(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const;

  protected:
    GasTorque(const EngineFile &engine, double least_unexplained);
    /// To be called when all others are in the list.
    void add_unexplained();
    struct Nm {
        Eigen::VectorXd gas;   ///< N m over the grid.
        Eigen::MatrixXd slope; ///< Over every unknown; what is inertia or ripple stays 0.
    };
    virtual Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const = 0;
    /// Of each cylinder over the grid, for the angle by which the crank is ahead of it: m2 and m2/rad, V' over the piston's area and its
    /// change. Kept for the last angle asked for.
    struct Arms {
        double offset_rad;
        Eigen::MatrixXd arm, bend; ///< [grid][cylinder]; m, m/rad.
    };
    const Arms &arms(double offset_rad) const;
    /// Firing TDC of a cylinder, deg from the first one's.
    double tdc_deg(std::size_t lane) const { return engine_.firing_tdc_deg[lane]; }

    const EngineFile &engine_;
    std::vector<Unknown> unknowns_;

  private:
    double least_unexplained_;
    Eigen::MatrixXd waves_; ///< [grid][kUnexplained]
    mutable Arms arms_{};
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
    /// Of the other cylinders' place on the grid where the first one is at the same point of its cycle: index and share of the next point.
    std::pair<Eigen::Index, double> same_place(int i, std::size_t lane) const;
    const std::vector<TimedValue> &pressure_;
};

/// Of compression without combustion, by design/torque/pulse.hpp. Without an intake pressure 1 bar is taken, and the inertia found is
/// that over the charge.
class CompressionTorque : public GasTorque {
  public:
    explicit CompressionTorque(const EngineFile &engine);
    bool is_model() const override { return true; }

  private:
    enum { exponent = shared_unknowns, wall_loss, compression, wall_power, exchange, first_factor };
    static constexpr int kModelled = 4; ///< Of these the first ones.
    struct Tables {
        std::vector<double> per_bar, rest; ///< At kPulsePoints from the cylinder's TDC.
    };
    struct At {
        Tables base;
        std::vector<Tables> moved; ///< By the modelled unknowns; as slopes.
    };
    Nm gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const override;
    const At &tables(double speed_radps, const Eigen::VectorXd &values) const;
    Tables model(double speed_radps, const Eigen::Vector4d &moved) const;
    mutable std::map<int, At> kept_; ///< By speed, for `kept_for_`.
    mutable Eigen::VectorXd kept_for_;
};

} // namespace sixdeg
