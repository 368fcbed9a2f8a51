// SPDX-License-Identifier: MIT
// sixdeg replay: what a recording is, and what a user should know of it.
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/replay_command.hpp"
#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr std::size_t kStretchCells = std::size_t(3) << 20; // 24 MB; whoever records faster waits longer for the first revolution
constexpr double kFarDeg = 45, kOffDeg = 10; // The decoder takes a cam edge so far from its place; half a usual tooth is nothing.
constexpr double kMovedDeg = 12;
constexpr std::size_t kFaultsMost = 5; // One edge in so many: more is no recording of this wheel, or its angle slips.

const char *unit_name(double unit_s) {
    return unit_s == 1 ? "s" : unit_s == 1e-3 ? "ms" : unit_s == 1e-6 ? "us" : unit_s == 1e-9 ? "ns" : "rows";
}

std::vector<std::string> two_level_columns(const Recording &stretch, const Guess &guess) {
    std::vector<std::string> labels;
    for (int column = 0; column <= stretch.last_column(); ++column) {
        if (column == guess.column || (guess.home && column == guess.home->column)) continue;
        if ((guess.cam && guess.cam->file.empty() && column == guess.cam->column) || !stretch.layout.is_signal(std::size_t(column)))
            continue;
        if (stretch.bad_cells[std::size_t(column)].line == 0 && column_kind(stretch, column) == ColumnKind::level)
            labels.push_back(column_label(stretch, column));
    }
    return labels;
}

double number_option(const std::string &text, const char *option) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && end == text.data() + text.size() && std::isfinite(value)) return value;
    throw InputError(option, "", fmt::format("'{}' is not a number", text));
}

} // namespace

Constraints recording_constraints(const ReplayOptions &options, const TextLayout &layout, const EngineFile *engine) {
    Constraints known;
    if (!options.wheel.empty()) known.wheel = parse_wheel_text(options.wheel, "--wheel");
    if (!options.edge.empty()) known.edge = parse_edge(options.edge, "--edge");
    if (!options.column.empty()) known.column = column_named(options.column, layout, options.file + ": --column");
    if (!options.cam.empty()) set_cam(options.cam, layout, options.file + ": --cam", known);
    if (!options.threshold.empty()) known.threshold = number_option(options.threshold, "--threshold");
    if (!options.time_unit.empty()) {
        known.unit_s = number_option(options.time_unit, "--time-unit");
        if (!(*known.unit_s >= 1e-12 && *known.unit_s <= 1e3)) throw InputError("--time-unit", "", "is outside [1e-12, 1000] s");
    }
    if (engine && !known.wheel) known.engine_wheel = engine->wheel;
    if (engine && engine->has_cam) {
        const double turns = (engine->cam_edge_deg - engine->position_0_deg) / 360;
        known.cam_place_rev = turns - std::floor(turns);
    }
    if (engine && !known.edge) known.edge = engine->falling_edge ? Edge::falling : Edge::rising;
    return known;
}

FoundRecording find_recording(const std::string &file, const Constraints &known) {
    std::error_code ec;
    if (std::filesystem::exists(file, ec) && !std::filesystem::is_regular_file(file, ec) && !std::filesystem::is_directory(file, ec))
        throw InputError(file, "", "is no regular file, and it is read twice; save the recording first");
    RowReader reader{std::filesystem::path(file)};
    std::optional<InputError> first;
    for (;;) {
        const Recording stretch = read_stretch(reader, kStretchCells);
        if (stretch.rows() == 0) {
            if (first) throw *first;
            throw InputError(file, "", "is empty; rows of time in s and, after it, levels or voltages are wanted");
        }
        try {
            FoundRecording found{guess(stretch, known), stretch.layout, 0, {}};
            found.origin_s = stretch.origin.value() * found.guess.unit_s;
            found.two_level = two_level_columns(stretch, found.guess);
            std::vector<double>().swap(found.guess.time);
            if (found.guess.cam) std::vector<double>().swap(found.guess.cam->time);
            return found;
        } catch (const InputError &error) {
            if (!first) first = error;
        }
    }
}

std::vector<std::string> notes_of(const FoundRecording &found) {
    const Guess &guess = found.guess;
    std::vector<std::string> notes;
    if (!guess.runner_up.empty()) notes.push_back("next best reading: " + guess.runner_up);
    if (guess.home)
        notes.push_back(fmt::format("the one tooth in column {} comes every {} teeth, once {}; the tooth before it is left out: decoded "
                                    "as {}",
                                    guess.home->column, guess.wheel.positions * (guess.home->on_cam ? 2 : 1),
                                    guess.home->on_cam ? "in two revolutions" : "a revolution", describe(guess.wheel)));
    else if (guess.tooth_added) notes.push_back("the added tooth and the one behind it are left out: decoded as " + describe(guess.wheel));
    if (guess.unit_given) notes.push_back(fmt::format("time is in units of {:g} s, as --time-unit says", guess.unit_s));
    else if (found.layout.counts_time)
        notes.push_back(fmt::format("the times count rows or ticks, and nothing says how long one takes: {} is a guess, and speed with it; "
                                    "--time-unit gives it",
                                    unit_name(guess.unit_s)));
    else if (guess.unit_guessed)
        notes.push_back(
            fmt::format("the header names no unit of time: {} is taken, seconds would be no engine's", unit_name(guess.unit_s)));
    else if (guess.unit_s != 1) notes.push_back(fmt::format("time is in {}, as the header says", unit_name(guess.unit_s)));
    if (found.layout.is_interval) notes.push_back("the rows hold intervals from edge to edge; times are their sums");
    if (guess.rpm > 20000 || (guess.rpm < 10 && guess.rpm > 0))
        notes.push_back(fmt::format("{:.4g} rpm is no engine's speed: is the unit of time wrong?", guess.rpm));
    if (found.origin_s != 0) notes.push_back(fmt::format("time is shifted: 0 s here is {:.6f} s in the file", found.origin_s));
    if (!guess.is_edge_times && !guess.slicing.is_level) {
        notes.push_back(guess.slicing.follow
                            ? fmt::format("threshold half-way within every {} rows: the voltage drifts", guess.slicing.follow)
                            : fmt::format("threshold {:.4g}, {}", guess.slicing.threshold, guess.slicing.name));
    }
    if (guess.weak_tooth) notes.push_back("a tooth of each revolution is weak: half-way between the levels it would be missed");
    return notes;
}

