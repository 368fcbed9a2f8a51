/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
/// sd_signals.h - every signal that leaves the ecu and every parameter that enters it.
#ifndef SD_SIGNALS_H
#define SD_SIGNALS_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Changes whenever the table does; calibration pages and logs carry it.
#define SD_SIGNALS_SIGNATURE 0x4ebd0fd3u

/// Channel of an SD_EVENT_SAMPLE.
typedef enum sd_input {
    SD_INPUT_AIR_INTAKE_PRESSURE = 0, ///< Absolute pressure in the intake manifold. [bar]
    SD_INPUT_FUEL_INJECTED = 1, ///< The controller's own command, a stroke and cylinder; 0 in fuel cut. [mg]
    SD_INPUT_FUEL_LEVEL = 2, ///< How full the tank is; needed only for the misfire monitor to keep silent on a nearly empty one. [%]
    SD_INPUT_DRIVELINE_SHIFT = 3, ///< 1: the controller or the gearbox shifts gear. [-]
    SD_INPUT_EXHAUST_LAMBDA = 4, ///< Air to fuel, over stoichiometric, as the wide-range oxygen sensor (UEGO) reads it. [-]
    SD_INPUT_EXHAUST_PRESSURE = 5, ///< Absolute pressure in the exhaust manifold. [bar]
    SD_INPUT_EXHAUST_TEMPERATURE = 6, ///< Of the gas in the exhaust manifold. Not known: as calibrated at the operating point. [K]
    SD_INPUT_EXHAUST_VANES = 7, ///< Area between the vanes of a variable turbine (VGT), over the calibration's. [-]
    SD_INPUT_EXHAUST_TURBINE_SPEED = 8, ///< Of the turbocharger. Not known: as calibrated; see afr.turbine_drop. [rpm]
    SD_INPUT_BALANCE_ENABLE = 9, ///< Above 0.5 the trims learn; otherwise, and while nothing is said, they are 0. [-]
    SD_INPUT_AIR_FLOW = 10, ///< Fresh air into the intake, as the hot-film meter before the compressor reads it. [g/s]
    SD_INPUT_AIR_CHARGE_TEMPERATURE = 11, ///< Of the air behind the charge-air cooler. [K]
    SD_INPUT_EGR_TEMPERATURE = 12, ///< Of the recirculated exhaust gas behind its cooler. [K]
    SD_INPUT_EGR_COMMAND = 13, ///< Commanded opening of the exhaust gas recirculation valve (EGR): 0 closed, 1 open. [-]
    SD_INPUT_EGR_POSITION = 14, ///< The same as its position sensor reads it. [-]
    SD_INPUT_VGT_COMMAND = 15, ///< Commanded position of the turbine's vanes (VGT): 0 closed, 1 open. [-]
    SD_INPUT_VGT_POSITION = 16, ///< The same as its position sensor reads it. [-]
    SD_INPUT_DRIVELINE_GEAR = 17, ///< Gear that is in with the clutch closed, 1 the first of the engine file; 0: none is, or the clutch is open or slips. [-]
} sd_input_t;
#define SD_INPUT_COUNT 18u

