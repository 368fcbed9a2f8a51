// SPDX-License-Identifier: MIT
// Pages of engines and tunes seen before, kept in a folder, so that a run need not design its page anew.
#pragma once
#include <filesystem>
#include <string>

#include "design/calibration.hpp"

namespace sixdeg {

class KeptPages {
  public:
    /// Where $XDG_CACHE_HOME or $HOME says: the folder sixdeg in it, or in ~/.cache. Empty, which keeps nothing, without either.
    static std::filesystem::path usual_folder();

    /// An empty folder name keeps nothing. A folder that is missing is made with its first page.
    explicit KeptPages(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// As calibrate(engine, tune, tune_name), where `engine_text` is the whole text that `engine` was read from. A page is used
    /// again for the same text, tune and program file; one that is damaged, or that cannot be read or written, is as if it were
    /// not there. Of more than 64 pages those unused for longest go. Processes may share a folder.
    sd_calibration_t calibrate(const EngineFile &engine, const std::string &engine_text, const sd_parameters_t &tune,
                               const std::string &tune_name) const;

  private:
    std::filesystem::path folder_;
};

} // namespace sixdeg
