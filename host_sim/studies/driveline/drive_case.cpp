// SPDX-License-Identifier: MIT
#include "studies/driveline/drive_case.hpp"

#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

constexpr double kTickHz = 30e6;
constexpr std::uint32_t kDriver = 1, kJitter = 2, kPattern = 3, kWheelJitter = 4; // random streams

/// Torque at the crank over time: holds and ramps, drawn as the drive goes on, so that the speed stays where it should.
class Driver {
  public:
    explicit Driver(std::uint64_t seed) : random_(seed, kDriver) {}
    double follow(double now, double speed_rpm) {
        if (now >= next_s_) {
            from_nm_ = at(now);
            from_s_ = now;
            to_nm_ = speed_rpm > 2900   ? -15 + 5 * random_.uniform()
                     : speed_rpm < 1300 ? 40 + 40 * random_.uniform()
                                        : -15 + 75 * random_.uniform();
            ramp_s_ = 0.05 + 0.25 * random_.uniform();
            next_s_ = now + 0.6 + 2.4 * random_.uniform();
        }
        return at(now);
    }

  private:
    double at(double now) const { return from_nm_ + std::clamp((now - from_s_) / ramp_s_, 0.0, 1.0) * (to_nm_ - from_nm_); }
    RandomStream random_;
    double from_nm_ = 15, to_nm_ = 15, from_s_ = 0, ramp_s_ = 1, next_s_ = 3;
};

ToothedWheel crank_wheel(const DriveCase &c) {
    ToothedWheel wheel;
    wheel.jitter_rad = c.jitter_deg * kRadPerDeg;
    RandomStream place(c.seed, kPattern);
    for (int i = 0; i < wheel.positions && c.pattern_deg > 0; ++i) wheel.pattern_rad.push_back(c.pattern_deg * kRadPerDeg * place.normal());
    return wheel;
}

ToothedWheel road_wheel(const DriveCase &c) { return {c.belief.wheel_positions, 0, c.wheel_jitter_deg * kRadPerDeg, {}}; }

} // namespace

DriveCase usual_drive() {
    DriveCase drive;
    drive.real.rolling_nm = 48;   // 0.012 of 1300 kg at 0.316 m
    drive.real.drag_nms2 = 0.012; // 0.65 m2
    drive.believed = drive.real;
    return drive;
}

DriveRig::DriveRig(const DriveCase &c)
    : drive_(c), car_(c.real, [this](double, double angle) { return input_nm_ + drive_.ripple_nm * std::sin(2 * angle); }),
      wheel_(crank_wheel(c)), crank_teeth_(wheel_, RandomStream(c.seed, kJitter)),
      wheel_teeth_(road_wheel(c), RandomStream(c.seed, kWheelJitter)),
      filter_(guard_tables(c.believed, c.belief, wheel_.positions, 1 / kTickHz, c.guard), c.fixed_point) {
    car_.set_extra_load(c.slope_nm);
}

void DriveRig::step(const DriverInput &input, double until_s) {
    input_nm_ = input.torque_nm;
    car_.set_clutch(input.clutch_nm);
    if (input.gear != car_.gear()) car_.set_gear(input.gear);
    const std::size_t changes = car_.changes().size();
    car_.step(until_s);
    const VehicleState &from = car_.before(), &to = car_.state();
    const double h = to.time_s - from.time_s;
    torque_sum_ += input.torque_nm * h;
    torque_s_ += h;
    if (car_.changes().size() > changes) score_.changed(car_.changes().back());
    score_.pass(to.time_s, h, car_.location());
    edges_.clear();
    wheel_edges_.clear();
    crank_teeth_.pass({from.time_s, from.angle_rad, from.speed_radps}, {to.time_s, to.angle_rad, to.speed_radps}, edges_);
    if (drive_.wheel_jitter_deg > 0) {
        wheel_teeth_.pass({from.time_s, from.wheel_rad, from.wheel_radps}, {to.time_s, to.wheel_rad, to.wheel_radps}, wheel_edges_);
    }
    for (const ToothEdge &edge : edges_) tooth(edge, input);
    for (const ToothEdge &edge : wheel_edges_) {
        const double since = std::max(0.0, edge.time_s - last_edge_s_);
        filter_.wheel(std::uint32_t(since * kTickHz), std::uint16_t(edge.advance));
    }
}

void DriveRig::tooth(const ToothEdge &edge, const DriverInput &input) {
    const std::int64_t ticks = std::llround(edge.time_s * kTickHz) - std::llround(last_edge_s_ * kTickHz);
    last_edge_s_ = edge.time_s;
    sd_driveline_tooth_f32_t tooth{};
    tooth.period_ticks = std::uint32_t(ticks);
    tooth.advance = std::uint16_t(edge.advance);
    tooth.health = SD_VALID;
    tooth.gear = input.clutch_nm >= kClutchHoldsNm ? std::uint8_t(car_.gear() + 1) : 0;
    tooth.torque_nm = float(torque_sum_ / torque_s_ + drive_.torque_error_nm);
    if (drive_.pattern_known && drive_.pattern_deg > 0) tooth.place_rad = float(wheel_.pattern_rad[std::size_t(edge.position)]);
    torque_sum_ = torque_s_ = 0;
    filter_.step(tooth);
    const sd_driveline_out_f32_t &out = filter_.out();
    score_.said(edge.time_s, double(ticks) / kTickHz, out, double(out.twist_rad) - car_.state().twist_rad,
                double(out.shaft_nm) - car_.ratio() * car_.shaft_nm());
}

DriveFigures DriveRig::figures() const {
    DriveFigures figures = score_.figures();
    figures.rejected = filter_.rejected();
    return figures;
}

DriveFigures run_drive(const DriveCase &drive, const std::function<void(const DriveRig &)> &watch) {
    Driver driver(drive.seed);
    DriveRig rig(drive);
    rig.start(2000 * kRadpsPerRpm, 56);
    while (rig.car().state().time_s < drive.duration_s) {
        DriverInput input;
        input.torque_nm = driver.follow(rig.car().state().time_s, rig.car().state().speed_radps / kRadpsPerRpm);
        rig.step(input, drive.duration_s);
        if (watch) watch(rig);
    }
    return rig.figures();
}

} // namespace sixdeg