/// Channel of an SD_EVENT_SIGNAL.
typedef enum sd_signal {
    SD_SIGNAL_CRANK_EDGE_CLASS = 0, ///< What became of the edge: 0 tooth, 1 coasted (a tooth after missing ones), 2 spurious, 3 unsynced. [-]
    SD_SIGNAL_CRANK_TOOTH = 1, ///< Tooth position, missing ones counted, 0 = first tooth after the mark. [-]
    SD_SIGNAL_CRANK_ANGLE = 2, ///< Crank angle of the edge; 0 = firing TDC of the first cylinder in firing order. Without a cam edge the revolution is a guess: see phase_known. [deg]
    SD_SIGNAL_CRANK_PHASE_KNOWN = 3, ///< 1: cam edges have told which of the two revolutions of the cycle this is. [-]
    SD_SIGNAL_CRANK_SPEED = 4, ///< Speed over the period since the last placed edge; a mark counts with its learned width. [rpm]
    SD_SIGNAL_CRANK_ACCELERATION = 5, ///< Angular acceleration from the decoder's leading clock. [rad/s2]
    SD_SIGNAL_TORQUE_MASS = 6, ///< Adaptive Fourier estimate at the tooth: combustion torque less load and friction (document 004, equation 2). [Nm]
    SD_SIGNAL_TORQUE_INNOVATION = 7, ///< Measured less predicted kinetic energy at the last corrected tooth. [J]
    SD_SIGNAL_CYCLE_SPEED = 8, ///< Mean speed of the cycle just ended. [rpm]
    SD_SIGNAL_CYCLE_CYLINDER_TORQUE = 9, ///< Combustion torque of a cylinder over the 180 deg after its TDC, mean of the last cycles, by physical number; from the harmonics, the known pulse shape and the intake pressure. [Nm, 8 channels]
    SD_SIGNAL_CYCLE_CYLINDER_SD = 17, ///< Standard deviation of cycle.cylinder_torque from errors of the tooth times (torque.edge_sd, timer); errors of the engine model are not in it. [Nm, 8 channels]
    SD_SIGNAL_FIRING_WAVEFORM = 25, ///< Torque at the tooth from the filter on tooth times: combustion and motored torque less load. [Nm]
    SD_SIGNAL_WHEEL_PATTERN_SD = 26, ///< Standard deviation of the learned error of a tooth; 0: nothing learned. [deg]
    SD_SIGNAL_WHEEL_LEARNED_CYCLES = 27, ///< Motored cycles the tooth pattern was learned from. [-]
    SD_SIGNAL_FIRING_CYLINDER = 28, ///< Physical cylinder of the firing read. [-]
    SD_SIGNAL_FIRING_TORQUE = 29, ///< Its mean combustion torque over the 180 deg after its TDC. [Nm]
    SD_SIGNAL_FIRING_SD = 30, ///< Standard deviation of firing.torque less the mean of all cylinders, from timing noise as met. [Nm]
    SD_SIGNAL_FIRING_MEAN = 31, ///< Mean of the cylinder's last 10 firings. [Nm]
    SD_SIGNAL_FIRING_MEAN_SD = 32, ///< Standard deviation of firing.mean less that of all cylinders: of the imbalance. [Nm]
    SD_SIGNAL_FIRING_ROUGH = 33, ///< 1: the road is rough, and all of firing comes from the filter whose gains let the load move. [-]
    SD_SIGNAL_WORK_CYCLE = 34, ///< Kinetic energy that the crank has gained over the last 720 deg: indicated work of all cylinders less that of load and friction, so about 0 in steady running. Less its own mean, how far the indicated work is from its mean while the load stays. In proportion to the inertia. [J]
    SD_SIGNAL_WORK_SD = 35, ///< Standard deviation of work.cycle from errors of the tooth times (torque.edge_sd, timer); an error of the inertia is not in it. Of work.change 1.4 times as much. [J]
    SD_SIGNAL_WORK_CHANGE = 36, ///< work.cycle less that of the firing before: how much more work this firing did than the same cylinder's firing a cycle earlier. 0 where not known. [J]
    SD_SIGNAL_WORK_FIRING = 37, ///< Which firing of the firing order the stretch of teeth lies behind, from 0. [-]
    SD_SIGNAL_WORK_CYLINDER = 38, ///< Physical cylinder whose own work.change is; 0: not known, or firings are so close that over a tenth of it is another's. [-]
    SD_SIGNAL_AFR_CYLINDER_BURNED = 39, ///< Burned share of each cylinder's exhaust gas, by physical number: lambda = 1 - air/gas of document 004, above 1 where air is missing. [-, 8 channels]
    SD_SIGNAL_AFR_CYLINDER_SD = 47, ///< Standard deviation of a cylinder's deviation from the mean, over the mean: as the filter states it; of the chain, what it scatters by. [-, 8 channels]
    SD_SIGNAL_AFR_SLOW = 55, ///< 1: the sensor is too slow for this speed; the filter learns over some tens of seconds, the chain stays degraded. [-]
    SD_SIGNAL_AFR_LATE = 56, ///< How much later than calibrated the gas reaches the lambda sensor, as learned from the trims. [s]
    SD_SIGNAL_AFR_LATE_SD = 57, ///< Its standard deviation; 0.01 before anything was learned. [s]
    SD_SIGNAL_AFR_LAG = 58, ///< By what share the lambda sensor's lags are longer than calibrated, as learned from a probe. [-]
    SD_SIGNAL_AFR_PROBING = 59, ///< 1: a trim on one cylinder asks the sensor for its delay. [-]
    SD_SIGNAL_BALANCE_TRIM = 60, ///< Fuel to add to each cylinder, over its nominal, by physical number; their mean is 0. [-, 8 channels]
    SD_SIGNAL_MISFIRE_INDEX = 68, ///< Work of the firing over the work expected of its fuel, by the method that judges: 1 healthy, 0 a misfire; 0 when not judged. [-]
    SD_SIGNAL_MISFIRE_LIMIT = 69, ///< Index below which this firing counted as a misfire; 0 when not judged. [-]
    SD_SIGNAL_MISFIRE_VERDICT = 70, ///< 0 healthy, 1 partial burn (the monitor only), 2 misfire, 3 not judged; of the method that judges. [-]
    SD_SIGNAL_MISFIRE_INHIBIT = 71, ///< Why not judged, bits: 1 start, 2 fuel cut or too little fuel, 4 gear shift, 8 no estimate, 16 fuel cut or shift ended a moment ago, 32 a faulty tooth or unknown fuel, 64 the tank is nearly empty. [-]
    SD_SIGNAL_MISFIRE_FIRING = 72, ///< Which firing of the firing order, from 0. [-]
    SD_SIGNAL_MISFIRE_CYLINDER = 73, ///< Its physical cylinder. [-]
    SD_SIGNAL_MISFIRE_MONITOR = 74, ///< The monitor's own verdict, whatever misfire.method is; 3 where the filter on tooth times rests. [-]
    SD_SIGNAL_MISFIRE_ACCELERATION = 75, ///< Angular acceleration of the crank by document 000's observer, mean from the firing's TDC to the next one; 0 when not judged, and with method 0. [rad/s2]
    SD_SIGNAL_MISFIRE_RESIDUAL = 76, ///< The same less what the commanded fuel should give against the load as learned: what the firing lacks. [rad/s2]
    SD_SIGNAL_MISFIRE_RATE_200 = 77, ///< Misfires of the cylinder in the last complete window of 200 judged revolutions, of its firings. [%, 8 channels]
    SD_SIGNAL_MISFIRE_RATE_1000 = 85, ///< The same in 1000. [%, 8 channels]
    SD_SIGNAL_MISFIRE_CONTINUOUS = 93, ///< Bit n - 1: cylinder n misfires each time. [-]
    SD_SIGNAL_MISFIRE_SUSPECTS = 94, ///< Bit n - 1: cylinder n had over a tenth of the misfires of the window that moved the lamp. [-]
    SD_SIGNAL_MISFIRE_LAMP = 95, ///< Decision in the shape of OBD II, not verified against it: 0 off, 1 pending, 2 on, 3 blinking. [-]
    SD_SIGNAL_MISFIRE_COUNT = 96, ///< Misfires since init. [-]
    SD_SIGNAL_MISFIRE_PARTIAL_BURNS = 97, ///< Partial burns since init. [-]
    SD_SIGNAL_AIRPATH_RESIDUAL = 98, ///< Residuals without the learned offset: 1 sees the turbine's vanes and not the EGR valve, 2 the valve and not the vanes. [kPa, 2 channels]
    SD_SIGNAL_AIRPATH_DECISION = 100, ///< Decision functions of an EGR valve that is further open than it says and further closed, of vanes further closed and further open; above 0 it is named. [-, 4 channels]
    SD_SIGNAL_AIRPATH_FAULT = 104, ///< 0 none, 1 the EGR valve, 2 the turbine's vanes, 3 both residuals at once: both actuators, or something else. [-]
    SD_SIGNAL_AIRPATH_SINCE = 105, ///< Time since the most likely beginning of the fault that is named. [s]
    SD_SIGNAL_AIRPATH_PHASE = 106, ///< 0 waits for its inputs, 1 settles, 2 learns the residuals' offsets, 3 decides. [-]
    SD_SIGNAL_AIRPATH_OFFSET = 107, ///< Learned offset of each residual, over what a fault of 0.05 leaves in it. From 0.5 on, a fault that was there at the start may have been learned. [-, 2 channels]
    SD_SIGNAL_AIRPATH_TRACKING = 109, ///< Actuators whose position does not follow its command, bits: 1 the EGR valve, 2 the turbine's vanes. [-]
    SD_SIGNAL_INPUTS_STALE = 110, ///< Inputs read once whose last reading is older than it counts: bit i of element n is input 16 (n - 1) + i. [-, 2 channels]
    SD_SIGNAL_INPUTS_MISSING = 112, ///< The same of inputs never read. [-, 2 channels]
    SD_SIGNAL_DRIVELINE_LOCATION = 114, ///< Where the shaft is: 1 wound up backward and stiff, 2 soft, 3 wound up forward and stiff; 0: not known. [-]
    SD_SIGNAL_DRIVELINE_TORSION = 115, ///< Torsion of the shaft, at the wheels. [rad]
    SD_SIGNAL_DRIVELINE_WINDING = 116, ///< Rate of the torsion. [rad/s]
    SD_SIGNAL_DRIVELINE_SHAFT = 117, ///< Torque of the shaft, spring and damping, at the crank. [Nm]
    SD_SIGNAL_DRIVELINE_WHEEL_SPEED = 118, ///< Speed of the driven wheels, as the filter has it. [rad/s]
    SD_SIGNAL_DRIVELINE_BIAS = 119, ///< What the engine's torque is believed to lack, at the crank. [Nm]
    SD_SIGNAL_DRIVELINE_MOVING = 120, ///< 1: the shaft winds or unwinds fast, or did within the last quarter of a second. Firings and misfires are judged by it. [-]
    SD_SIGNAL_DRIVELINE_DAMPING_REQUEST = 121, ///< Torque at the crank to be added to what the driver wants, so that the swing dies out; 0 unless driveline.damping is 1. [Nm]
    SD_SIGNAL_DRIVELINE_REFERENCE_LOCATION = 122, ///< Location by document 003's identification; 0: it rests. [-]
    SD_SIGNAL_DRIVELINE_REFERENCE_TORSION = 123, ///< Torsion by its continuous observer. [rad]
    SD_SIGNAL_DRIVELINE_REFERENCE_RESIDUAL = 124, ///< Residual of location n. [rpm, 3 channels]
} sd_signal_t;
#define SD_SIGNAL_COUNT 127u

