// SPDX-License-Identifier: MIT
#include "studies/driveline/fixed_beside.hpp"

#include <cmath>
#include <stdexcept>

namespace sixdeg {
namespace {

struct Said {
    float twist_rad;
    std::uint8_t location, health;
};

DriveFigures note(const DriveCase &drive, std::vector<Said> &said) {
    return run_drive(drive, [&](const DriveRig &rig) {
        if (!rig.edges().empty()) said.push_back({rig.out().twist_rad, rig.out().location, rig.out().status.health});
    });
}

} // namespace

Beside fixed_beside(DriveCase drive) {
    Beside beside;
    std::vector<Said> f32, q31;
    drive.fixed_point = false;
    beside.f32 = note(drive, f32);
    drive.fixed_point = true;
    beside.q31 = note(drive, q31);
    if (f32.size() != q31.size()) throw std::logic_error("the two filters were not on the same teeth");
    double squares = 0;
    int counted = 0;
    for (std::size_t i = 0; i < f32.size(); ++i) {
        beside.teeth++;
        beside.other_location += f32[i].location != q31[i].location;
        beside.other_health += f32[i].health != q31[i].health;
        if (f32[i].health == SD_INVALID || q31[i].health == SD_INVALID) continue;
        const double apart = std::abs(double(f32[i].twist_rad) - double(q31[i].twist_rad));
        squares += apart * apart;
        beside.twist_apart_most_rad = std::max(beside.twist_apart_most_rad, apart);
        counted++;
    }
    beside.twist_apart_rms_rad = counted > 0 ? std::sqrt(squares / counted) : 0;
    return beside;
}

} // namespace sixdeg
