// SPDX-License-Identifier: MIT
// The simulated engine: pressures of up to 8 cylinders and the crank, integrated over crank angle in fixed
// steps.
//
// Per cylinder, with p in Pa, over crank angle a in rad (docs/theory/plant.md, section Cylinder):
//   valves closed:  dp/da = ((Q' - Qw') - (c_v/R + 1) p V') / (c_v/R V),  T = p V/(m R)
//   a valve open:   dp/da = exchange_per_rad (p_manifold - p)
// Each cylinder has a motored twin with the same trapped mass and no fuel; the difference of their torques is
// the combustion torque. Crank, in the form of kinetic energy E = J(a) w^2 / 2, which holds J' w^2/2 + J w'
// exactly:
//   dE/da = sum (p - p_crankcase) V' - T_friction(w) - T_load(t),   dt/da = 1/w
// Valve events fall on steps. How a step is made: docs/theory/plant.md, section Integration, and engine_step.cpp.
#pragma once
#include <array>
#include <climits>
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

/// What one cylinder's pressure needs at one angle. A shut cylinder is integrated as y = p V^k, k = kPolytropic, which compression
/// and expansion hardly change.
struct CylinderPoint {
    double volume_slope; ///< V', m3/rad.
    double push;         ///< V' V^-k: p V' over y.
    double pressure;     ///< V^-k: p over y.
    double warmth;       ///< V^(1 - k): T m R over y.
    double rise;         ///< V^(k - 1) times the step.
    double wall;         ///< Wall area times sqrt(V).
};

/// The tables that depend on angle only, half a step apart.
struct StepTables {
    static constexpr double kPolytropic = 1.36;
    StepTables(const PlantEngine &engine, const std::vector<CylinderSpread> &spread, double step_deg);
    /// All cylinders of one angle side by side.
    const CylinderPoint *row(int half) const { return points.data() + std::size_t(half) * width; }
    double volume_m3(int half, int lane) const { return volume[std::size_t(half) * width + std::size_t(lane)]; }
    std::size_t width; ///< Cylinders.
    int steps;         ///< A cycle.
    double step_rad;
    std::vector<CylinderPoint> points;    ///< [2 steps][width]
    std::vector<double> volume;           ///< [2 steps][width], m3.
    std::vector<double> volume_slope_sum; ///< [2 steps], over cylinders.
    std::vector<double> inertia;          ///< [2 steps], driveline included when it is rigid.
    std::vector<double> two_over_inertia; ///< [2 steps]: w^2 = E times this.
    std::vector<Event> events;            ///< Ascending by step.
    std::vector<double> tdc_rad;          ///< Firing TDC of each lane, exact.
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

    const StepTruth &truth() const { return truths_[latest_]; }
    /// What truth() was before the last step.
    const StepTruth &truth_before() const { return truths_[1 - latest_]; }
    /// Events at the angle just reached.
    const Event *events_begin() const { return tables_.events.data() + first_event_; }
    const Event *events_end() const { return tables_.events.data() + next_event_; }
    /// Valid right after the event `exchange` of that lane: the cycle that just ended.
    const CycleTruth &finished(int lane) const { return finished_[std::size_t(lane)]; }
    /// Of one cylinder, `lane` an index into firing_order, at the angle just reached. Work counts from the
    /// last event `exchange`, heat from the last intake_close.
    double pressure_pa(int lane) const { return pressure_of(lane)[0]; }
    double trapped_kg(int lane) const { return mass_[std::size_t(lane)]; }
    double heat_lost_j(int lane) const { return lane_[lane].lost; }
    double heat_released_j(int lane) const { return lane_[lane].released; }
    double work_j(int lane) const { return work_of(lane)[0]; }
    /// Gas torque of one cylinder at the angle just reached, N m.
    double gas_torque_nm(int lane) const { return power_of(lane)[0] - crankcase_pa_ * here(lane).volume_slope; }
    const StepTables &tables() const { return tables_; }
    int step_in_cycle() const { return step_; }
    std::int64_t cycle() const { return cycle_; }
    /// Kinetic energy of the crank (with a dual-mass flywheel: of its primary side), J.
    double energy_j() const { return crank_.energy; }
    /// Dual-mass flywheel: how far the crank is ahead of the secondary mass, rad, and the secondary's speed.
    double flywheel_twist_rad() const { return crank_.twist; }
    double secondary_speed_radps() const { return crank_.secondary; }