/// Present values, in channel order.
typedef struct sd_signals {
    float crank_edge_class;
    float crank_tooth;
    float crank_angle_deg;
    float crank_phase_known;
    float crank_speed_rpm;
    float crank_acceleration_radps2;
    float torque_mass_nm;
    float torque_innovation_j;
    float cycle_speed_rpm;
    float cycle_cylinder_torque_nm[8];
    float cycle_cylinder_sd_nm[8];
    float firing_waveform_nm;
    float wheel_pattern_sd_deg;
    float wheel_learned_cycles;
    float firing_cylinder;
    float firing_torque_nm;
    float firing_sd_nm;
    float firing_mean_nm;
    float firing_mean_sd_nm;
    float firing_rough;
    float work_cycle_j;
    float work_sd_j;
    float work_change_j;
    float work_firing;
    float work_cylinder;
    float afr_cylinder_burned[8];
    float afr_cylinder_sd[8];
    float afr_slow;
    float afr_late_s;
    float afr_late_sd_s;
    float afr_lag;
    float afr_probing;
    float balance_trim[8];
    float misfire_index;
    float misfire_limit;
    float misfire_verdict;
    float misfire_inhibit;
    float misfire_firing;
    float misfire_cylinder;
    float misfire_monitor;
    float misfire_acceleration_radps2;
    float misfire_residual_radps2;
    float misfire_rate_200_percent[8];
    float misfire_rate_1000_percent[8];
    float misfire_continuous;
    float misfire_suspects;
    float misfire_lamp;
    float misfire_count;
    float misfire_partial_burns;
    float airpath_residual_kpa[2];
    float airpath_decision[4];
    float airpath_fault;
    float airpath_since_s;
    float airpath_phase;
    float airpath_offset[2];
    float airpath_tracking;
    float inputs_stale[2];
    float inputs_missing[2];
    float driveline_location;
    float driveline_torsion_rad;
    float driveline_winding_radps;
    float driveline_shaft_nm;
    float driveline_wheel_speed_radps;
    float driveline_bias_nm;
    float driveline_moving;
    float driveline_damping_request_nm;
    float driveline_reference_location;
    float driveline_reference_torsion_rad;
    float driveline_reference_residual_rpm[3];
} sd_signals_t;

