// SPDX-License-Identifier: MIT
// The simulated engine: pressures of up to 8 cylinders and the crank, integrated over crank angle in fixed
// steps.
//
// Per cylinder, with p in Pa, over crank angle a in rad (docs/plant.md, section Cylinder):
//   valves closed:  dp/da = ((Q' - Qw') - (c_v/R + 1) p V') / (c_v/R V),  T = p V/(m R)
//   a valve open:   dp/da = exchange_per_rad (p_manifold - p)
// Each cylinder has a motored twin with the same trapped mass and no fuel; the difference of their torques is
// the combustion torque. Crank, in the form of kinetic energy E = J(a) w^2 / 2, which holds J' w^2/2 + J w'
// exactly:
//   dE/da = sum (p - p_crankcase) V' - T_friction(w) - T_load(t),   dt/da = 1/w
// All of it is one state, stepped by the classical fourth-order Runge-Kutta rule; valve events fall on steps.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "plant/engine/plant_engine.hpp"
#include "plant/engine/wiebe.hpp"

namespace sixdeg {

constexpr int kMaxCylinders = 8;

/// How one cylinder differs from the nominal one, for good.
struct CylinderSpread {
    double compression_ratio; ///< Of this cylinder.
};

/// What one cylinder receives for one cycle, given when its intake valve closes.
struct Charge {
    double fuel_kg = 0;
    double burned_fraction = 1; ///< Of the fuel that could burn; 0 is a misfire.
    double start_shift_rad = 0; ///< Added to the start of every pulse.
    double duration_factor = 1; ///< On the duration of every pulse.
    double heat_factor = 1;     ///< Cyclic variation of the heat.
};

/// The crank at the end of a step.
struct StepTruth {
    double angle_rad = 0; ///< Since firing TDC of firing_order[0] in cycle 0; never wraps.
    double time_s = 0;
    double speed_radps = 0;
    double combustion_torque_nm = 0; ///< Gas torque less the gas torque of the motored twins.
    double gas_torque_nm = 0;        ///< All cylinders, crankcase pressure behind the pistons.
    double load_torque_nm = 0; ///< Load plus friction (with a dual-mass flywheel: its spring plus friction).
    double net_torque_nm = 0;  ///< Gas less load: dE/da, the inertia torque J' w^2/2 + J w'.
};

/// One cylinder over one cycle, from 360 deg before its firing TDC to 360 deg after.
struct CycleTruth {
    std::int64_t cycle = 0; ///< Cycle 0 holds firing TDC of firing_order[0] at angle 0.
    int cylinder = 0;       ///< Physical number, 1-based.
    double tdc_time_s = 0;
    double tdc_speed_radps = 0;
    double work_j = 0;            ///< Integral of p dV over the cycle.
    double imep_pa = 0;           ///< work_j over the displacement of one cylinder (net: pumping is in it).
    double combustion_work_j = 0; ///< The same integral less that of the motored twin.
    double combustion_torque_nm =
        0;                  ///< Mean of this cylinder's combustion torque over the 180 deg after its TDC.
    double wall_loss_j = 0; ///< Heat to the walls while the valves are closed.
    double fuel_kg = 0, air_kg = 0; ///< Injected, trapped.
    double heat_j = 0;              ///< Released until the exhaust valve opens.
    double burned_fraction = 1;
    double peak_pressure_pa = 0;
    bool misfire = false; ///< Less than half of what could burn did.
    double exhaust_lambda = 0; ///< 1 - air/gas of what its exhaust valve let out (plant/exhaust/exhaust_model.hpp); 0 without it.
};

/// Valve and bookkeeping events; each falls on the step nearest to its angle.
enum class EventKind : std::uint8_t { intake_close, tdc, half_turn, exhaust_open, exchange };
struct Event {
    int step; ///< Within the cycle, [0, steps).
    int lane; ///< Index into firing_order.
    EventKind kind;
};

/// The tables that depend on angle only: half a step apart, all cylinders of one angle side by side.
struct StepTables {
    StepTables(const PlantEngine &engine, const std::vector<CylinderSpread> &spread, double step_deg);
    int steps; ///< A cycle.
    double step_rad;
    int width; ///< Columns: cylinders.
    std::vector<double> volume, volume_slope, wall; ///< [2 steps][width]; wall = area sqrt(volume).
    std::vector<double> volume_slope_sum;           ///< [2 steps], over cylinders.
    std::vector<double> inertia;                    ///< [2 steps], driveline included when it is rigid.
    std::vector<double> two_over_inertia;           ///< [2 steps]: w^2 = E times this.
    std::vector<Event> events;                      ///< Ascending by step.
    std::vector<double> tdc_rad;                    ///< Firing TDC of each lane, exact.
};

/// One engine. Holds no reference to anything outside and no global: copies and instances are independent.
class EngineModel {
  public:
    /// `step_deg` divides 180 a whole number of times and is at most 1. Spread: one entry per entry of
    /// firing_order.
    EngineModel(const PlantEngine &engine, const std::vector<CylinderSpread> &spread, double step_deg);

    /// Sets angle (a step of cycle `cycle`), time and speed, every cylinder at manifold pressure.
    void start(std::int64_t cycle, int step, double time_s, double speed_radps);
    /// Moves the clock and nothing else; load and speed profiles start anew from their value there.
    void set_time(double time_s);
    /// Load torque at the coming step's start and its rate of change; held until set again.
    void set_load(double torque_nm, double slope_nmps);
    /// Makes the speed follow start + slope (t - now), whatever the torques; call release_speed() to end it.
    void prescribe_speed(double speed_radps, double slope_radps2);
    void release_speed();
    /// Mean speed for the wall's heat transfer coefficient, rad/s.
    void set_mean_speed(double speed_radps);
    /// Manifold pressure that `lane` breathes from now on, Pa; trapped mass follows it.
    void set_intake_pressure(int lane, double pressure_pa);
    /// Call when step() reports intake_close of that lane.
    void set_charge(int lane, const Charge &charge);