  private:
    /// A fired cylinder and its motored twin, side by side in one machine vector.
    typedef double Twins __attribute__((vector_size(2 * sizeof(double))));
    struct Motion {
        double energy, time, twist, secondary;
        double speed, slowness; ///< rad/s and its inverse, which belong to energy and angle.
        double early_slowness;  ///< Before friction and load were corrected: known sooner, and good enough for the walls.
    };
    struct GasTorque { // of all cylinders, crankcase pressure behind the pistons, over a step
        double start, middle, end;
    };
    struct Heat {
        double rate, released, rate_middle; ///< At a step's end: J/rad; J since the cylinder shut. In its middle: J/rad.
    };
    /// Heat over a step, of one joule in all.
    struct BurnPoint {
        double rate, released, rate_middle;
        bool rough; ///< A pulse begins here or did a short while ago: too much of a bend for rules that remember.
    };
    static constexpr int kNeverBurns = INT_MIN;
    struct Burn { // of one lane in one cycle
        std::vector<BurnPoint> points; ///< One a step, from the one in which the first pulse begins.
        int at = kNeverBurns; ///< Which of them the coming step is; below 0 it is that many early.
        int end = 0;          ///< How many there are.
        double heat_j = 0;
        double start_shift_rad = 0, duration_factor = 0; ///< What points are for.
        double from_rad = 0;                             ///< Where the first pulse begins.
    };
    struct Ahead { // slowness within a step, before the step is made
        double middle, end;
    };
    struct Ending { // of a step, before it is certain that the crank gets there
        const CylinderPoint *at_middle, *at_end;
        Twins y[kMaxCylinders];                  ///< As y_.
        Twins work[kMaxCylinders];               ///< What work_ gains.
        Twins middle_sum = {0, 0}, sum = {0, 0}; ///< Of p V' over lanes.
        Heat heat[kMaxCylinders];
        int calm[kMaxCylinders];
        double lost[kMaxCylinders]; ///< Of rough lanes.
        void add(int lane, Twins middle, Twins last) {
            work[lane] = 2 * middle + last;
            middle_sum += middle, sum += last;
        }
    };
    /// A shut cylinder's change of y over a step, and its differences of first to third order backwards; the same of what its
    /// fired twin loses to the walls, J.
    struct Course {
        Twins change, first, second, third;
        double loss, loss_first, loss_second;
    };

    // engine_step.cpp, in the order of a step.
    Ahead look_ahead() const;
    void step_lanes(Ending &end) const;
    void step_shut(int lane, Ending &end) const;
    void step_rough(int lane, const Ahead &ahead, Ending &end) const;
    void step_open(int lane, Ending &end) const;
    bool turn(const GasTorque &gas, Motion &to) const;
    bool turn_free(const GasTorque &gas, Motion &to) const;
    bool turn_with_flywheel(const GasTorque &gas, Motion &to) const;
    bool turn_prescribed(Motion &to) const;
    Motion flywheel_slope(int half, double gas_nm, const Motion &at) const;
    void find_heat(int lane, Ending &end) const;
    Twins settle(int lane, const Ending &end);
    Twins change_at(const CylinderPoint &point, int lane, Twins y, double slowness, double heat_rate, double &loss) const;
    double friction_nm(double speed) const { return friction_nm_[0] + speed * (friction_nm_[1] + speed * friction_nm_[2]); }
    double load_nm(double time_s) const { return load_nm_ + load_slope_ * (time_s - load_time_); }
    bool stands_still(double energy) const;
    int end_point() const { return step_ + 1 == tables_.steps ? 0 : 2 * step_ + 2; }
    void find_change(int lane);
    Twins power_here() const;
    void update_truth(Twins gas);

