// SPDX-License-Identifier: MIT
// Where a toothed wheel's edges stand, and which comes next either way round.
#pragma once
#include <cstdint>
#include <vector>

#include "common/engine_file.hpp"
#include "common/random.hpp"

namespace sixdeg {

/// One edge of the wheel as the crank passes it.
struct WheelEdge {
    double
        angle_deg; ///< Unwrapped crank angle at which the wheel gives it, pattern error and offset included.
    int tooth;     ///< Wheel position, 0 to positions - 1.
};

/// The wheel's active edges on the unwrapped crank angle. Turning forward, tooth k is seen at its edge;
/// turning backward the sensor sees the tooth's other flank as the active edge, tooth_width_deg lower.
class WheelEdges {
  public:
    /// Fixed tooth pattern error: normal, `pattern_rms_deg` over the teeth (scaled to that rms exactly, mean
    /// zero), drawn from `random`. `offset_deg` > 0 moves every edge to a larger crank angle.
    WheelEdges(const EngineFile &engine, double offset_deg, double pattern_rms_deg, double tooth_width_deg,
               RandomStream random);

    /// Places the cursor: forward() is the first edge above `angle_deg` then, backward() the last one below.
    void seek(double angle_deg);
    const WheelEdge &forward() const { return forward_; }
    const WheelEdge &backward() const { return backward_; }
    void pass_forward() { ++up_, ++down_, refresh(); }
    void pass_backward() { --up_, --down_, refresh(); }

    /// Pattern error of each position in deg, 0 where a tooth is missing.
    std::vector<double> pattern_deg(int positions) const;

  private:
    WheelEdge edge(std::int64_t index) const;
    void refresh();
    struct Tooth {
        double angle_deg, pattern_deg; ///< angle in [0, 360) plus pattern
        int position;
    };
    std::vector<Tooth> teeth_; // ascending by angle
    double tooth_width_deg_;
    std::int64_t up_ = 0, down_ = -1; // running numbers of the next edge forward and backward
    WheelEdge forward_{}, backward_{};
};

} // namespace sixdeg
