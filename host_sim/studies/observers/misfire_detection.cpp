// SPDX-License-Identifier: MIT
#include "studies/observers/misfire_detection.hpp"

#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "design/calibration.hpp"
#include "studies/observers/input_wheel.hpp"

namespace sixdeg {
namespace {

constexpr double kRampShare = 0.2, kRampS = 4;

/// What the plant did and what the ecu was given, of the run that is repeated.
class Record : public TruthSink {
  public:
    struct Edge {
        std::uint32_t tick;
        double crank_deg;
    };
    void edge(const EncoderEdge &edge, double crank_deg) override { edges.push_back({edge.tick, crank_deg}); }
    void cycle(const CycleTruth &cycle) override { cycles.push_back(cycle); }
    EventListener listener() {
        return [this](bool out, const sd_event_t &event) {
            if (!out) events.push_back(event);
        };
    }
    std::vector<Edge> edges;
    std::vector<CycleTruth> cycles;
    std::vector<sd_event_t> events;
};

/// What one method said of each firing, in order.
struct Verdicts {
    std::vector<int> verdict;
    MisfireFigures figures;
};

/// Takes verdicts in the order of their ticks and knows the angle of each.
class Judge {
  public:
    Judge(const EngineFile &engine, const Record &record) : record_(record), score_(engine) {}
    void said(std::uint32_t tick, int cylinder, int verdict, double index) {
        while (at_ < record_.edges.size() && record_.edges[at_].tick != tick) ++at_;
        if (at_ == record_.edges.size()) return;
        score_.said(record_.edges[at_].crank_deg, cylinder, verdict, index);
        verdicts_.verdict.push_back(verdict);
    }
    Verdicts result() {
        for (const CycleTruth &cycle : record_.cycles) score_.truth(cycle);
        verdicts_.figures = score_.result();
        return verdicts_;
    }

  private:
    const Record &record_;
    MisfireScore score_;
    Verdicts verdicts_;
    std::size_t at_ = 0;
};

/// The method is a parameter alone: no table depends on it.
sd_calibration_t with_method(sd_calibration_t page, int method, int arithmetic) {
    page.parameters.misfire_method = float(method);
    page.parameters.misfire_arithmetic = float(arithmetic);
    return page;
}

/// Another ecu on the same events. Verdicts are complete when the last signal of a firing's row has come.
Verdicts repeat(const Scenario &scenario, const sd_calibration_t &page, const Record &record) {
    Judge judge(scenario.engine.shared, record);
    EcuBench bench(page);
    EcuSaid said;
    std::size_t firings = 0;
    const std::uint16_t last = sd_rate_infos[SD_RATE_FIRING].channels[sd_rate_infos[SD_RATE_FIRING].count - 1];
    bench.listen([&](bool out, const sd_event_t &event) {
        if (!out) return;
        said.take(event);
        if (event.kind != SD_EVENT_SIGNAL || event.channel != last || said.firings() == firings) return;
        firings = said.firings();
        const sd_signals_t &s = said.signals();
        judge.said(event.tick, int(s.misfire_cylinder), int(s.misfire_verdict), double(s.misfire_index));
    });
    for (const sd_event_t &event : record.events) bench.send(event);
    return judge.result();
}

Verdicts observe_inputs(const Scenario &scenario, const sd_calibration_t &page, const Record &record) {
    Judge judge(scenario.engine.shared, record);
    InputWheel wheel(scenario.engine.shared, page);
    for (const sd_event_t &event : record.events) {
        if (const auto firing = wheel.take(event)) judge.said(event.tick, firing->cylinder, firing->verdict, firing->strength);
    }
    return judge.result();
}

void compare(const Verdicts &a, const Verdicts &b, Detection &detection) {
    for (std::size_t i = 0; i < std::min(a.verdict.size(), b.verdict.size()); ++i) {
        if (a.verdict[i] == SD_NOT_JUDGED && b.verdict[i] == SD_NOT_JUDGED) continue;
        ++detection.compared;
        detection.differing += a.verdict[i] != b.verdict[i];
    }
}

} // namespace

std::vector<DetectionCell> detection_cells() {
    std::vector<DetectionCell> cells;
    for (const bool ramp : {false, true}) {
        for (const int rpm : {900, 1500, 3000, 6000}) {
            for (const double bar : {1.0, 10.0}) cells.push_back({rpm, bar, ramp});
        }
    }
    return cells;
}

Scenario detection_scenario(const DetectionCell &cell, int cycles, std::uint64_t seed) {
    std::string speed = fmt::format("rpm = {}", cell.rpm);
    if (cell.ramp) {
        std::string rpm, time;
        const double end_s = 1.3 * cycles * 120.0 / cell.rpm;
        for (int k = 0; k * kRampS < end_s + kRampS; ++k) {
            rpm += fmt::format("{}{}", k ? ", " : "", cell.rpm * (k % 2 ? 1 + kRampShare : 1 - kRampShare));
            time += fmt::format("{}{}", k ? ", " : "", k * kRampS);
        }
        speed = fmt::format("rpm = [{}]\ntime_s = [{}]", rpm, time);
    }
    TomlFile file("cell", fmt::format("engine = \"diesel_22.toml\"\nseed = {}\n[run]\ncycles = {}\n[speed]\n{}\n[load]\nbmep_bar = {}\n"
                                      "[cyclic]\ncov_percent = 5\n[misfires]\none_in = 50\n[encoder]\njitter_deg = 0.01\n",
                                      seed, cycles, speed, cell.bmep_bar));
    Scenario scenario = read_scenario(file, SD_DATA "/engines");
    if (cell.rpm < 1000) scenario.engine.shared.inertia_kgm2 *= 3;
    return scenario;
}

Detection run_detection(const Scenario &scenario, const std::vector<std::string> &parameters) {
    Detection detection;
    Record record;
    TomlFile tune("tune", "");
    for (const std::string &parameter : parameters) tune.set(parameter);
    const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "tune");
    const auto bench = std::make_unique<EcuBench>(page);
    bench->listen(record.listener());
    detection.run = run_scenario(scenario, page, *bench, nullptr, &record);
    constexpr const char *kNames[] = {"FOLSMO", "FOSMO", "ROO"};
    for (int method = 1; method <= 3; ++method) {
        const Verdicts f32 = repeat(scenario, with_method(page, method, 0), record);
        const Verdicts q31 = repeat(scenario, with_method(page, method, 1), record);
        detection.rows.push_back({kNames[method - 1], f32.figures});
        detection.rows.push_back({std::string(kNames[method - 1]) + " q31", q31.figures});
        compare(f32, q31, detection);
    }
    detection.rows.push_back({"input observer", observe_inputs(scenario, page, record).figures});
    detection.rows.push_back({"monitor", detection.run.misfire});
    return detection;
}

} // namespace sixdeg
