// SPDX-License-Identifier: MIT
#include "plant/sensors/edge_generator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/streams.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

} // namespace

// turn = v t + a t^2/2 solved so that nothing cancels: t = 2 turn / (v +- sqrt(v^2 + 2 a turn)).
double EdgeGenerator::Piece::time_of(double turn_deg) const {
    const double square = speed_dps * speed_dps + 2 * slope_dps2 * turn_deg;
    if (square < 0) return kNever;
    const double denominator = speed_dps + std::copysign(std::sqrt(square), turn_deg);
    const double time = denominator == 0 ? kNever : 2 * turn_deg / denominator;
    return time >= 0 ? time : kNever;
}

EdgeGenerator::EdgeGenerator(const EngineFile &engine, const EncoderFaults &faults, const Profile &speed_rpm,
                             double start_deg, double duration_s, std::uint64_t seed)
    : speed_dps_(speed_rpm.scaled(6)), duration_s_(duration_s), faults_(faults),
      wheel_(engine, faults.offset_deg, faults.pattern_rms_deg,
             faults.tooth_width * 360 / engine.wheel.positions, RandomStream(seed, stream::kPattern)),
      pickup_(faults, engine.tick_hz, seed), has_cam_(engine.has_cam), next_cam_deg_(engine.cam_edge_deg) {
    wheel_.seek(start_deg);
    if (next_cam_deg_ + faults.cam_retard_deg.at(0) <= start_deg) next_cam_deg_ += 720;
    begin_piece(0, start_deg);
}

void EdgeGenerator::begin_piece(double t, double angle_deg) {
    const Profile::Segment segment = speed_dps_.segment(t);
    piece_ = {t, std::min(segment.x1, duration_s_), angle_deg, segment.at(t), segment.slope};
    const double turns_after = -piece_.speed_dps / piece_.slope_dps2;
    if (turns_after > 1e-12 && t + turns_after < piece_.t1) piece_.t1 = t + turns_after;
    const double direction = piece_.speed((piece_.t1 - t) / 2);
    if (direction != 0 && (direction < 0) != backward_) {
        backward_ = direction < 0;
        wheel_.seek(angle_deg);
    }
    now_s_ = t;
    now_radps_ = piece_.speed_dps * kRadPerDeg;
    ended_ = t >= duration_s_;
}

// The phaser moves while the crank turns: repeat until angle and time agree. Turning backward the cam is
// silent.
double EdgeGenerator::cam_time() const {
    if (!has_cam_ || backward_) return kNever;
    double dt = 0;
    for (int i = 0; i < 50; ++i) {
        const double target = next_cam_deg_ + faults_.cam_retard_deg.at(piece_.t0 + dt);
        const double better = piece_.time_of(std::max(target - piece_.angle0_deg, 0.0));
        if (better == kNever || std::abs(better - dt) < 1e-13) return better;
        dt = better;
    }
    return dt;
}

void EdgeGenerator::pass(double dt, EdgeKind kind, const WheelEdge *tooth) {
    EncoderEdge edge;
    edge.time_s = piece_.t0 + dt;
    edge.kind = kind;
    edge.backward = backward_;
    edge.tooth = tooth ? tooth->tooth : -1;
    const double angle = tooth ? tooth->angle_deg : piece_.angle(dt);
    edge.angle_deg = angle - 720 * std::floor(angle / 720);
    edge.speed_radps = piece_.speed(dt) * kRadPerDeg;
    now_s_ = edge.time_s;
    now_radps_ = edge.speed_radps;
    pickup_.pass(edge);
}

bool EdgeGenerator::pass_next() {
    const double length = piece_.t1 - piece_.t0;
    const WheelEdge tooth = backward_ ? wheel_.backward() : wheel_.forward();
    const double crank = piece_.time_of(tooth.angle_deg - piece_.angle0_deg);
    const bool cam_first = next_cam_deg_ + faults_.cam_retard_deg.smallest() <= tooth.angle_deg;
    const double cam = cam_first ? cam_time() : kNever;
    if (std::min(crank, cam) > length) {
        begin_piece(piece_.t1, piece_.angle(length));
        return !ended_;
    }
    if (cam < crank) {
        pass(cam, EdgeKind::cam, nullptr);
        next_cam_deg_ += 720;
        return true;
    }
    pass(crank, EdgeKind::crank, &tooth);
    backward_ ? wheel_.pass_backward() : wheel_.pass_forward();
    return true;
}

bool EdgeGenerator::next_edge(EncoderEdge &edge) {
    while (!pickup_.take(now_s_, now_radps_, edge)) {
        if (ended_ || !pass_next()) {
            if (!pickup_.take_rest(edge)) return false;
            break;
        }
    }
    return edge.time_s < duration_s_;
}

} // namespace sixdeg
