// SPDX-License-Identifier: MIT
// The event log, .sdlog: everything that crossed a port, in order, and the calibration page it was made with.
//
//     LogWriter log("run.sdlog", about, calibration);
//     bench.listen([&](bool out, const sd_event_t &event) { log.add(out, event); });
//     ...
//     log.finish();                                   // only now is there a run.sdlog
//
//     const EventLog log = read_log("run.sdlog");     // or one line that says what is wrong with it
//
// The format, field by field: docs/reference/log.md.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

extern "C" {
#include "hal.h"
#include "sd_calibration.h"
}

namespace sixdeg {

/// In `kind` of a logged event: it came out of the ecu.
constexpr std::uint16_t kLoggedOut = 0x8000;

class LogWriter {
  public:
    /// `about` is JSON, for people and exports; nothing of it is needed to replay. Throws InputError when the
    /// file cannot be written. "-" is standard output: then the log goes out as it grows, and what finish() did not end lacks its
    /// checksum.
    LogWriter(std::filesystem::path path, const std::string &about, const sd_calibration_t &calibration);
    /// Without finish() nothing stays.
    ~LogWriter();
    LogWriter(const LogWriter &) = delete;
    LogWriter &operator=(const LogWriter &) = delete;

    void add(bool out, const sd_event_t &event);
    /// Closes the file and renames it into place. Throws InputError.
    void finish();

  private:
    struct File;
    std::unique_ptr<File> file_;
};

struct EventLog {
    std::string about; ///< JSON, as it was given.
    sd_calibration_t calibration;
    std::vector<sd_event_t> events; ///< In order; kLoggedOut tells the direction.
};

/// True when the file begins as a log does.
bool is_log(const std::filesystem::path &path);

/// Throws InputError: not a log, truncated or damaged, or of another signal table.
EventLog read_log(const std::filesystem::path &path);

} // namespace sixdeg