/// Parameters of the working page; names, ranges and defaults in sd_parameter_infos.
typedef struct sd_parameters {
    float crank_stall_time_s; ///< Longest time between two edges; beyond it the engine stands still.
    float torque_harmonics; ///< n_h, harmonics of the cycle in the torque estimate; 0: 5, or as many as cylinders where these are more.
    float torque_gain_energy_per_rad; ///< L_ke, how fast the kinetic energy follows its measurement.
    float torque_gain_mean_per_rad2; ///< L_a0, adaptation of the mean torque.
    float torque_gain_reference_per_rad2; ///< L_ref; harmonic i adapts with i L_ref. `sixdeg calibrate` refuses a set that does not converge.
    float torque_reject_energy_share; ///< Share of the kinetic energy by which a tooth may miss its prediction before it is left out.
    float torque_settle_cycles; ///< Cycles after a start during which the estimate is flagged as converging.
    float torque_edge_sd_deg; ///< Random error of a tooth edge, standard deviation, beside the timer's rounding; scales cycle.cylinder_sd and work.sd.
    float torque_speed_base_rpm; ///< Highest speed; base of the fixed-point variant.
    float torque_torque_base_nm; ///< Highest instantaneous torque, beyond which the observer starts anew; base of the fixed-point variant; 0: 40 bar times a cylinder's displacement.
    float torque_fixed_point; ///< 1 runs the q31 variant, 0 the float one.
    float work_window_deg; ///< Longest stretch of teeth behind a firing over which the crank's energy is read. 0: from the firing's exhaust to the next compression, and 60 deg where these are not apart.
    float firing_enabled; ///< 1 runs the filter on tooth times beside the Fourier observer; it needs the engine file's heat release.
    float firing_harmonics; ///< 0: the filter's basis is the known pulse of each cylinder. Otherwise harmonics of the cycle: a waveform, but no single firings.
    float firing_edge_sd_deg; ///< Timing error of an edge that the gains are made for, the timer's rounding not included.
    float firing_pattern_sd_deg; ///< Standard deviation of a tooth's own error while it is not learned.
    float firing_load_walk_nm; ///< Change of load and friction from tooth to tooth.
    float firing_rough_walk_nm; ///< The same on rough roads: of the second filter, which is used when the two disagree. 0: there is none.
    float firing_torque_change_nm; ///< Change of a cylinder's torque from one firing to the next.
    float firing_shape_walk_nm; ///< Change from tooth to tooth of the pulses' shape, times the mean torque. 0: the calibration's shape is kept.
    float firing_reject_lateness_deg; ///< Lateness of a tooth beyond which it is left out, besides what torque.torque_base explains.
    float firing_settle_cycles; ///< Cycles after a start during which firings are flagged as converging.
    float misfire_work_per_fuel_jpmg; ///< Work of combustion that a healthy firing is expected to give; each cylinder learns its own within 0.6 to 1.5 of it.
    float misfire_cyclic_variation; ///< Largest usual cyclic variation: standard deviation of a healthy firing's work over its mean. Scatter beyond it counts as disturbance.
    float misfire_z_false; ///< Wanted distance of a healthy firing from the limit, in standard deviations; 3.54 is 2 false alarms in 10,000.
    float misfire_z_missed; ///< The same of a misfire; 2.58 is 5 of 1000 overlooked.
    float misfire_misfire_below; ///< Share of the expected work below which a firing is a misfire, where noise leaves the choice.
    float misfire_partial_burn_below; ///< Share of the expected work below which a firing is a partial burn; never below misfire.misfire_below.
    float misfire_fuel_min_mg; ///< Commanded fuel a stroke below which nothing is judged.
    float misfire_fuel_level_min_percent; ///< Tank level below which nothing is judged: an empty line misfires without a fault of the engine's. Unknown levels pass.
    float misfire_torque_min_nm; ///< Expected mean torque below which nothing is judged.
    float misfire_shift_speed_change; ///< Change of speed from one firing to the next, beyond what a missing firing does, that only a shift makes. A gentle shift is below it.
    float misfire_start_inhibit_cycles; ///< Not judged after a start, beyond the estimate's own settling.
    float misfire_resume_inhibit_cycles; ///< Not judged after fuel cut or a gear shift.
    float misfire_continuous_firings; ///< Misfires of a cylinder in a row that make it continuous.
    float misfire_emission_percent; ///< Misfires in 1000 revolutions, of all firings, that count against emissions.
    float misfire_catalyst_percent; ///< Misfires in 200 revolutions that harm the catalyst.
    float misfire_emission_windows; ///< Windows of 1000 over the limit that light the lamp; one is enough in the first.
    float misfire_catalyst_windows; ///< Windows of 200 over the limit that make it blink.
    float misfire_method; ///< Whose verdict counts, for rates, lamp and trims: 0 the monitor's; document 000's observers 1 FOLSMO, 2 FOSMO, 3 ROO, which need the engine file's heat release.
    float misfire_arithmetic; ///< Of document 000's observers: 0 single precision, 1 fixed point (q31).
    float afr_method; ///< 1 joint filter; document 004's chain with the sensor inverted 2 as oscillators, gains from the page, 3 by its adaptive Fourier law.
    float afr_arithmetic; ///< Of the chain: 0 f32, 1 q31. The joint filter has f32 only.
    float afr_gain_mass; ///< L1 of the chain: of the manifold's gas towards exhaust.pressure, a position with a reading. 0: the pressure is not used.
    float afr_turbine_drop; ///< Share of its area that the turbine loses from standstill to afr.turbine_rated, with the square of exhaust.turbine_speed. 0: it is not used.
    float afr_turbine_rated_rpm; ///< Speed of the turbocharger at which the calibrated turbine area holds.
    float afr_gain_air; ///< L2 of the chain: of the manifold's air, a position.
    float afr_gain_cylinder; ///< L_cyl of the chain: of the cylinders, over the charge squared.
    float afr_inversion_gain; ///< g of the chain's Fourier law, a position.
    float afr_inversion_floor; ///< rho of the chain's Fourier law: responses of the sensor below it are not inverted in full.
    float afr_sensor_noise; ///< Density of the lambda sensor's noise, of burned share over sqrt(Hz), one-sided: what the filter expects.
    float afr_cylinder_drift; ///< q: how far a cylinder is expected to move in one cycle, of the mean burned share. Larger is noisier; steps are for afr.cylinder_jump.
    float afr_cylinder_jump; ///< How far a cylinder may have moved where innovations keep to one side, of the mean burned share. 0: steps are followed by drift alone.
    float afr_cylinder_drift_slow; ///< The same in slow mode.
    float afr_slow_mode_above; ///< Slow mode where crank speed (rad/s) times the sum of the sensor's lags (s) is above this.
    float afr_stoichiometric; ///< Air to fuel of the fuel in use.
    float afr_delay_learning; ///< Delay of the lambda sensor: 0 as calibrated, 1 learned from what the trims do, 2 also by a probe where trims are allowed and it is not known to 10 deg crank, or trims had to be given up.
    float afr_delay_probe; ///< Size of the probe: fuel trim on one cylinder.
    float afr_delay_error_sd_s; ///< Standard deviation of the calibrated delay to the lambda sensor until better is learned; goes into afr.cylinder_sd. 10 deg crank either way at 1500 rpm is 0.0006.
    float afr_lag_error_sd; ///< The same of the sensor's lags, as a share; 20 % either way is 0.115.
    float balance_source; ///< 0 no trims, 1 from afr.cylinder_burned, 2 from firing.torque; no trims follow a misfire.
    float balance_integral_gain; ///< Of the deviation, taken off the trim each cycle.
    float balance_proportional_gain; ///< P of a PI law, as in document 004: of the deviation's change in a cycle, taken off the trim. 0: an integrator.
    float balance_trim_rate; ///< Largest change of a trim in a cycle.
    float balance_trim_limit; ///< Largest trim.
    float balance_sd_max; ///< Stated standard deviation of a deviation above which nothing is learned.
    float balance_hold_cycles; ///< How long trims hold after a transient or an estimate that is not valid.
    float airpath_detect_threshold; ///< Threshold of detection; what it means in false alarms: docs/theory/airpath.md.
    float airpath_isolate_threshold; ///< Threshold by which the named fault must be ahead of any other.
    float airpath_settle_time_s; ///< Time for which the observers settle after a start, or after an input was missing.
    float airpath_offset_window_s; ///< Time in which the residuals' offsets are learned after a start; 0: they are taken to be 0.
    float airpath_late_after_s; ///< Age of a reading from which on decisions rest until the next one comes.
    float airpath_stuck_after_s; ///< Time for which a pressure or the air flow may read the same to the last bit before its sensor counts as stuck; decisions rest meanwhile.
    float airpath_tracking; ///< Distance of a position from its command, for half a second on average, that is said as not tracking.
    float airpath_arithmetic; ///< Of the diagnosis: 0 single precision, 1 fixed point (q31). Another one begins anew.
    float driveline_damping; ///< 1: the damping asks for torque. It needs the engine file's driveline.
    float driveline_damping_gain_nmsprad; ///< Torque at the crank for a rate of torsion.
    float driveline_damping_limit_nm; ///< Largest request either way.
    float driveline_damping_rate_nmps; ///< Fastest change of the request.
    float driveline_damping_drop_nmps; ///< The same on its way to 0, once the estimate is not valid.
} sd_parameters_t;
#define SD_PARAMETER_COUNT 80u

