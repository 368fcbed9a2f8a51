// SPDX-License-Identifier: MIT
// sixdeg replay --intake, --fuel, --lambda, --load, --cam: a constant, a column of the recording, or another file.
#include <charconv>
#include <filesystem>
#include <fmt/format.h>

#include "cli/replay_command.hpp"
#include "common/error.hpp"
#include "common/nearest.hpp"

namespace sixdeg {
namespace {

struct Sensor {
    const char *option;
    int input; ///< sd_input_t, or kLoadInput
    const std::string ReplayOptions::*text;
};
constexpr Sensor kSensors[] = {{"--intake", SD_INPUT_AIR_INTAKE_PRESSURE, &ReplayOptions::intake},
                               {"--fuel", SD_INPUT_FUEL_INJECTED, &ReplayOptions::fuel},
                               {"--lambda", SD_INPUT_EXHAUST_LAMBDA, &ReplayOptions::lambda},
                               {"--load", kLoadInput, &ReplayOptions::load},
                               {"--pressure", kPressureInput, &ReplayOptions::pressure}};
constexpr double kLoadMost_nm = 20000;

std::string lower(const std::string &text) {
    std::string out;
    for (char c : text) out += c >= 'A' && c <= 'Z' ? char(c + 'a' - 'A') : c;
    return out;
}

/// From the unit that a header names to that of the sensor.
double scale_of(const std::string &name, int input, double stoichiometric) {
    const std::string text = lower(name);
    const auto has = [&](const char *word) { return text.find(word) != std::string::npos; };
    if (input == SD_INPUT_AIR_INTAKE_PRESSURE || input == kPressureInput)
        return has("kpa") ? 0.01 : has("mbar") || has("hpa") ? 0.001 : has("psi") ? 0.0689476 : 1;
    if (input == SD_INPUT_EXHAUST_LAMBDA && has("afr")) return 1 / stoichiometric;
    return 1;
}

std::optional<double> number_in(const std::string &text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && end == text.data() + text.size()) return value;
    return std::nullopt;
}

/// Without a column the first that is no time.
SensorSource from_file(const FileSource &where, const Sensor &sensor, double stoichiometric) {
    SensorSource source;
    source.input = sensor.input;
    source.file = where.file;
    const RowReader reader{std::filesystem::path(source.file)};
    const TextLayout &layout = reader.layout();
    if (!where.column.empty()) source.column = column_named(where.column, layout, sensor.option);
    for (std::size_t j = 0; where.column.empty() && source.column < 0 && j < layout.names.size(); ++j)
        if (layout.is_signal(j)) source.column = int(j);
    if (source.column < 0) throw InputError(source.file, sensor.option, "holds no column of readings beside the time");
    source.scale = scale_of(layout.names[std::size_t(source.column)], sensor.input, stoichiometric);
    protect_input(source.file);
    return source;
}

SensorSource constant(double value, const Sensor &sensor) {
    const bool load = sensor.input == kLoadInput;
    const double low = load ? -kLoadMost_nm : double(sd_input_infos[sensor.input].low);
    const double high = load ? kLoadMost_nm : double(sd_input_infos[sensor.input].high);
    if (!(value >= low && value <= high)) {
        throw InputError(sensor.option, "",
                         fmt::format("{:g} is outside [{:g}, {:g}] {}", value, low, high, load ? "Nm" : sd_input_infos[sensor.input].unit));
    }
    SensorSource source;
    source.input = sensor.input;
    source.constant = value;
    return source;
}

/// "column:N" says that N is one.
std::string without_prefix(const std::string &text) { return text.rfind("column:", 0) == 0 ? text.substr(7) : text; }

} // namespace

std::optional<FileSource> file_source(const std::string &text) {
    std::error_code ec;
    if (std::filesystem::is_regular_file(text, ec)) return FileSource{text, ""};
    const auto colon = text.rfind(':');
    if (colon == std::string::npos || !std::filesystem::is_regular_file(text.substr(0, colon), ec)) return std::nullopt;
    return FileSource{text.substr(0, colon), text.substr(colon + 1)};
}

void set_cam(const std::string &text, const TextLayout &layout, const std::string &from, Constraints &known) {
    const auto other = number_in(text) ? std::nullopt : file_source(text);
    if (!other) {
        known.cam_column = column_named(without_prefix(text), layout, from);
        return;
    }
    known.cam_file = other->file;
    const RowReader reader{std::filesystem::path(other->file)};
    if (!other->column.empty()) known.cam_column = column_named(other->column, reader.layout(), from);
    protect_input(other->file);
}

int column_named(const std::string &text, const TextLayout &layout, const std::string &from) {
    for (std::size_t j = 0; j < layout.names.size(); ++j)
        if (!text.empty() && layout.names[j] == text) return int(j);
    int column = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), column);
    if (error == std::errc{} && end == text.data() + text.size() && column >= 0 && column < int(layout.names.size())) return column;
    std::string names;
    for (const std::string &name : layout.names) names += (names.empty() ? "" : ", ") + name;
    throw InputError(from, "",
                     fmt::format("'{}' is no column: 0 to {}, or a name of the header ({}){}", text, layout.names.size() - 1, names,
                                 nearest_hint(text, layout.names)));
}

std::vector<SensorSource> sensor_sources(const ReplayOptions &options, const TextLayout &layout, double stoichiometric) {
    std::vector<SensorSource> sources;
    for (const Sensor &sensor : kSensors) {
        const std::string &text = options.*(sensor.text);
        if (text.empty()) continue;
        const auto value = number_in(text);
        if (value && sensor.input != kPressureInput) { // a pressure that stands still tells nothing: a number is its column
            sources.push_back(constant(*value, sensor));
        } else if (const auto other = file_source(text)) {
            sources.push_back(from_file(*other, sensor, stoichiometric));
        } else {
            SensorSource source;
            source.input = sensor.input;
            source.column = column_named(without_prefix(text), layout, sensor.option);
            source.scale = scale_of(layout.names[std::size_t(source.column)], sensor.input, stoichiometric);
            sources.push_back(source);
        }
    }
    return sources;
}

} // namespace sixdeg
