// SPDX-License-Identifier: MIT
// A healthy engine behind a sensor chain that does its worst: whatever comes in, the ecu never says what is no number, and
// never a misfire that it calls valid.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "design/calibration.hpp"
#include "common/random.hpp"
#include "plant/scenario/plant.hpp"
extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

using namespace sixdeg;

namespace {

constexpr double kTickHz = 1e6;

/// Events on their way to the ecu, some of them changed, lost, doubled or made up; what comes back is checked.
class Chaos {
  public:
    /// harm: 1, or 0 for a chain without fault.
    Chaos(const Scenario &scenario, std::uint64_t seed, double harm = 1) : random_(seed, 99), harm_(harm) {
        page_.emplace(calibrate(scenario.engine.shared, read_tune(*std::make_unique<TomlFile>("t", "")), "t"));
        EXPECT_EQ(SD_OK, sd_ecu_init(ecu_.get(), page_->view()));
    }

    void edge(const EncoderEdge &edge, double intake_bar, double fuel_mg) {
        now_s_ = edge.time_s + shift_s_;
        if (happens(1e-4)) rest();
        if (happens(3e-5)) send(SD_EVENT_GAP, 0, 0);
        if (happens(1e-3)) wild();
        if (happens(2e-4)) blind_until_s_ = now_s_ + random_.uniform(); // a sensor that says nothing
        if (now_s_ >= blind_until_s_ && now_s_ >= next_sample_s_) {
            next_sample_s_ = now_s_ + 0.01;
            sample(SD_INPUT_AIR_INTAKE_PRESSURE, intake_bar);
            sample(SD_INPUT_FUEL_INJECTED, fuel_mg);
        }
        if (happens(lost_ > 0 ? 0.7 : 1e-3)) { // a burst of lost edges
            lost_ = 1;
            return;
        }
        lost_ = 0;
        if (happens(5e-4)) send(SD_EVENT_CRANK_EDGE, 0, 0, now_s_ - 1e-4 * random_.uniform());
        send(edge.kind == EdgeKind::crank ? SD_EVENT_CRANK_EDGE : SD_EVENT_CAM_EDGE, 0, 0);
        if (happens(2e-4)) send(SD_EVENT_CAM_EDGE, 0, 0); // of no cam
        if (happens(1e-2)) send(SD_EVENT_TIME, 0, 0);
    }

    void tell(sd_input_t input, double value) { sample(std::uint16_t(input), value); }

    std::vector<int> inhibits; ///< Of each firing.
    std::size_t firings = 0, judged = 0, false_alarms = 0, valid_false_alarms = 0, values = 0;

  private:
    bool happens(double p) { return random_.chance(harm_ * p); }

    /// The crank stands, then turns at once: a stall and a restart.
    void rest() {
        const double pause_s = 3 * random_.uniform();
        for (double t = 0; t < pause_s; t += 0.05) send(SD_EVENT_TIME, 0, 0, now_s_ + t);
        shift_s_ += pause_s, now_s_ += pause_s;
    }

    void sample(std::uint16_t channel, double value) { send(SD_EVENT_SAMPLE, channel, float(value)); }

    /// A reading that is no number, or far out of range; a parameter set and restored; an event of no kind.
    void wild() {
        const float bad[] = {NAN, INFINITY, -INFINITY, -1e30f, 1e30f, -1};
        const float value = bad[int(6 * random_.uniform())];
        const double what = random_.uniform();
        if (what < 0.7) {
            send(SD_EVENT_SAMPLE, std::uint16_t(12 * random_.uniform()), value);
        } else if (what < 0.9) {
            const auto parameter = std::uint16_t(SD_PARAMETER_COUNT * 1.1 * random_.uniform());
            send(SD_EVENT_PARAMETER, parameter, value, now_s_, SD_PARAMETER_SET);
            send(SD_EVENT_PARAMETER, parameter, value, now_s_, SD_PARAMETER_RESTORE);
        } else {
            send(std::uint16_t(40 + 100 * random_.uniform()), 7, value);
        }
    }

    void send(std::uint16_t kind, std::uint16_t channel, float value) { send(kind, channel, value, now_s_); }
    void send(std::uint16_t kind, std::uint16_t channel, float value, double time_s, std::uint32_t flags = 0) {
        // Starts shortly before the tick counter wraps.
        sd_event_t event{std::uint32_t(std::uint64_t(std::floor(time_s * kTickHz)) + 0xfff00000u), kind, channel, 0, flags};
        std::memcpy(&event.value, &value, sizeof value);
        ASSERT_EQ(1u, host_side_.send(host_side_.context, &event, 1));
        sd_ecu_run(ecu_.get(), page_->view(), &ecu_side_);
        sd_event_t answer;
        while (host_side_.receive(host_side_.context, &answer, 1) == 1) check(answer);
    }

