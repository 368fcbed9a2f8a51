// SPDX-License-Identifier: MIT
// A run whose ecu is another process at the other end of a bus.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "loop/bus_feed.hpp"
#include "loop/bench_run.hpp"

namespace sixdeg {

struct BusChoice {
    std::string transport;
    Pace pace;
    bool start_ecu = false; ///< Start one for the run; else one is there.
};

struct BusFigures {
    sd_port_counts_t counts{};
    std::size_t clock_events = 0, silences = 0, restarts = 0, missed = 0, dropped = 0;
    double took_s = 0, round_trip_p50_us = 0, round_trip_p99_us = 0;
};

RunResult run_on_bus(const BusChoice &choice, const Scenario &scenario, const sd_calibration_t &calibration,
                     RunTables *tables, const EventListener &listener, BusFigures &figures);

/// Of summary.json: counts only, no times.
nlohmann::ordered_json bus_json(const BusChoice &choice, const BusFigures &figures);
void print_bus(const BusFigures &figures, std::size_t unanswered);

} // namespace sixdeg
