// SPDX-License-Identifier: MIT
// One step of the simulated engine: pressures of all cylinders first, then the crank they turn, then what the pressures' next
// change will be, which depends on the speed reached (docs/theory/plant.md, section Integration).
#include <algorithm>
#include <cmath>

#include "plant/engine/engine_model.hpp"

// Inlines every call within: one step is a few hundred instructions, and calls would cost a third of them.
#define SD_FLATTEN __attribute__((flatten))

namespace sixdeg {

double EngineModel::theta(int half, int lane) const {
    const double angle = half * (tables_.step_rad / 2) - tables_.tdc_rad[std::size_t(lane)];
    return angle > 2 * kPi ? angle - 4 * kPi : angle;
}

// The step's change of y = p V^k at a point of the tables: with p = y V^-k and c_v from T = y V^(1-k)/(m R),
// dy = V^(k-1) ((Q' - Qw' - p V')/(c_v/R) + (k - 1) p V') da.
inline EngineModel::Twins EngineModel::change_at(const CylinderPoint &point, int lane, Twins y, double slowness, double heat_rate,
                                          double &loss) const {
    const Twins t = y * (point.warmth * lane_[lane].inverse_mr), power = y * point.push;
    const Twins cv = cv_[0] + t * (cv_[1] + t * cv_[2]);
    const Twins to_walls = y * (t - wall_k_) * (lane_[lane].wall_factor * point.wall * point.pressure * slowness);
    loss = to_walls[0] * tables_.step_rad;
    // The inverse waits for nothing, the rest for the speed.
    return (Twins{heat_rate, 0} - power - to_walls) * (point.rise / cv) + power * ((StepTables::kPolytropic - 1) * point.rise);
}

void EngineModel::find_change(int lane) {
    lane_[lane].course.change =
        change_at(tables_.row(2 * step_)[lane], lane, lane_[lane].y, crank_.slowness, lane_[lane].heat, lane_[lane].course.loss);
}

/// Slowness from the torque and its last change, for lanes that cannot wait for the crank.
EngineModel::Ahead EngineModel::look_ahead() const {
    const double h = tables_.step_rad;
    if (prescribed_) {
        const double square = crank_.speed * crank_.speed;
        return {1 / std::sqrt(square + speed_slope_ * h), 1 / std::sqrt(square + 2 * speed_slope_ * h)};
    }
    const double net = truth().net_torque_nm, bend = truth().gas_torque_nm - gas_before_nm_;
    const auto slowness = [&](double energy, int half) { return 1 / std::sqrt(energy * tables_.two_over_inertia[std::size_t(half)]); };
    return {slowness(crank_.energy + h / 2 * (net + bend / 4), 2 * step_ + 1), slowness(crank_.energy + h * (net + bend / 2), end_point())};
}

/// A shut cylinder whose change has been smooth for some steps: Adams and Bashforth's fourth-order rule to the step's middle and
/// end.
inline void EngineModel::step_shut(int lane, Ending &end) const {
    const Course &c = lane_[lane].course;
    const Twins start = lane_[lane].y, change = c.change, first = c.first, second = c.second, third = c.third;
    const Twins middle = start + 0.5 * change + 0.125 * first + (1.0 / 12) * second + (25.0 / 384) * third;
    const Twins y = start + change + 0.5 * first + (5.0 / 12) * second + (3.0 / 8) * third;
    end.y[lane] = y;
    end.add(lane, middle * end.at_middle[lane].push, y * end.at_end[lane].push);
}

/// A shut cylinder whose change has just had a kink: Runge and Kutta's rule, which remembers nothing.
void EngineModel::step_rough(int lane, const Ahead &ahead, Ending &end) const {
    const CylinderPoint &half = end.at_middle[lane], &last = end.at_end[lane];
    const Course &c = lane_[lane].course;
    const double rate = end.heat[lane].rate_middle;
    double lost[3];
    const Twins k1 = c.change;
    const Twins k2 = change_at(half, lane, lane_[lane].y + k1 * 0.5, ahead.middle, rate, lost[0]);
    const Twins k3 = change_at(half, lane, lane_[lane].y + k2 * 0.5, ahead.middle, rate, lost[1]);
    const Twins k4 = change_at(last, lane, lane_[lane].y + k3, ahead.end, end.heat[lane].rate, lost[2]);
    end.lost[lane] = (c.loss + 2 * (lost[0] + lost[1]) + lost[2]) / 6;
    end.y[lane] = lane_[lane].y + (k1 + 2 * (k2 + k3) + k4) / 6;
    end.add(lane, (0.5 * (lane_[lane].y + end.y[lane]) + 0.125 * (k1 - k4)) * half.push, end.y[lane] * last.push);
}

/// An open cylinder follows its manifold, which has a closed form.
inline void EngineModel::step_open(int lane, Ending &end) const {
    const double manifold = lane_[lane].manifold;
    const Twins away = lane_[lane].y - manifold, p = manifold + away * stay_[1];
    end.y[lane] = p;
    end.add(lane, (manifold + away * stay_[0]) * end.at_middle[lane].volume_slope, p * end.at_end[lane].volume_slope);
}

inline bool EngineModel::stands_still(double energy) const {
    // Written so that NaN stands still too.
    return !(energy > stall_j_);
}

// Friction and load change little within a step: going on as in the step before they give a first energy, with speeds good enough for
// friction and load at middle and end, and those the second.
inline bool EngineModel::turn_free(const GasTorque &gas, Motion &to) const {
    const double h = tables_.step_rad, load = friction_and_load_nm_, rise = load - load_before_nm_;
    const double half = crank_.energy + h * (1.0 / 24) * (5 * gas.start + 8 * gas.middle - gas.end) - h * (0.5 * load + 0.125 * rise);
    const double whole = crank_.energy + h * (1.0 / 6) * (gas.start + 4 * gas.middle + gas.end) - h * (load + 0.5 * rise);
    if (stands_still(half) || stands_still(whole)) return false;
    const double rate_half = tables_.two_over_inertia[std::size_t(2 * step_ + 1)],
                 rate = tables_.two_over_inertia[std::size_t(end_point())];
    const double speed_half = std::sqrt(half * rate_half), speed = std::sqrt(whole * rate);
    const double slow_half = 1 / speed_half, slow = 1 / speed;
    const double time_half = crank_.time + h * (1.0 / 24) * (5 * crank_.slowness + 8 * slow_half - slow),
                 time = crank_.time + h * (1.0 / 6) * (crank_.slowness + 4 * slow_half + slow);
    // What both loads take beyond the guess; speed follows by first order.
    const double more_half = friction_nm(speed_half) + load_nm(time_half) - load, more = friction_nm(speed) + load_nm(time) - load;
    const double less_half = h * (1.0 / 24) * (8 * more_half - more - 3 * rise), less = h * (1.0 / 6) * (4 * more_half + more - 3 * rise);
    const double gain_half = 0.5 * less_half * rate_half * slow_half * slow_half, gain = 0.5 * less * rate * slow * slow;
    to.energy = whole - less;
    to.early_slowness = slow;
    to.speed = speed - speed * gain;
    to.slowness = slow + slow * gain;
    to.time = time + h * (1.0 / 6) * slow * (4 * gain_half + gain);
    return true;
}

EngineModel::Motion EngineModel::flywheel_slope(int half, double gas_nm, const Motion &at) const {
    const double speed = std::sqrt(at.energy * tables_.two_over_inertia[std::size_t(half)]), slowness = 1 / speed,
                 lead = speed - at.secondary;
    const double carried = dual_mass_->stiffness_nmprad * at.twist + dual_mass_->damping_nmsprad * lead;
    return {gas_nm - friction_nm(speed) - carried, slowness, lead * slowness,
            (carried - load_nm(at.time)) / secondary_inertia_ * slowness, speed, slowness, slowness};
}

/// Spring and secondary mass are as fast as the crank: Runge and Kutta's rule for the four of them.
bool EngineModel::turn_with_flywheel(const GasTorque &gas, Motion &to) const {
    const double h = tables_.step_rad;
    const int middle = 2 * step_ + 1;
    const auto ahead = [this](double by, const Motion &k) {
        return Motion{crank_.energy + by * k.energy, crank_.time + by * k.time, crank_.twist + by * k.twist,
                      crank_.secondary + by * k.secondary, 0, 0, 0};
    };
    const Motion k1 = flywheel_slope(2 * step_, gas.start, crank_);
    Motion at = ahead(h / 2, k1);
    if (stands_still(at.energy)) return false;
    const Motion k2 = flywheel_slope(middle, gas.middle, at);
    at = ahead(h / 2, k2);
    if (stands_still(at.energy)) return false;
    const Motion k3 = flywheel_slope(middle, gas.middle, at);
    at = ahead(h, k3);
    if (stands_still(at.energy)) return false;
    const Motion k4 = flywheel_slope(end_point(), gas.end, at);
    const auto mean = [&](double Motion::*part) { return (k1.*part + 2 * (k2.*part + k3.*part) + k4.*part) / 6; };
    to = ahead(h, {mean(&Motion::energy), mean(&Motion::time), mean(&Motion::twist), mean(&Motion::secondary), 0, 0, 0});
    if (stands_still(to.energy)) return false;
    to.speed = std::sqrt(to.energy * tables_.two_over_inertia[std::size_t(end_point())]);
    to.slowness = to.early_slowness = 1 / to.speed;
    return true;
}

/// Speed is linear in time, so its square is in angle.
bool EngineModel::turn_prescribed(Motion &to) const {
    const double square = crank_.speed * crank_.speed + 2 * speed_slope_ * tables_.step_rad;
    if (!(square > 0)) return false;
    to = crank_;
    to.time += 2 * tables_.step_rad / (crank_.speed + std::sqrt(square));
    to.speed = speed0_ + speed_slope_ * (to.time - speed_time_);
    to.slowness = to.early_slowness = 1 / to.speed;
    to.energy = 0.5 * tables_.inertia[std::size_t(end_point())] * to.speed * to.speed;
    return to.speed > 0;
}

bool EngineModel::turn(const GasTorque &gas, Motion &to) const {
    if (prescribed_) return turn_prescribed(to);
    return dual_mass_ ? turn_with_flywheel(gas, to) : turn_free(gas, to);
}

/// Takes in a shut lane's step. The change here corrects a calm lane's pressure to fifth order, by Adams and Moulton's rule.
/// Returns by how much that corrects p V'.
inline EngineModel::Twins EngineModel::settle(int lane, const Ending &end) {
    const CylinderPoint &point = end.at_end[lane];
    Course &c = lane_[lane].course;
    double loss;
    lane_[lane].heat = end.heat[lane].rate, lane_[lane].released = end.heat[lane].released;
    const Twins change = change_at(point, lane, end.y[lane], crank_.early_slowness, lane_[lane].heat, loss);
    const Twins first = change - c.change, second = first - c.first, third = second - c.second;
    const double loss_first = loss - c.loss, loss_second = loss_first - c.loss_first, loss_third = loss_second - c.loss_second;
    Twins correction = {0, 0};
    if (end.calm[lane] < kCalm) {
        lane_[lane].calm = end.calm[lane] + 1;
        lane_[lane].lost += end.lost[lane];
    } else {
        correction = (third - c.third) * (251.0 / 720);
        lane_[lane].lost += loss - 0.5 * loss_first - (1.0 / 12) * loss_second - (1.0 / 24) * loss_third;
    }
    c = {change, first, second, third, loss, loss_first, loss_second};
    const Twins y = end.y[lane] + correction;
    lane_[lane].y = y;
    lane_[lane].work += end.work[lane];
    lane_[lane].peak = std::max(lane_[lane].peak, y[0] * point.pressure);
    return correction * point.push;
}

/// Heat of a lane that burns, from what its charge has laid down.
inline void EngineModel::find_heat(int lane, Ending &end) const {
    const Burn &burn = lane_[lane].burn;
    const BurnPoint &point = burn.points[std::size_t(burn.at)];
    end.heat[lane] = {burn.heat_j * point.rate, burn.heat_j * point.released, burn.heat_j * point.rate_middle};
    if (point.rough) end.calm[lane] = 0;
}

/// Pressures to the end of the step, as far as they are known before the crank's speed there.
inline void EngineModel::step_lanes(Ending &end) const {
    std::optional<Ahead> ahead;
    for (int i = 0; i < shut_count_; ++i) {
        const int lane = lanes_[i];
        end.heat[lane] = {0, lane_[lane].released, 0};
        end.calm[lane] = lane_[lane].calm;
        if (lane_[lane].burn.at >= 0) find_heat(lane, end);
        if (end.calm[lane] == kCalm) {
            step_shut(lane, end);
        } else {
            if (!ahead) ahead = look_ahead();
            step_rough(lane, *ahead, end);
        }
    }
    for (int i = shut_count_; i < n_; ++i) step_open(lanes_[i], end);
}

SD_FLATTEN bool EngineModel::step() {
    const int middle_row = 2 * step_ + 1, end_row = end_point();
    Ending end;
    end.at_middle = tables_.row(middle_row), end.at_end = tables_.row(end_row);
    step_lanes(end);
    Motion to{};
    if (!turn({truth().gas_torque_nm, end.middle_sum[0] - crankcase_pa_ * tables_.volume_slope_sum[std::size_t(middle_row)],
               end.sum[0] - crankcase_pa_ * tables_.volume_slope_sum[std::size_t(end_row)]},
              to))
        return false;
    gas_before_nm_ = truth().gas_torque_nm, load_before_nm_ = friction_and_load_nm_;
    crank_ = to;
    if (++step_ == tables_.steps) step_ = 0, ++cycle_, next_event_ = 0, point_at_next_event();
    Twins power = end.sum;
    for (int i = 0; i < shut_count_; ++i) {
        Burn &burn = lane_[lanes_[i]].burn;
        if (++burn.at == burn.end) burn.at = kNeverBurns;
        power += settle(lanes_[i], end);
    }
    for (int i = shut_count_; i < n_; ++i) {
        lane_[lanes_[i]].y = end.y[lanes_[i]];
        lane_[lanes_[i]].work += end.work[lanes_[i]];
    }
    first_event_ = next_event_;
    if (next_event_step_ == step_) {
        take_events();
        power = power_here();
    }
    latest_ = 1 - latest_;
    update_truth(power);
    return true;
}

EngineModel::Twins EngineModel::power_here() const {
    Twins power = {0, 0};
    for (int lane = 0; lane < n_; ++lane) power += power_of(lane);
    return power;
}

void EngineModel::update_truth(Twins gas) {
    StepTruth &truth = truths_[latest_];
    double carried = load_nm(crank_.time);
    if (dual_mass_ && !prescribed_)
        carried = dual_mass_->stiffness_nmprad * crank_.twist + dual_mass_->damping_nmsprad * (crank_.speed - crank_.secondary);
    friction_and_load_nm_ = friction_nm(crank_.speed) + carried;
    truth.angle_rad = (double(cycle_) * tables_.steps + step_) * tables_.step_rad;
    truth.time_s = crank_.time;
    truth.speed_radps = crank_.speed;
    truth.combustion_torque_nm = gas[0] - gas[1];
    truth.gas_torque_nm = gas[0] - crankcase_pa_ * tables_.volume_slope_sum[std::size_t(2 * step_)];
    truth.load_torque_nm = friction_and_load_nm_;
    truth.net_torque_nm = truth.gas_torque_nm - friction_and_load_nm_;
}

} // namespace sixdeg