/// What is said together, and when.
typedef enum sd_rate {
    SD_RATE_EDGE = 0, ///< Every crank edge.
    SD_RATE_CYCLE = 1, ///< Every 720 deg. The tick is that of the tooth that ended the cycle; a row may be said over some of the teeth that follow.
    SD_RATE_FIRING = 2, ///< Each firing, 300 deg after its TDC.
    SD_RATE_TASK = 3, ///< Every 10 ms, with the clock event, whether the engine turns or not.
    SD_RATE_AIRPATH = 4, ///< Every 10 ms, with the clock event, of a page with an air path.
    SD_RATE_DRIVELINE = 5, ///< Every 10 ms, with the clock event, where the page has a driveline.
    SD_RATE_WORK = 6, ///< Each firing, at the end of the stretch of teeth over which the crank's energy is read, mostly some 195 deg after its TDC.
} sd_rate_t;
#define SD_RATE_COUNT 7u

/// Whose health comes with a value.
typedef enum sd_owner {
    SD_OWNER_CRANK = 0, ///< The crank decoder: angle, speed, and the wheel's pattern.
    SD_OWNER_TORQUE = 1, ///< The Fourier observer of the torque.
    SD_OWNER_CYLINDER = 2, ///< Torque of each cylinder, from the harmonics.
    SD_OWNER_FIRING = 3, ///< The filter on tooth times: torque of each firing.
    SD_OWNER_WORK = 4, ///< Work of a cycle, from the crank's energy at the same teeth a cycle apart. Invalid without a phase, but where the engine fires at the same angles a revolution later: there degraded.
    SD_OWNER_MISFIRE = 5, ///< The misfire monitor. A firing whose fuel is unknown is not judged; a tank or a gearbox that says nothing forbids nothing.
    SD_OWNER_AFR = 6, ///< Mixture of each cylinder, from the lambda sensor.
    SD_OWNER_BALANCE = 7, ///< Trims of the fuel. They hold while the estimate that they follow is not valid, whatever it lacks.
    SD_OWNER_AIRPATH = 8, ///< Diagnosis of the EGR valve and of the turbine's vanes, of a page with an air path.
    SD_OWNER_DRIVELINE = 9, ///< The guard filter: torsion of the driveline from crank teeth, and the damping of its swing.
    SD_OWNER_DRIVELINE_REFERENCE = 10, ///< Document 003's observers of the same, which want a speed without noise.
    SD_OWNER_INPUTS = 11, ///< What the ecu knows of its inputs; always valid.
} sd_owner_t;
#define SD_OWNER_COUNT 12u

