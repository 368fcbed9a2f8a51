// SPDX-License-Identifier: MIT
// From an engine file and a tune to the firmware's calibration page.
#pragma once
#include <string>
#include <vector>

#include "common/engine_file.hpp"
#include "io/page/page_bytes.hpp"
extern "C" {
#include "sd_calibration.h"
}

namespace sixdeg {

/// TUNE.toml: each field is a parameter of hal/signals.toml, with its range; what is missing is taken from
/// `otherwise`, or has its default without one. Throws InputError naming file, field and range.
sd_parameters_t read_tune(TomlFile &tune, const sd_parameters_t *otherwise = nullptr);

/// J(alpha) of the crank train, kg m2: constant part and the reciprocating masses as seen from the crank pin
/// (equations of document 004; Kiencke-Nielsen). alpha in rad, 0 = firing TDC of the first cylinder.
double crank_inertia_kgm2(const EngineFile &engine, double alpha);

/// The part of it that one entry of firing_order moves.
double reciprocating_inertia_kgm2(const EngineFile &engine, std::size_t lane, double alpha);

/// The parameters with what they leave to the engine filled in: torque.harmonics, torque.torque_base.
sd_parameters_t resolve(const EngineFile &engine, sd_parameters_t tune);

/// Largest eigenvalue, by magnitude, of the torque observer's error over one cycle, missing teeth included: below 1
/// it converges, and its error shrinks by that factor a cycle. `tune` is resolved.
double observer_radius(const EngineFile &engine, const sd_parameters_t &tune);

/// The page. Throws InputError naming `tune_name` and the field when the gains do not converge, or engine and
/// parameters cannot be initialised together.
sd_calibration_t calibrate(const EngineFile &engine, const sd_parameters_t &tune, const std::string &tune_name);

/// The page as a C array `sd_calibration_page`, for a target without files.
std::string page_source(const std::vector<std::uint8_t> &bytes, const std::string &engine_name);

} // namespace sixdeg
