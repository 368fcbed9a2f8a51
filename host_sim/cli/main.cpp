// SPDX-License-Identifier: MIT
// sixdeg: exit status 0 done, 1 a fault of ours, 2 bad input or usage (one line says which file, field and range),
// 3 a recording that could not be followed (one line says why).
#include <algorithm>
#include <cstdio>
#include <string>

#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"

namespace {

/// Whether an argument asks for a file on standard output: "-", or "--option=-".
bool writes_to_standard_output(int argc, char **argv) {
    return std::any_of(argv + 1, argv + argc, [](const std::string &word) {
        return word == "-" || (word.rfind("--", 0) == 0 && word.size() > 2 && word.substr(word.size() - 2) == "=-");
    });
}

} // namespace

int main(int argc, char **argv) {
    const auto commands = [](sixdeg::Command &app) {
        sixdeg::add_replay(app);
        sixdeg::add_run(app);
        sixdeg::add_sweep(app);
        sixdeg::add_plant(app);
        sixdeg::add_ecu(app);
        sixdeg::add_watch(app);
        sixdeg::add_parameter(app);
        sixdeg::add_calibrate(app);
        sixdeg::add_identify(app);
        sixdeg::add_sensors(app);
        sixdeg::add_study(app);
        sixdeg::add_bench(app);
    };
    try {
        if (writes_to_standard_output(argc, argv)) sixdeg::keep_standard_output_for_files();
        return sixdeg::run_command_line("sixdeg: see inside every cylinder from the sensors a production engine already has", commands,
                                        argc, argv);
    } catch (const sixdeg::InputError &error) {
        std::fprintf(stderr, "sixdeg: %s\n", error.what());
        return 2;
    } catch (const sixdeg::NotFollowed &error) {
        std::fprintf(stderr, "sixdeg: %s\n", error.what());
        return 3;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "sixdeg: internal fault: %s\n", error.what());
        return 1;
    }
}
