// SPDX-License-Identifier: MIT
// A whole tooth: everything the ecu does from one crank edge to the next, each edge of a run timed by itself.
#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "cli/bench.hpp"
#include "cli/bench_drive.hpp"
extern "C" {
#include "sd_inproc.h"
}

namespace sixdeg {
namespace {

using Clock = std::chrono::steady_clock;

double us(Clock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); }

/// What looking at the clock costs by itself: the median of many looks.
double clock_us() {
    std::vector<double> looks;
    for (int i = 0; i < 1001; ++i) {
        const auto from = Clock::now();
        looks.push_back(us(Clock::now() - from));
    }
    std::nth_element(looks.begin(), looks.begin() + 500, looks.end());
    return looks[500];
}

/// Time of each edge of the run's second half, us, with the samples and clock events before it.
std::vector<double> edges_of_run(const sd_calibration_t &page, double look_us) {
    const auto ecu = std::make_unique<sd_ecu_t>();
    const auto wire = std::make_unique<sd_inproc_t>();
    if (sd_ecu_init(ecu.get(), &page) != SD_OK) throw std::logic_error("the bench's page was refused");
    const sd_port_t ecu_side = sd_inproc_ecu_side(wire.get()), host_side = sd_inproc_host_side(wire.get());
    std::vector<double> edges;
    double sum = 0;
    sd_event_t answers[64];
    for (const sd_event_t &event : bench_events()) {
        host_side.send(host_side.context, &event, 1);
        const auto from = Clock::now();
        sd_ecu_run(ecu.get(), &page, &ecu_side);
        sum += us(Clock::now() - from) - look_us;
        while (host_side.receive(host_side.context, answers, 64) > 0) {
        }
        if (event.kind == SD_EVENT_CRANK_EDGE) edges.push_back(sum), sum = 0;
    }
    return {edges.begin() + std::ptrdiff_t(edges.size() / 2), edges.end()};
}

} // namespace

ToothTime time_of_tooth(bool fixed_point, int repetitions) {
    const auto page = bench_page([&](sd_parameters_t &p) {
        p.torque_fixed_point = p.misfire_arithmetic = p.afr_arithmetic = fixed_point;
        p.misfire_method = float(SD_METHOD_FOLSMO);
        p.afr_method = float(SD_AFR_FOURIER);
    });
    const double look_us = clock_us();
    std::vector<std::vector<double>> runs;
    for (int i = 0; i < repetitions; ++i) runs.push_back(edges_of_run(*page, look_us));
    ToothTime time{0, 0};
    for (std::size_t edge = 0; edge < runs[0].size(); ++edge) {
        std::vector<double> takes;
        for (const auto &run : runs) takes.push_back(run[edge]);
        std::nth_element(takes.begin(), takes.begin() + std::ptrdiff_t(takes.size() / 2), takes.end());
        const double median = takes[takes.size() / 2];
        time.average_us += median / double(runs[0].size());
        time.worst_us = std::max(time.worst_us, median);
    }
    return time;
}

} // namespace sixdeg
