// SPDX-License-Identifier: MIT
// What `sixdeg replay` shares between recordings and event logs.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/files.hpp"
#include "io/recording/guess.hpp"
#include "loop/replay.hpp"
#include "loop/replay_tables.hpp"

namespace sixdeg {

struct ReplayOptions {
    std::string file, wheel, edge, engine, tune, number, truth, out, json, cam, intake, fuel, lambda, load, learned, learn;
    std::string column, threshold, parity, time_unit, pressure;
    std::vector<std::string> set;
};

/// The part of summary.json that both have: edges to rpm_last.
nlohmann::ordered_json figures_json(const ReplayResult &result);
nlohmann::ordered_json decoder_json(const ReplayResult &result);
nlohmann::ordered_json misfire_json(const ReplayResult &result, const std::vector<int> &firing_order);
void print_counts(const ReplayResult &result);

/// The tables of a replay, where the options want them: on their way to the disk, or nowhere.
class ReplayOutput {
  public:
    ReplayOutput(const ReplayOptions &options, const ReplayEngine &engine);
    ReplaySink &sink() { return tables_ ? static_cast<ReplaySink &>(*tables_) : nowhere_; }
    /// The summary beside them; everything appears at once.
    void commit(const nlohmann::ordered_json &summary);

  private:
    const ReplayOptions &options_;
    std::optional<OutputFolder> folder_;
    std::optional<ReplayTables> tables_;
    ReplaySink nowhere_;
};

/// What a recording is found to be.
struct FoundRecording {
    Guess guess;
    TextLayout layout;
    double origin_s = 0;     ///< Of the recording's times, in the file's.
    std::vector<std::string> two_level; ///< Labels of columns beside the crank's that change level.
};
/// What the options and, where one is given, the engine file say of a recording. Throws InputError.
Constraints recording_constraints(const ReplayOptions &options, const TextLayout &layout, const EngineFile *engine);
/// Reads the file, a stretch after the other, until one shows the wheel. Throws InputError.
FoundRecording find_recording(const std::string &file, const Constraints &known);

/// Of a recording without a cam: which revolution in sync begins the cycle, 0 or 1, where the teeth tell, and a sentence on it.
struct ParityFound {
    std::optional<int> parity;
    std::string note;
};
ParityFound find_parity(const std::string &file, const Guess &guess, const EngineFile &engine, double stall_s);

/// Stands for the pressure in a cylinder among the inputs; the ecu has none.
constexpr int kPressureInput = kLoadInput - 1;
/// --intake and its like. Throws InputError naming the option.
std::vector<SensorSource> sensor_sources(const ReplayOptions &options, const TextLayout &layout, double stoichiometric);
/// FILE or FILE:COLUMN, where such a file exists.
struct FileSource {
    std::string file, column; ///< Column as text; empty: not said.
};
std::optional<FileSource> file_source(const std::string &text);
/// --cam: a column of the recording, its number or name, or another file. Throws InputError.
void set_cam(const std::string &text, const TextLayout &layout, const std::string &from, Constraints &known);
/// Column that a text names: its number from 0, or its name in the header. Throws InputError naming `from`.
int column_named(const std::string &text, const TextLayout &layout, const std::string &from);

/// What a user should know of a recording, one sentence each.
std::vector<std::string> notes_of(const FoundRecording &found);
std::vector<std::string> cam_notes(const FoundRecording &found, const EngineFile &engine, const ReplayResult &result);
/// Why a recording could not be followed, or nothing: it never synced, or for less than half of the time.
std::optional<std::string> why_not_followed(const FoundRecording &found, const ReplayResult &result);
/// Where in the revolution the telling edge of the cam lies, crank angle modulo 360 deg.
double cam_place_deg(const CamGuess &cam, const EngineFile &engine);
/// The same as a position of the wheel.
double cam_position(const CamGuess &cam, const Wheel &wheel);

/// The command for an event log.
void replay_event_log(const ReplayOptions &options);

} // namespace sixdeg
