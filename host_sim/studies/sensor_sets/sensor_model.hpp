// SPDX-License-Identifier: MIT
// MODEL.toml: which state depends on which, what each sensor sees, and how that changes with the operating
// regime. Field by field: docs/theory/sensors.md.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/toml_file.hpp"

namespace sixdeg {

/// A set of sensors: bit i is sensor i of the model.
using SensorSet = std::uint32_t;

/// What one quantity depends on: states directly, and shared quantities that stand in several equations.
struct Links {
    std::vector<int> states, shared;
};

/// All links of the model in one regime. Shared quantity i may depend on shared quantities before it only.
struct Structure {
    std::vector<Links> shared, states, sensors;
};

struct Regime {
    std::string name;
    Structure structure;
};

struct Sensor {
    std::string name;
    std::vector<double> lags_s; ///< Time constants of the sensor's own first-order lags in series, in s.
    double cost = 1;
    double noise = 0; ///< Standard deviation of one sample, SI unit of the sensor; 0 = not given.
};

/// An index somebody published for a set of sensors, to print beside ours.
struct PublishedIndex {
    SensorSet set;
    int index; ///< 0 = published as not observable.
};

struct SensorModel {
    std::string name;
    std::vector<std::string> states, shared;
    std::vector<Sensor> sensors;
    std::vector<Regime> regimes;      ///< The first holds every link; each other one lacks some.
    std::vector<int> targets;         ///< States wanted when the user names none.
    std::vector<SensorSet> forbidden; ///< Combinations that no set may contain.
    std::vector<PublishedIndex> published;

    /// State number of each name. Throws InputError that names `from` when one is unknown or named twice.
    std::vector<int> find_states(const std::vector<std::string> &names, const std::string &from) const;
    std::vector<std::string> sensor_names(SensorSet set) const;
    double cost(SensorSet set) const;
};

/// Reads all but "numeric", which read_numeric_model() reads. Call file.finish() afterwards.
SensorModel read_sensor_model(TomlFile &file);

} // namespace sixdeg
