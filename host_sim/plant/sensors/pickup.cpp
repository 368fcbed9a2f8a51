// SPDX-License-Identifier: MIT
#include "plant/sensors/pickup.hpp"

#include <algorithm>
#include <cmath>

#include "common/streams.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

constexpr double kJitterCut = 4; // standard deviations
constexpr int kLongestRun = 1000;
constexpr std::size_t kTakenKept = 256;
// Turning slower than this the sensor's lag in degrees would last for ever.
constexpr double kSlowest = 1;

double cut_normal(RandomStream &random) { return std::clamp(random.normal(), -kJitterCut, kJitterCut); }

double between(const EncoderEdge &a, const EncoderEdge &b, double time) {
    const double turn = std::remainder(b.angle_deg - a.angle_deg, 720.0);
    const double angle = a.angle_deg + turn * (time - a.time_s) / (b.time_s - a.time_s);
    return angle - 720 * std::floor(angle / 720);
}

} // namespace

Pickup::Pickup(const EncoderFaults &faults, double tick_hz, std::uint64_t seed)
    : faults_(faults), tick_hz_(tick_hz), jitter_(seed, stream::kJitter), drops_(seed, stream::kDrops),
      extras_(seed, stream::kExtras), cam_(seed, stream::kCam) {
    waiting_.reserve(64);
}

double Pickup::lateness_s(const EncoderEdge &edge, double jitter_deg) {
    const double speed = std::max(std::abs(edge.speed_radps), kSlowest);
    return faults_.delay_s + (faults_.lag_deg.at(speed) + jitter_deg) * kRadPerDeg / speed;
}

int Pickup::run_length(double mean, RandomStream &random) {
    int length = 1;
    while (length < kLongestRun && random.chance(1 - 1 / mean)) ++length;
    return length;
}

void Pickup::insert(const EncoderEdge &edge) {
    waiting_.push_back(edge);
    for (std::size_t i = waiting_.size() - 1; i > first_ && waiting_[i].time_s < waiting_[i - 1].time_s;
         --i) {
        std::swap(waiting_[i], waiting_[i - 1]);
    }
}

void Pickup::add_false_edges(const EncoderEdge &until) {
    if (faults_.extra_rate <= 0 || !extras_.chance(faults_.extra_rate) || !any_crank_) return;
    for (int count = run_length(faults_.extra_burst, extras_); count > 0; --count) {
        EncoderEdge edge = until;
        edge.spurious = true;
        edge.tooth = -1;
        edge.time_s = last_crank_.time_s + extras_.uniform() * (until.time_s - last_crank_.time_s);
        edge.angle_deg = between(last_crank_, until, edge.time_s);
        insert(edge);
    }
}

void Pickup::pass(const EncoderEdge &passed) {
    EncoderEdge edge = passed;
    if (edge.kind == EdgeKind::cam) {
        edge.time_s +=
            lateness_s(edge, faults_.cam_jitter_deg > 0 ? faults_.cam_jitter_deg * cut_normal(cam_) : 0);
        if (!(faults_.cam_drop_rate > 0 && cam_.chance(faults_.cam_drop_rate))) insert(edge);
        return;
    }
    edge.time_s += lateness_s(edge, faults_.jitter_deg > 0 ? faults_.jitter_deg * cut_normal(jitter_) : 0);
    add_false_edges(edge);
    last_crank_ = edge;
    any_crank_ = true;
    if (faults_.drop_rate > 0 && to_drop_ == 0 && drops_.chance(faults_.drop_rate)) {
        to_drop_ = run_length(faults_.drop_burst, drops_);
    }
    if (to_drop_ > 0) {
        --to_drop_;
        return;
    }
    insert(edge);
}

bool Pickup::take(double now_s, double speed_radps, EncoderEdge &edge) {
    if (empty()) return false;
    const double speed = std::max(std::abs(speed_radps), kSlowest);
    const double jitter = kJitterCut * std::max(faults_.jitter_deg, faults_.cam_jitter_deg);
    // The earliest that a passing still unknown can come out.
    const double earliest =
        now_s + faults_.delay_s + (faults_.lag_deg.smallest() - jitter) * kRadPerDeg / speed;
    if (waiting_[first_].time_s > earliest) return false;
    // False edges may still be put between the last tooth and the next.
    if (faults_.extra_rate > 0 && waiting_[first_].time_s > last_crank_.time_s && now_s < kEndOfTime)
        return false;
    edge = waiting_[first_++];
    if (empty()) waiting_.clear(), first_ = 0;
    if (first_ > kTakenKept)
        waiting_.erase(waiting_.begin(), waiting_.begin() + std::ptrdiff_t(first_)), first_ = 0;
    edge.tick = std::uint32_t(std::int64_t(std::floor(edge.time_s * tick_hz_)));
    return true;
}

} // namespace sixdeg
