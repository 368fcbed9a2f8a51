// SPDX-License-Identifier: MIT
#include "studies/airpath/full_parts.hpp"

#include <filesystem>
#include <fmt/format.h>

#include "common/files.hpp"
#include "design/airpath/airpath_tables.hpp"
#include "studies/airpath/full_fit.hpp"
#include "studies/airpath/full_study.hpp"
#include "studies/airpath/model_error.hpp"

extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {
namespace {

const std::string kModels = std::string(SD_DATA) + "/models/";

PlantEngine engine() { return read_plant_engine(std::filesystem::path(SD_DATA) / "engines" / "cat_3126b.toml"); }

/// Of the table of parameters.
float usual(const std::string &name) {
    for (const sd_signal_info_t &info : sd_parameter_infos)
        if (name == info.name) return info.value;
    return 0;
}

} // namespace

void print_full(const std::string &design, int runs, unsigned seed) {
    const PlantEngine e = engine();
    TomlFile file{std::filesystem::path(design.empty() ? kModels + "airpath_3126b_design.toml" : design)};
    const sd_airpath_tables_f32_t tables = read_air_path_design(file, *e.shared.air_path, e.displacement_m3()).tables;
    const auto steps = [&](const char *name) { return std::uint32_t(usual(name) / tables.period_s + 0.5f); };
    const sd_airpath_config_f32_t config{steps("airpath.settle_time"), steps("airpath.offset_window"),
                                        {usual("airpath.detect_threshold"), usual("airpath.isolate_threshold")}};
    print_full_study({e, tables, config, runs, seed});
}

void print_model_error(const std::string &folder) {
    const auto rows = model_drive(engine());
    fmt::print("\nfour-state model beside the full air path, on a drive that nothing was fitted to: mean and largest error of the mean\n");
    for (const ModelError &error : model_errors(rows))
        fmt::print("  {:<24}{:.2f} %  {:.2f} %\n", error.name, error.mean_percent, error.largest_percent);
    if (folder.empty()) return;
    std::filesystem::create_directories(folder);
    write_file(folder + "/figures_4_to_7.csv", model_csv(rows));
}

void print_fit() { fmt::print("\n{}", fit_air_path(engine())); }

} // namespace sixdeg