    void check(const sd_event_t &answer) {
        if (answer.kind != SD_EVENT_SIGNAL) return;
        float value;
        std::memcpy(&value, &answer.value, sizeof value);
        ASSERT_TRUE(std::isfinite(value)) << sd_signal_infos[answer.channel].name;
        ++values;
        if (answer.channel == SD_SIGNAL_MISFIRE_INHIBIT) inhibits.push_back(int(value));
        if (answer.channel != SD_SIGNAL_MISFIRE_VERDICT) return;
        ++firings;
        judged += value < float(SD_NOT_JUDGED);
        if (value != float(SD_MISFIRE)) return;
        ++false_alarms;
        valid_false_alarms += (answer.flags & 0xff) == SD_VALID;
    }

    RandomStream random_;
    double harm_;
    std::optional<StoredPage> page_;
    std::unique_ptr<sd_ecu_t> ecu_ = std::make_unique<sd_ecu_t>();
    std::unique_ptr<sd_inproc_t> wire_ = std::make_unique<sd_inproc_t>();
    sd_port_t ecu_side_ = sd_inproc_ecu_side(wire_.get()), host_side_ = sd_inproc_host_side(wire_.get());
    double now_s_ = 0, shift_s_ = 0, next_sample_s_ = 0, blind_until_s_ = 0;
    int lost_ = 0;
};

TEST(MisfireChaos, NeverNaNAndNeverAValidMisfireOfAHealthyEngine) {
    std::size_t firings = 0, judged = 0, false_alarms = 0, valid = 0, values = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        TomlFile file("s.toml", "engine = \"diesel_22.toml\"\n[run]\ncycles = 500\n[speed]\nrpm = [900, 4000]\ntime_s = [0, 20]\n[load]\n"
                                "bmep_bar = 4\n[cyclic]\ncov_percent = 5\n[encoder]\npattern_rms_deg = 0.02\njitter_deg = 0.02\n");
        file.set("seed=" + std::to_string(seed));
        const Scenario scenario = read_scenario(file, SD_ENGINES);
        Plant plant(scenario, seed);
        Chaos chaos(scenario, seed);
        EncoderEdge edge;
        while (plant.next_edge(edge) && !HasFatalFailure())
            chaos.edge(edge, plant.intake_pressure_pa() / 1e5, plant.commanded_fuel_kg() * 1e6);
        firings += chaos.firings, judged += chaos.judged, false_alarms += chaos.false_alarms;
        valid += chaos.valid_false_alarms, values += chaos.values;
    }
    std::printf("%zu values, %zu firings, %zu judged, %zu false alarms, %zu of them valid\n", values, firings, judged, false_alarms, valid);
    EXPECT_EQ(0u, valid);
    EXPECT_LE(false_alarms, judged / 1000);
    EXPECT_GT(judged, firings / 2) << "silence is no answer";
    EXPECT_GT(firings, 5000u);
}

/// The controller says that it shifts, then that the tank is nearly empty; both by slow signals through the stream.
TEST(MisfireInhibits, AGearShiftAndAnEmptyTankThatTheEcuIsToldOf) {
    TomlFile file("s.toml", "engine = \"diesel_22.toml\"\n[run]\ncycles = 150\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 4\n");
    const Scenario scenario = read_scenario(file, SD_ENGINES);
    Plant plant(scenario, 1);
    Chaos drive(scenario, 1, 0);
    EncoderEdge edge;
    std::vector<int> cycle_of; // of each firing
    while (plant.next_edge(edge)) {
        const int cycle = int(edge.time_s * 12.5);
        if (cycle >= 40 && cycle < 60) drive.tell(SD_INPUT_DRIVELINE_SHIFT, 1);
        if (cycle == 60) drive.tell(SD_INPUT_DRIVELINE_SHIFT, 0);
        if (cycle == 80 || cycle == 130) drive.tell(SD_INPUT_FUEL_LEVEL, cycle == 80 ? 3 : 50);
        drive.edge(edge, plant.intake_pressure_pa() / 1e5, plant.commanded_fuel_kg() * 1e6);
        while (cycle_of.size() < drive.inhibits.size()) cycle_of.push_back(cycle);
    }
    ASSERT_GT(cycle_of.size(), 500u);
    for (std::size_t i = 0; i < cycle_of.size(); ++i) {
        const int cycle = cycle_of[i], inhibit = drive.inhibits[i];
        if (cycle > 20 && cycle < 39) { EXPECT_EQ(0, inhibit) << cycle; }
        if (cycle > 41 && cycle < 59) { EXPECT_EQ(SD_INHIBIT_SHIFT, inhibit) << cycle; }
        if (cycle == 61) { EXPECT_EQ(SD_INHIBIT_HOLD, inhibit) << "two cycles after"; }
        if (cycle > 64 && cycle < 79) { EXPECT_EQ(0, inhibit) << cycle; }
        if (cycle > 81 && cycle < 129) { EXPECT_EQ(SD_INHIBIT_LEVEL, inhibit) << "a level holds until another is told, " << cycle; }
        if (cycle > 131) { EXPECT_EQ(0, inhibit) << cycle; }
    }
}

} // namespace