/// One row of the table. `value` is the default of a parameter.
typedef struct sd_signal_info {
    const char *name, *unit;
    float low, high, value;
    uint8_t rate, owner;
    uint8_t at_start; ///< 1: a parameter that comes with the page and is not set later, since the host makes tables of it.
} sd_signal_info_t;

/// What may come in.
typedef struct sd_input_info {
    const char *name, *unit;
    float low, high;
    float usual; ///< Stands in for a reading where none counts.
    float age_s; ///< For how long a reading counts, up to 10; 0: for ever.
} sd_input_info_t;

/// Who says values. Bit i of a mask is input i.
typedef struct sd_owner_info {
    const char *name;
    uint32_t degraded_without; ///< While one of these has no reading that counts, its values are no better than degraded,
    uint32_t invalid_without;  ///< and while one of these has none, invalid.
} sd_owner_info_t;

/// What is said together.
typedef struct sd_rate_info {
    const char *name;
    float period_s;           ///< 0: when the crank says so.
    const uint16_t *channels; ///< Of its signals, ascending,
    const uint8_t *owners;    ///< the sd_owner_t of each,
    uint32_t count;           ///< and how many; at least 1.
} sd_rate_info_t;

extern const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT];       ///< By channel; an array has a row an element.
extern const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT]; ///< In the order of sd_parameters_t.
extern const sd_input_info_t  sd_input_infos[SD_INPUT_COUNT];         ///< By channel.
extern const sd_owner_info_t  sd_owner_infos[SD_OWNER_COUNT];
extern const sd_rate_info_t   sd_rate_infos[SD_RATE_COUNT];

#ifdef __cplusplus
}
#endif

#endif
