/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
/// sd_signals.h - every signal that leaves the ecu and every parameter that enters it.
#ifndef SD_SIGNALS_H
#define SD_SIGNALS_H
#include <stddef.h>
#include <stdint.h>

/// Changes whenever the table does; calibration pages and logs carry it.
#define SD_SIGNALS_SIGNATURE 0xde03c007u

/// Channel of an SD_EVENT_SAMPLE.
typedef enum sd_input {
    SD_INPUT_AIR_INTAKE_PRESSURE = 0, ///< Absolute pressure in the intake manifold. [bar]
    SD_INPUT_FUEL_INJECTED = 1, ///< The controller's own command, a stroke and cylinder; 0 in fuel cut. [mg]
    SD_INPUT_EXHAUST_LAMBDA = 2, ///< Air to fuel, over stoichiometric, as the wide-range oxygen sensor (UEGO) reads it. [-]
    SD_INPUT_EXHAUST_PRESSURE = 3, ///< Absolute pressure in the exhaust manifold. [bar]
} sd_input_t;
#define SD_INPUT_COUNT 4u

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
    SD_SIGNAL_CYCLE_CYLINDER_SD = 17, ///< Standard deviation of cycle.cylinder_torque from errors of the tooth times (torque.tooth_sd, timer); errors of the engine model are not in it. [Nm, 8 channels]
} sd_signal_t;
#define SD_SIGNAL_COUNT 25u

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
} sd_signals_t;

/// Parameters of the working page; names, ranges and defaults in sd_parameter_infos.
typedef struct sd_parameters {
    float crank_stall_s; ///< Longest time between two edges; beyond it the engine stands still.
    float torque_harmonics; ///< n_h, harmonics of the cycle in the torque estimate; 0: 5, or as many as cylinders where these are more.
    float torque_gain_energy_per_rad; ///< L_ke, how fast the kinetic energy follows its measurement.
    float torque_gain_mean_per_rad2; ///< L_a0, adaptation of the mean torque.
    float torque_gain_reference_per_rad2; ///< L_ref; harmonic i adapts with i L_ref. `sixdeg calibrate` refuses a set that does not converge.
    float torque_reject_energy; ///< Share of the kinetic energy by which a tooth may miss its prediction before it is left out.
    float torque_settle_cycles; ///< Cycles after a start during which the estimate is flagged as converging.
    float torque_tooth_sd_deg; ///< Random error of a tooth edge, standard deviation, beside the timer's rounding; scales cycle.cylinder_sd.
    float torque_speed_base_rpm; ///< Highest speed; base of the fixed-point variant.
    float torque_torque_base_nm; ///< Highest instantaneous torque, beyond which the observer starts anew; base of the fixed-point variant; 0: 40 bar times a cylinder's displacement.
    float torque_fixed_point; ///< 1 runs the q31 variant, 0 the float one.
} sd_parameters_t;
#define SD_PARAMETER_COUNT 11u

typedef enum sd_rate { SD_RATE_EDGE, SD_RATE_CYCLE } sd_rate_t;
typedef enum sd_owner { SD_OWNER_CRANK, SD_OWNER_TORQUE, SD_OWNER_CYLINDER, SD_OWNER_COUNT } sd_owner_t;

/// One row of the table. `value` is the default of a parameter.
typedef struct sd_signal_info {
    const char *name, *unit;
    float low, high, value;
    uint8_t rate, owner;
} sd_signal_info_t;

extern const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT];       ///< By channel; an array has a row an element.
extern const sd_signal_info_t sd_input_infos[SD_INPUT_COUNT];         ///< By channel; rate and owner say nothing.
extern const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT]; ///< In the order of sd_parameters_t.

#endif
