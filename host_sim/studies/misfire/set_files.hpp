// SPDX-License-Identifier: MIT
// The made set as files, so that anybody's detector can be scored on it (docs/results/misfire-study.md, section Files).
#pragma once
#include <string>

#include "common/files.hpp"
#include "studies/misfire/misfire_set.hpp"

namespace sixdeg {

/// Writes run after run into a folder; commit() of the folder makes them appear.
class SetWriter {
  public:
    /// An empty folder: nothing is written.
    explicit SetWriter(const std::string &folder);
    void add(const SetEngine &engine, const SetPoint &point, const SetRun &run, const EngineFile &file);
    void commit();

  private:
    std::unique_ptr<OutputFolder> out_;
    std::string runs_;
    int count_ = 0;
};

} // namespace sixdeg
