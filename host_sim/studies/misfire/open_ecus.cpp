// SPDX-License-Identifier: MIT
#include "studies/misfire/open_ecus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sixdeg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMeanWeight = 1.0 / 4, kUsualWeight = 1.0 / 128; ///< Of one firing in the two running means.

/// Where the teeth should stand, and when they passed.
class Teeth {
  public:
    Teeth(const SetRun &run, const EngineFile &engine) : tick_hz_(engine.tick_hz) {
        const double pitch_deg = 360.0 / engine.wheel.positions;
        std::uint32_t last = run.record.edges.empty() ? 0 : run.record.edges.front().tick;
        double ticks = 0;
        for (const PlantRecord::Edge &edge : run.record.edges) {
            const double place_deg = engine.position_0_deg + pitch_deg * edge.tooth;
            angle_deg_.push_back(place_deg + 360 * std::round((edge.crank_deg - place_deg) / 360));
            ticks += std::uint32_t(edge.tick - last);
            last = edge.tick;
            ticks_.push_back(ticks);
        }
    }
    /// Mean speed, rpm, between the first tooth from each angle on.
    double speed_rpm(double from_deg, double to_deg) const {
        const std::size_t a = first_from(from_deg), b = first_from(to_deg);
        if (from_deg < angle_deg_.front() || b == angle_deg_.size() || a == b) return kNaN;
        return (angle_deg_[b] - angle_deg_[a]) / (ticks_[b] - ticks_[a]) * tick_hz_ / 6;
    }

  private:
    std::size_t first_from(double deg) const {
        return std::size_t(std::lower_bound(angle_deg_.begin(), angle_deg_.end(), deg - 1e-6) - angle_deg_.begin());
    }
    double tick_hz_;
    std::vector<double> angle_deg_, ticks_;
};

/// Speed in the window of each firing, rpm.
std::vector<double> window_speeds(const SetRun &run, const EngineFile &engine, AngleWindow window) {
    const Teeth teeth(run, engine);
    const double interval_deg = 720.0 / engine.cylinders();
    std::vector<double> speeds;
    for (const SetFiring &firing : run.firings)
        speeds.push_back(teeth.speed_rpm(firing.tdc_deg + window.from * interval_deg, firing.tdc_deg + window.to * interval_deg));
    return speeds;
}

} // namespace

std::vector<double> speed_delta(const SetRun &run, const EngineFile &engine, AngleWindow window) {
    const std::vector<double> speed = window_speeds(run, engine, window);
    std::vector<double> score(speed.size(), kNaN);
    for (std::size_t i = 1; i < speed.size(); ++i) score[i] = speed[i] - speed[i - 1];
    return score;
}

std::vector<double> running_mean(const SetRun &run, const EngineFile &engine, AngleWindow window) {
    const std::vector<double> speed = window_speeds(run, engine, window);
    std::vector<double> score(speed.size(), kNaN), mean(std::size_t(engine.cylinders()) + 1, 0);
    double usual = 0;
    for (std::size_t i = 0; i < speed.size(); ++i) {
        if (std::isnan(speed[i])) continue;
        double &of_cylinder = mean[std::size_t(run.firings[i].cylinder)];
        const double time = 1 / speed[i];
        if (of_cylinder == 0) of_cylinder = time;
        const double late = time - of_cylinder;
        score[i] = usual > 0 ? -late / usual : 0;
        of_cylinder += kMeanWeight * late;
        usual += (usual > 0 ? kUsualWeight : 1) * (std::abs(late) - usual);
    }
    return score;
}

} // namespace sixdeg