    // engine_model.cpp
    void sort_lanes();
    void evaluate_here();
    void take_events();
    void point_at_next_event();
    void apply(const Event &event);
    void shut(int lane);
    void finish_cycle(int lane);
    double volume(int lane) const { return tables_.volume_m3(2 * step_, lane); }
    void lay_burn(int lane, const Charge &charge);
    double theta(int half, int lane) const;
    const CylinderPoint &here(int lane) const { return tables_.row(2 * step_)[lane]; }
    Twins pressure_of(int lane) const { return shut_[lane] ? lane_[lane].y * here(lane).pressure : lane_[lane].y; }
    Twins power_of(int lane) const { return lane_[lane].y * (shut_[lane] ? here(lane).push : here(lane).volume_slope); }
    Twins work_of(int lane) const { return (lane_[lane].work - 0.5 * power_of(lane)) * (tables_.step_rad / 3); }
    double work_of_fuel_j(int lane) const { return work_of(lane)[0] - work_of(lane)[1]; }

    StepTables tables_;
    int n_;
    std::vector<int> physical_;
    std::vector<PulseShape> pulse_shapes_;
    double crankcase_pa_, exhaust_pa_, charge_k_, exchange_, heating_value_, stoichiometric_, wall_k_,
        wall_factor_;
    std::array<double, 3> cv_; // c_v/R over temperature, PlantEngine::gas_cv_over_r
    double stroke_m_, displacement_m3_; // of one cylinder
    double friction_nm_[3];             // of speed in rad/s
    std::optional<DualMassFlywheel> dual_mass_;
    double secondary_inertia_;
    double stall_j_; ///< Below this energy the engine counts as stalled.
    double stay_[2]; ///< What is left of an open cylinder's distance from its manifold after half a step and a step.

    std::int64_t cycle_ = 0;
    int step_ = 0;
    std::size_t first_event_ = 0, next_event_ = 0; ///< Of those at this step.
    int next_event_step_ = -1;                    ///< -1: none in this cycle.
    Motion crank_{};
    double friction_and_load_nm_ = 0;               ///< Here.
    double gas_before_nm_ = 0, load_before_nm_ = 0; ///< Gas torque, and friction and load, a step ago.
    struct Lane {
        Twins y = {0, 0};    ///< Open: p, Pa; shut: p V^k.
        Twins work = {0, 0}; ///< J over a third of a step, more than work by half of p V' here.
        Course course{};     ///< Of a shut one, like all below.
        double wall_factor = 0, inverse_mr = 0;
        double heat = 0, released = 0; ///< J/rad; J, of the cycle under way.
        double lost = 0;               ///< J, to the walls of the fired twin.
        double peak = 0;               ///< Pa, of the cycle under way.
        double manifold = 0;           ///< Pa; of an open one.
        double wall_gain = 0;          ///< wall_factor without wall_speed_.
        int calm = 0;                  ///< Steps since the change last had a kink; differences up to that order are good.
        Burn burn;
    };
    static constexpr int kCalm = 3;
    Lane lane_[kMaxCylinders];
    // Per lane, for both twins alike.
    bool shut_[kMaxCylinders] = {};
    int lanes_[kMaxCylinders] = {}; // those with shut valves first
    int shut_count_ = 0;
    std::array<double, kMaxCylinders> intake_pa_{}, mass_{};
    std::array<bool, kMaxCylinders> inhaling_{}; // from the exchange to intake closing
    double load_nm_ = 0, load_slope_ = 0, load_time_ = 0;
    bool prescribed_ = false;
    double speed0_ = 0, speed_slope_ = 0, speed_time_ = 0;
    double wall_speed_ = 0;

    StepTruth truths_[2];
    int latest_ = 0;
    std::array<CycleTruth, kMaxCylinders> running_{}, finished_{};
    std::array<double, kMaxCylinders> work_at_tdc_{};
};

} // namespace sixdeg