double cam_position(const CamGuess &cam, const Wheel &wheel) {
    const double tooth = cam.place_rev * wheel.teeth();
    int left = int(tooth), position = 0;
    for (;; ++position) {
        const bool missing = std::binary_search(wheel.missing.begin(), wheel.missing.end(), position);
        if (!missing && left-- == 0) break;
    }
    return position + tooth - std::floor(tooth);
}

double cam_place_deg(const CamGuess &cam, const EngineFile &engine) {
    return std::fmod(engine.position_0_deg + cam_position(cam, engine.wheel) * 360 / engine.wheel.positions, 360);
}

std::vector<std::string> cam_notes(const FoundRecording &found, const EngineFile &engine, const ReplayResult &result) {
    std::vector<std::string> notes;
    if (!found.guess.cam) {
        if (!found.two_level.empty())
            notes.push_back(
                fmt::format("{} has no edge that comes once in two revolutions, so it tells no phase", fmt::join(found.two_level, ", ")));
        return notes;
    }
    const CamGuess &cam = *found.guess.cam;
    if (cam.teeth > 1)
        notes.push_back(fmt::format("the cam in column {}{} has {} edges a cycle; the one that no other is opposite to tells the phase",
                                    cam.column, cam.file.empty() ? "" : " of " + cam.file, cam.teeth));
    if (cam.moved_rev * 360 > kMovedDeg)
        notes.push_back(fmt::format("the cam moves: its edge wanders by {:.0f} deg of crank", cam.moved_rev * 360));
    if (!engine.has_cam) return notes;
    const double place = cam_place_deg(cam, engine), off = std::remainder(place - engine.cam_edge_deg, 360);
    if (std::abs(off) > kOffDeg) {
        notes.push_back(fmt::format("cam.edge_deg is {:g} in the engine file, the recording has the edge at {:.0f} or {:.0f} deg{}",
                                    engine.cam_edge_deg, place, place + 360,
                                    std::abs(off) > kFarDeg ? ": too far off, its edges are rejected" : ""));
    }
    const std::size_t rejected = result.counts.cam_rejected;
    if (rejected > 0)
        notes.push_back(fmt::format("{} of {} cam edges were rejected{}", rejected, result.cam_edges,
                                    rejected * 5 > result.cam_edges ? "; the angle may be 360 deg off" : ""));
    if (result.phased_s < 0.5 * result.synced_s)
        notes.push_back(fmt::format("the phase was known for {:.0f} % of the time in sync: cylinders are mostly invalid",
                                    result.synced_s > 0 ? 100 * result.phased_s / result.synced_s : 0));
    return notes;
}

std::optional<std::string> why_not_followed(const FoundRecording &found, const ReplayResult &result) {
    const std::size_t faults = result.counts.coasted + result.counts.spurious;
    if (result.first_sync_edge && result.synced_s >= 0.5 * result.turned_s) {
        if (faults * kFaultsMost < result.edges) return std::nullopt;
        return fmt::format("{} faults in {} edges, through which no angle is sure: edges are missing, added or uneven", faults,
                           result.edges);
    }
    const double turns = found.guess.wheel.teeth() > 0 ? double(result.edges) / found.guess.wheel.teeth() : 0;
    std::string why;
    if (turns < 5)
        why = fmt::format("the recording is short, {:.1f} revolutions, and two passes of the marks go by before the angle is known", turns);
    else if (found.guess.rpm > 20000 || found.guess.rpm < 10)
        why = fmt::format("{:.4g} rpm is no engine's speed: is the unit of time wrong?", found.guess.rpm);
    else if (found.guess.consistent_revolutions < 0.5 * turns)
        why = fmt::format("only {} of {:.0f} revolutions have their marks where they belong: edges are missing, added or uneven",
                          found.guess.consistent_revolutions, turns);
    else
        why = fmt::format("{} losses of sync, {} teeth missing and {} edges left out", result.counts.sync_losses, result.counts.coasted,
                          result.counts.spurious);
    return result.first_sync_edge ? fmt::format("synced for {:.0f} % of the time only: {}", 100 * result.synced_s / result.turned_s, why)
                                  : "never synced: " + why;
}

} // namespace sixdeg
