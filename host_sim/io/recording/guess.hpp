// SPDX-License-Identifier: MIT
// Which column, which edge, which threshold, which wheel: read off the recording itself. How, and what it cannot do:
// docs/recordings.md.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording/edges.hpp"
#include "io/recording/wheels.hpp"

namespace sixdeg {

/// What the caller knows already; only the rest is guessed.
struct Constraints {
    std::optional<WheelText> wheel;     ///< As the caller named it.
    std::optional<Wheel> engine_wheel;  ///< As the engine file has it; contradicted where the recording shows another.
    std::optional<Edge> edge;
    std::optional<int> column;
    std::optional<double> threshold;    ///< In the column's unit.
    std::optional<int> cam_column;
    std::optional<double> cam_place_rev; ///< Of the engine's telling cam edge, [0, 1) from position 0.
};

/// A column with pulses that tell the two revolutions of a four-stroke cycle apart.
struct CamGuess {
    int column = 0;
    Edge edge = Edge::rising;
    Slicing slicing;
    double place_rev = 0;     ///< Where in the revolution its telling edge lies, [0, 1) from position 0, evenly over the teeth.
    int teeth = 1;            ///< Edges a cycle; above 1 only those near place_rev tell.
    double moved_rev = 0;     ///< How far the telling edge moves about in the recording.
    std::vector<double> time; ///< Its edges, ascending, in the recording's unit.
};

struct Guess {
    Wheel wheel;
    Edge edge = Edge::falling; ///< Without meaning for a recording of edge times.
    int column = 0;            ///< The time column for a recording of edge times.
    Slicing slicing;
    bool is_edge_times = false;
    bool tooth_added = false;  ///< The wheel has a tooth more than positions: "24+1", read as one with a missing tooth (AddedTooth).
    bool weak_tooth = false;   ///< The usual threshold misses a tooth of each revolution.
    double gap_ratio = 0; ///< Median of the mark's interval over the interval before it; 0 if no mark was seen.
    int consistent_revolutions = 0; ///< Revolutions whose marks follow each other by exactly the wheel's teeth.
    double unit_s = 1;              ///< Of the recording's times.
    bool unit_guessed = false;      ///< The header names none, and seconds would give no engine's speed.
    double rpm = 0;                 ///< From the median interval.
    std::string runner_up;          ///< The next best reading, with what speaks for it; empty without one.
    std::vector<double> time;       ///< The edges of column and edge in the stretch guessed from, ascending, in the recording's unit.
    std::optional<CamGuess> cam;    ///< Empty unless it is clear.
};

/// Throws InputError that says what was tried and which options to give when no column shows a wheel, when it is not the engine
/// file's, when its marks may lie several times on a revolution, and when the column that the caller asked for does not exist or has
/// not the edges of one revolution.
Guess guess(const Recording &recording, const Constraints &constraints = {});

/// "60-2, falling, gap ratio 3.3".
std::string describe(const Guess &guess);
/// "60-2", or "24+1".
std::string wheel_name(const Guess &guess);

/// Takes an added tooth out of a train of edges, and the tooth behind it: what is left is a wheel with one missing tooth.
class AddedTooth {
  public:
    explicit AddedTooth(const Guess &guess) : active_(guess.tooth_added) {}
    /// The next edge; those that may go on are appended to `out`.
    void edge(double time, std::vector<double> &out);
    void finish(std::vector<double> &out);

  private:
    bool active_, drop_next_ = false;
    std::vector<double> held_;
};

} // namespace sixdeg
