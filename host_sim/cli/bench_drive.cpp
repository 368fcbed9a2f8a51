// SPDX-License-Identifier: MIT
#include "cli/bench_drive.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

#include "loop/bench_run.hpp"
#include "loop/ecu_bench.hpp"

namespace sixdeg {
namespace {

/// Keeps what is sent.
class Recorder : public EcuBench {
  public:
    using EcuBench::EcuBench;
    void send(const sd_event_t &event) override {
        events.push_back(event);
        exchange(event);
    }
    std::vector<sd_event_t> events;
};

const Scenario &scenario() {
    static const Scenario made = [] {
        TomlFile file("bench", "engine = \"diesel_22.toml\"\n[run]\ncycles = 60\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 9\n"
                               "[encoder]\njitter_deg = 0.01\n[cylinders]\nfuel_percent = [6, -3, 0, -4]\n[uego]\n");
        return read_scenario(file, SD_DATA "/engines");
    }();
    return made;
}

/// Made once: a calibration costs a thousand times what is timed here.
const sd_calibration_t &plain_page() {
    static const auto made = [] {
        TomlFile usual("bench", "");
        return std::make_unique<sd_calibration_t>(calibrate(scenario().engine.shared, read_tune(usual), "bench"));
    }();
    return *made;
}

} // namespace

std::unique_ptr<sd_calibration_t> bench_page(const BenchTune &tune) {
    auto page = std::make_unique<sd_calibration_t>(plain_page());
    if (tune) tune(page->parameters);
    return page;
}

const std::vector<sd_event_t> &bench_events() {
    static const std::vector<sd_event_t> made = [] {
        const auto recorder = std::make_unique<Recorder>(plain_page());
        run_scenario(scenario(), plain_page(), *recorder, nullptr);
        return recorder->events;
    }();
    return made;
}

const WarmEcu &warm_ecu(const BenchTune &tune) {
    static std::map<std::string, WarmEcu> made;
    auto page = bench_page(tune);
    WarmEcu &warm = made[std::string(reinterpret_cast<const char *>(&page->parameters), sizeof page->parameters)];
    if (warm.ecu) return warm;
    warm = {std::move(page), std::make_unique<sd_ecu_t>()};
    if (sd_ecu_init(warm.ecu.get(), warm.page.get()) != SD_OK) throw std::logic_error("the bench's page was refused");
    const auto wire = std::make_unique<sd_inproc_t>();
    const sd_port_t ecu_side = sd_inproc_ecu_side(wire.get()), host_side = sd_inproc_host_side(wire.get());
    sd_event_t answers[64];
    for (const sd_event_t &event : bench_events()) {
        host_side.send(host_side.context, &event, 1);
        sd_ecu_run(warm.ecu.get(), warm.page.get(), &ecu_side);
        while (host_side.receive(host_side.context, answers, 64) > 0) {
        }
    }
    return warm;
}

const std::vector<sd_tooth_t> &bench_teeth() {
    static const std::vector<sd_tooth_t> made = [] {
        const auto page = bench_page();
        const sd_crank_config_t config = sd_calibration_crank(page.get(), &page->parameters);
        sd_crank_t crank;
        sd_crank_init(&crank, &config);
        std::vector<sd_tooth_t> all;
        for (const sd_event_t &event : bench_events()) {
            sd_tooth_t tooth;
            if (event.kind == SD_EVENT_CAM_EDGE) sd_crank_cam_edge(&crank, event.tick);
            if (event.kind != SD_EVENT_CRANK_EDGE) continue;
            sd_crank_edge(&crank, event.tick, &tooth);
            if (tooth.phase_known) all.push_back(tooth);
        }
        const auto begins = [](const sd_tooth_t &tooth) { return tooth.cycle_position == 0; };
        const auto last = std::find_if(all.rbegin(), all.rend(), begins).base() - 1;
        const auto first = std::find_if(std::make_reverse_iterator(last), all.rend(), begins).base() - 1;
        return std::vector<sd_tooth_t>(first, last);
    }();
    return made;
}

} // namespace sixdeg
