// SPDX-License-Identifier: MIT
// What a run shows of how well the calibration fits: the fuel-cut reading, innovations, the teeth beside the mark. From an ecu in this
// process; over a bus nobody sees them.
#pragma once
#include <cstdint>

extern "C" {
#include "sd_ecu.h"
}

namespace sixdeg {

/// Angles in deg, torques in N m.
struct Evidence {
    int cut_firings = 0;             ///< Firings read while no cylinder burnt anything; 0: none, and the next two mean nothing.
    double cut_nm = 0, cut_bar = 0;  ///< Mean reading of these, where 0 is true, and mean intake pressure;
    double cut_exponent = 0, exponent_sd = 0; ///< mean exponent of compression taken out of it, and what it is known to at the end.
    double late_deg = 0;             ///< How far teeth pass from where the filter expects them, rms over its last cycles; 0: unknown,
    double expected_deg = 0;         ///< and how far by the errors that it was made for, those of a wheel that is not known included.
    double pattern_deg = 0;          ///< Learned pattern, rms, without the teeth beside marks; 0: nothing learned,
    double beside_mark_deg = 0;      ///< and of the teeth beside marks that which is furthest from its place; late is above 0.
};

/// Reads firings in fuel cut.
class FuelCutReading {
  public:
    /// The ecu, which has that many cylinders, has just said a firing. `valid`: it is to be believed.
    void firing(const sd_ecu_t &ecu, std::uint32_t cylinders, double torque_nm, bool valid);
    void add_to(Evidence &evidence) const;

  private:
    std::uint32_t without_fuel_ = 0; ///< Firings in a row.
    int firings_ = 0;
    double nm_ = 0, bar_ = 0, exponent_ = 0;
};

/// What the ecu knows at the end of a run, beside those readings.
Evidence evidence_of(const sd_ecu_t &ecu, const sd_calibration_t &page);

} // namespace sixdeg
