// SPDX-License-Identifier: MIT
// Which column, which edge, which threshold, which wheel: read off the recording itself. How, and what it cannot do:
// docs/theory/wheel.md.
#pragma once
#include <deque>
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
    std::string cam_file;               ///< The cam is recorded there, on the same clock; `cam_column` is of it then. Empty: beside the
                                        ///< crank.
    std::optional<double> unit_s;       ///< Of the times.
    std::optional<double> cam_place_rev; ///< Of the engine's telling cam edge, [0, 1) from position 0.
};

/// A column with pulses that tell the two revolutions of a four-stroke cycle apart.
struct CamGuess {
    std::string file;         ///< Empty: the recording itself.
    double unit_s = 1;        ///< Of the times in `file`.
    int column = 0;
    bool is_edge_times = false; ///< Each row of `file` is an edge.
    Edge edge = Edge::rising;
    Slicing slicing;
    double place_rev = 0;     ///< Where in the revolution its telling edge lies, [0, 1) from position 0, evenly over the teeth.
    int teeth = 1;            ///< Edges a cycle; above 1 only those near place_rev tell.
    double moved_rev = 0;     ///< How far the telling edge moves about in the recording.
    std::vector<double> time; ///< Its edges, ascending, in the recording's unit.
};

/// The single tooth of a wheel like 24+1, where it has a sensor of its own.
struct HomeTooth {
    int column = 0;
    Edge edge = Edge::rising;
    Slicing slicing;
    bool on_cam = false; ///< It comes once in two revolutions of the crank.
    double between = 0;  ///< Its median place between two teeth, 0 to 1.
};

struct Guess {
    Wheel wheel;
    Edge edge = Edge::falling; ///< Without meaning for a recording of edge times.
    int column = 0;            ///< The time column for a recording of edge times.
    Slicing slicing;
    bool is_edge_times = false;
    bool tooth_added = false;  ///< The wheel has a tooth more than positions: "24+1", read as one with a missing tooth (AddedTooth).
    std::optional<HomeTooth> home; ///< That tooth is in a column of its own; empty: it is one more among the others.
    bool weak_tooth = false;   ///< The usual threshold misses a tooth of each revolution.
    double gap_ratio = 0; ///< Median of the mark's interval over the interval before it; 0 if no mark was seen.
    int consistent_revolutions = 0; ///< Revolutions whose marks follow each other by exactly the wheel's teeth.
    double unit_s = 1;              ///< Of the recording's times.
    bool unit_guessed = false;      ///< The header names none, and seconds would give no engine's speed.
    bool unit_given = false;        ///< By the caller.
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

/// Makes a wheel with one missing tooth of one with a tooth added: takes that tooth and the one behind it out of a train of edges, or,
/// where it is in a column of its own, the tooth before it.
class AddedTooth {
  public:
    explicit AddedTooth(const Guess &guess) : active_(guess.tooth_added), apart_(guess.home), positions_(guess.wheel.positions) {}
    /// An edge of the single tooth in a column of its own.
    void reference(double time) { references_.push_back(time); }
    /// The next edge; those that may go on are appended to `out`.
    void edge(double time, std::vector<double> &out);
    void finish(std::vector<double> &out);

  private:
    void decide(std::vector<double> &out);
    bool is_last_tooth();

    bool active_, apart_;
    int positions_, since_ = 0; ///< Teeth since the one left out.
    int off_ = 0;               ///< By so many teeth the last reference was off the count.
    bool counting_ = false;
    std::deque<double> references_;
    std::vector<double> held_;
};

} // namespace sixdeg
