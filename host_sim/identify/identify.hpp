// SPDX-License-Identifier: MIT
// What a recording tells of an engine: each number with its 95 % interval, or why the recording cannot tell it.
//
//     const Identified found = identify(engine, record, {});
//     if (found.inertia_kgm2.told()) use(found.inertia_kgm2.value, found.inertia_kgm2.half_width);
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "identify/crank_record.hpp"

namespace sixdeg {

/// A number, or why there is none.
struct Found {
    double value = std::numeric_limits<double>::quiet_NaN();
    double half_width = std::numeric_limits<double>::infinity(); ///< Of the 95 % interval about it.
    std::string refused;                                         ///< Why the data do not tell it; empty where they do.
    bool told() const { return refused.empty(); }
};

/// Load and friction together, at about one speed.
struct DragAt {
    double rpm;
    bool motored; ///< Without combustion.
    std::vector<TimeWindow> cycles; ///< When each of those ran that it is the mean of.
    Found nm;             ///< Refused where the inertia is.
    Found over_inertia;   ///< rad/s2
};

struct Identified {
    std::size_t cycles = 0, motored = 0, used = 0; ///< Whole ones in the recording; without combustion; that the numbers rest on.
    Found inertia_kgm2;      ///< J0.
    Found position_0_deg;    ///< Crank angle of the first tooth after the mark, modulo 360.
    Found compression_0_deg; ///< The same by where compression is polytropic: by the pressure alone, whatever acts on the crank.
    Found exponent;          ///< Of compression, p V^n.
    Found compression_share; ///< Torque of compression over J0, over what the engine file says. Told where the inertia is not.
    std::vector<Found> pattern_deg; ///< By position: how much further on a tooth stands; mean 0. Positions without a tooth are refused.
    std::vector<DragAt> drag;       ///< Firing ones first, then by speed.
    double scatter_deg = 0;         ///< Of a single tooth.
    double unexplained_deg = 0;     ///< Rms of what repeats from cycle to cycle without being explained.
    double unexplained_percent = 0; ///< Torque of low orders that is needed and not explained, of the gas torque's rms.
    std::string pattern_refused;    ///< Why there is no pattern at all.
    std::size_t pattern_cycles = 0; ///< That the pattern rests on.
    bool pattern_by_exchange = false; ///< From the gas exchange of a single cylinder, and not from whole cycles.
};

struct IdentifyOptions {
    std::vector<TimeWindow> motored; ///< Stretches without combustion, beside those in which the record's fuel is 0.
};

/// Throws InputError naming `from` where the record holds too little to begin with.
Identified identify(const EngineFile &engine, const CrankRecord &record, const IdentifyOptions &options, const std::string &from);

} // namespace sixdeg
