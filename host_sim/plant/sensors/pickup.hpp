// SPDX-License-Identifier: MIT
// From a tooth's true passing to what a capture timer sees: lag, jitter, lost and false edges, ticks.
#pragma once
#include <cstdint>
#include <vector>

#include "common/profile.hpp"
#include "common/random.hpp"

namespace sixdeg {

/// Imperfections of sensor, wheel and timer; all zero is an ideal sensor. Field by field: docs/reference/scenario.md,
/// [encoder].
struct EncoderFaults {
    double offset_deg = 0; ///< Wheel turned on the shaft; edges come at larger crank angles when positive.
    double pattern_rms_deg = 0; ///< Fixed error of each tooth, drawn once from the seed.
    double tooth_width = 0.5;   ///< Of the pitch; matters when the crank turns backward.
    double jitter_deg = 0;      ///< Random error of each edge, normal, standard deviation, cut at 4 of them.
    Profile lag_deg;            ///< Sensor phase over speed in rad/s: edges come this much later.
    double delay_s = 0;         ///< The same as a constant time.
    double drop_rate = 0;       ///< Probability that a run of lost edges begins at an edge.
    double drop_burst = 1;      ///< Mean length of such a run, edges (geometric).
    double extra_rate = 0;      ///< Probability that a run of false edges begins before an edge.
    double extra_burst = 1;     ///< Mean length of such a run, edges (geometric), all before the same edge.
    Profile cam_retard_deg;     ///< Cam phaser over time in s: the cam edge comes this much later.
    double cam_jitter_deg = 0;  ///< Like jitter_deg, for the cam edge.
    double cam_drop_rate = 0;   ///< Probability that a cam edge is lost.
};

enum class EdgeKind : std::uint8_t { crank, cam };

/// One edge at the timer's input, and the truth about it, which no firmware may see.
struct EncoderEdge {
    double time_s = 0;      ///< Before quantisation.
    std::uint32_t tick = 0; ///< floor(time x tick_hz) modulo 2^32: what the capture register holds.
    EdgeKind kind = EdgeKind::crank;

    bool spurious = false; ///< Stands for no tooth.
    bool backward = false; ///< The crank turned backward.
    int tooth = -1;        ///< Wheel position; -1 for a false edge and for the cam.
    double angle_deg = 0;  ///< Crank angle of the tooth's own edge, in [0, 720), pattern and offset included;
                          ///< of a false edge the crank angle at time_s, linearly between its neighbours.
    double speed_radps = 0; ///< Crank speed there, negative when turning backward.
    double combustion_torque_nm = 0, gas_torque_nm = 0,
           net_torque_nm = 0; ///< StepTruth there; 0 without an engine.
};

/// Adds the imperfections and hands edges out in order of time.
class Pickup {
  public:
    Pickup(const EncoderFaults &faults, double tick_hz, std::uint64_t seed);

    /// A true passing at `edge.time_s`, in order of time; fills in tick, and edges before it that should not
    /// be there. Allocates only while its buffers grow to the longest burst.
    void pass(const EncoderEdge &edge);
    /// Takes the next edge that nothing later can overtake; `now_s` is how far passings are known,
    /// `speed_radps` the speed there. False when there is none yet.
    bool take(double now_s, double speed_radps, EncoderEdge &edge);
    /// Takes what is left at the end of a run.
    bool take_rest(EncoderEdge &edge) { return take(kEndOfTime, 1, edge); }
    bool empty() const { return first_ == waiting_.size(); }

  private:
    static constexpr double kEndOfTime = 1e300;
    double lateness_s(const EncoderEdge &edge, double jitter_deg);
    static int run_length(double mean, RandomStream &random);
    void add_false_edges(const EncoderEdge &until);
    void insert(const EncoderEdge &edge);

    EncoderFaults faults_;
    double tick_hz_;
    RandomStream jitter_, drops_, extras_, cam_;
    int to_drop_ = 0;
    bool any_crank_ = false;
    EncoderEdge last_crank_{};
    std::vector<EncoderEdge> waiting_; // ascending by time from first_ on
    std::size_t first_ = 0;
};

} // namespace sixdeg