    /// One step. False, and nothing changed, when the crank would stand still within it.
    bool step();

    const StepTruth &truth() const { return truth_; }
    /// Events at the angle just reached.
    const Event *events_begin() const { return tables_.events.data() + first_event_; }
    const Event *events_end() const { return tables_.events.data() + next_event_; }
    /// Valid right after the event `exchange` of that lane: the cycle that just ended.
    const CycleTruth &finished(int lane) const { return finished_[std::size_t(lane)]; }
    /// Of one cylinder, `lane` an index into firing_order, at the angle just reached. Work counts from the
    /// last event `exchange`, heat from the last intake_close.
    double pressure_pa(int lane) const { return state_.p[lane][0]; }
    double trapped_kg(int lane) const { return mass_[std::size_t(lane)]; }
    double heat_lost_j(int lane) const { return state_.wall[lane][0]; }
    double heat_released_j(int lane) const { return released_[std::size_t(lane)]; }
    double work_j(int lane) const { return state_.work[lane][0]; }
    double heat_rate_jprad(int lane) const { return heat_[0][lane]; }
    /// Gas torque of one cylinder at the angle just reached, N m.
    double gas_torque_nm(int lane) const { return slope_.work[lane][0] - crankcase_pa_ * slope_volume(lane); }
    const StepTables &tables() const { return tables_; }
    int step_in_cycle() const { return step_; }
    std::int64_t cycle() const { return cycle_; }
    /// Kinetic energy of the crank (with a dual-mass flywheel: of its primary side), J.
    double energy_j() const { return state_.crank.energy; }
    /// Dual-mass flywheel: how far the crank is ahead of the secondary mass, rad, and the secondary's speed.
    double flywheel_twist_rad() const { return state_.crank.twist; }
    double secondary_speed_radps() const { return state_.crank.secondary; }

  private:
    /// A fired cylinder and its motored twin, side by side in one machine vector.
    typedef double Twins __attribute__((vector_size(2 * sizeof(double))));
    struct Motion {
        double energy, time, twist, secondary;
    };
    struct State {
        Twins p[kMaxCylinders], work[kMaxCylinders], wall[kMaxCylinders]; // by lane
        Motion crank;
    };
    struct Totals { // of one evaluation, for truth
        double fired, motored, gas, load, speed;
    };

    void evaluate(int half, const State &at, const double *heat, State &slope, Totals &totals) const;
    void shut_cylinder(int half, int lane, double inv_speed, double heat, const State &at, State &slope) const;
    void add(const State &base, double h, const State &slope, State &sum) const;
    void commit(const State &k2, const State &k3, const State &k4);
    void sort_lanes();
    void evaluate_here();
    void heat_rates(int half, double *rates) const;
    bool stands_still(const Motion &at) const;
    void take_events();
    double speed_at(int half, const Motion &at) const;
    void apply(const Event &event);
    void finish_cycle(int lane);
    void update_truth();
    double slope_volume(int lane) const {
        return tables_.volume_slope[std::size_t(2 * step_ * tables_.width + lane)];
    }
    double volume(int lane) const { return tables_.volume[std::size_t(2 * step_ * tables_.width + lane)]; }
    double theta(int half, int lane) const;
    double work_of_fuel_j(int lane) const { return state_.work[lane][0] - state_.work[lane][1]; }

    StepTables tables_;
    int n_;
    std::vector<int> physical_;
    std::vector<PulseShape> pulse_shapes_;
    double crankcase_pa_, exhaust_pa_, charge_k_, exchange_, heating_value_, stoichiometric_, wall_k_,
        wall_factor_;
    double stroke_m_, displacement_m3_; // of one cylinder
    double friction_nm_[3];             // of speed in rad/s
    std::optional<DualMassFlywheel> dual_mass_;
    double secondary_inertia_;

    std::int64_t cycle_ = 0;
    int step_ = 0;
    std::size_t first_event_ = 0, next_event_ = 0; ///< Of those at this step.
    State state_{}, slope_{};
    Totals totals_{};
    double heat_[3][kMaxCylinders] = {}; // rates at start, middle and end of the step; of open lanes zero
    // Per lane, for both twins alike.
    bool shut_[kMaxCylinders] = {};
    double manifold_[kMaxCylinders] = {}, inverse_mr_[kMaxCylinders] = {}, wall_gain_[kMaxCylinders] = {};
    int lanes_[kMaxCylinders] = {}; // those with shut valves first
    int shut_count_ = 0;
    std::array<double, kMaxCylinders> intake_pa_{}, mass_{};
    std::array<bool, kMaxCylinders> inhaling_{}; // from the exchange to intake closing
    std::array<std::array<WiebePulse, 2>, kMaxCylinders> burning_{};
    double released_[kMaxCylinders] = {}; // J, of the cycle under way
    std::array<double, kMaxCylinders> burn_from_{}, burn_to_{};
    std::array<bool, kMaxCylinders> burns_{};
    double peak_[kMaxCylinders] = {}; // Pa, of the cycle under way
    double load_nm_ = 0, load_slope_ = 0, load_time_ = 0;
    bool prescribed_ = false;
    double speed0_ = 0, speed_slope_ = 0, speed_time_ = 0;
    double wall_speed_ = 0;

    StepTruth truth_;
    std::array<CycleTruth, kMaxCylinders> running_{}, finished_{};
    std::array<double, kMaxCylinders> work_at_tdc_{};
};

} // namespace sixdeg
