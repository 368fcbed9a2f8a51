// SPDX-License-Identifier: MIT
#include "studies/driveline/damping_case.hpp"

#include <deque>

#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

constexpr double kTipOutS = 3, kEndS = 6;

/// What the engine makes of a request: a dead time, then a first-order lag.
class LateEngine {
  public:
    LateEngine(double dead_s, double lag_s) : dead_s_(dead_s), lag_s_(lag_s) {}
    void ask(double now, double nm) { waiting_.push_back({now + dead_s_, nm}); }
    double step(double now, double h) {
        for (; !waiting_.empty() && waiting_.front().first <= now; waiting_.pop_front()) target_ = waiting_.front().second;
        given_ += (target_ - given_) * (1 - std::exp(-h / lag_s_));
        return given_;
    }

  private:
    double dead_s_, lag_s_, target_ = 0, given_ = 0;
    std::deque<std::pair<double, double>> waiting_;
};

/// From the first crest of the shaft's torque behind the tip-out's trough to the trough after it.
class SecondSwing {
  public:
    void see(double now, double winding, double nm) {
        if (now < kTipOutS + 0.05) return;
        if (last_ != 0 && winding * last_ < 0) turns_.push_back(nm);
        if (winding != 0) last_ = winding;
    }
    double size_nm() const { return turns_.size() < 3 ? 0 : std::abs(turns_[2] - turns_[1]); }

  private:
    std::vector<double> turns_;
    double last_ = 0;
};

} // namespace

DampingFigures run_damping(const DampingCase &c) {
    DriveRig rig(c.drive);
    rig.start(1800 * kRadpsPerRpm, 200);
    rig.count_from(1);
    sd_driveline_damping_t damping;
    sd_driveline_damping_init(&damping, &c.damping);
    LateEngine engine(c.dead_time_s, c.lag_s);
    SecondSwing swing;
    DampingFigures figures;
    double last_tooth_s = 0;
    bool spoilt = false;
    while (rig.car().state().time_s < kEndS) {
        const double now = rig.car().state().time_s;
        const double wanted = now < kTipOutS ? 40 : 40 - 50 * std::min(1.0, (now - kTipOutS) / 0.05);
        DriverInput input;
        input.torque_nm = std::clamp(wanted + engine.step(now, 1e-4), c.lowest_nm, c.highest_nm);
        rig.step(input, kEndS);
        for (const ToothEdge &edge : rig.edges()) {
            const float step = float(edge.time_s - last_tooth_s);
            last_tooth_s = edge.time_s;
            const float nm = sd_driveline_damping_step(&damping, &c.damping, rig.out().winding_radps, rig.out().status.health, step);
            engine.ask(edge.time_s, double(nm));
            figures.largest_request_nm = std::max(figures.largest_request_nm, std::abs(double(nm)));
            if (spoilt && nm == 0 && rig.out().status.health != SD_VALID &&
                figures.off_after_s < 0) figures.off_after_s = edge.time_s - c.wrong_at_s;
        }
        if (c.wrong_at_s > 0 && now >= c.wrong_at_s && !spoilt) {
            rig.put_twist(rig.car().location() == 2 ? 2 * c.drive.believed.kink_rad : 0);
            spoilt = true;
        }
        const VehicleState &at = rig.car().state();
        swing.see(now, rig.car().ratio() * at.gearbox_radps - at.wheel_radps, rig.car().ratio() * rig.car().shaft_nm());
    }
    figures.second_swing_nm = swing.size_nm();
    figures.told_percent = rig.figures().told_percent;
    return figures;
}

} // namespace sixdeg
