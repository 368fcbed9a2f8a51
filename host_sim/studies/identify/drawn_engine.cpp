// SPDX-License-Identifier: MIT
#include "studies/identify/drawn_engine.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/random.hpp"
#include "common/streams.hpp"
#include "plant/scenario/plant.hpp"

namespace sixdeg {
namespace {

/// Evenly within, one number each.
class Draw {
  public:
    explicit Draw(std::uint64_t seed) : random_(seed, stream::kIdentifyStudy) {}
    double from(double low, double high) { return low + (high - low) * random_.uniform(); }
    std::size_t below(std::size_t n) { return std::size_t(random_.uniform() * double(n)); }
    std::vector<double> list(std::size_t n, double most) {
        std::vector<double> values(n);
        for (double &value : values) value = from(-most, most);
        return values;
    }

  private:
    RandomStream random_;
};

struct Layout {
    std::vector<int> order;
    std::vector<double> tdc_deg;
};
const std::vector<Layout> kLayouts = {{{1}, {0}},
                                      {{1, 2, 3}, {0, 240, 480}},
                                      {{1, 3, 4, 2}, {0, 180, 360, 540}},
                                      {{1, 3, 4, 2}, {0, 180, 360, 540}},
                                      {{1, 5, 3, 6, 2, 4}, {0, 120, 240, 360, 480, 600}},
                                      {{1, 6, 5, 4, 3, 2}, {0, 90, 240, 330, 480, 570}},
                                      {{1, 8, 4, 3, 6, 5, 7, 2}, {0, 90, 180, 270, 360, 450, 540, 630}}};

std::string engine_text(Draw &draw, const Layout &layout) {
    const double n = double(layout.order.size()), bore = draw.from(0.065, 0.095), stroke = bore * draw.from(0.85, 1.2);
    const double litre = n * M_PI / 4 * bore * bore * stroke * 1000;
    const double mass = draw.from(0.8, 1.4) * 0.9 * std::pow(bore / 0.087, 3);
    // The lightest cranks are those of many cylinders: a single needs a flywheel to turn at all.
    const double inertia = draw.from(0.07, 0.13) * litre * (n == 1 ? 1.6 : n == 3 ? 1.2 : 1);
    const double gamma = draw.from(1.30, 1.38);
    const bool air = draw.from(0, 1) < 0.3;
    return fmt::format("name = \"drawn\"\n[cylinders]\nfiring_order = {}\nfiring_tdc_deg = {}\nbore_m = {}\nstroke_m = {}\nrod_m = {}\n"
                       "compression_ratio = {}\n[valves]\nintake_close_deg = {}\nexhaust_open_deg = 135\n[[combustion.pulse]]\n"
                       "start_deg = -10\nduration_deg = 55\nshape = 2\n[crank]\ninertia_kgm2 = {}\nreciprocating_mass_kg = {}\n"
                       "[wheel]\nposition_0_deg = {}\n"
                       "[cam]\nedge_deg = 420\n[plant.air]\nintake_pressure_bar = [0.5, 0.8, 1.2]\nbmep_bar = [0, 3, 7]\n"
                       "exhaust_pressure_bar = {}\ncharge_temperature_k = {}\n[plant.wall]\nfactor = {}\n[plant.friction]\n"
                       "fmep_bar = [{}, {}, 0.03]\n{}",
                       layout.order, layout.tdc_deg, bore, stroke, stroke * draw.from(1.5, 1.8), draw.from(9, 16), draw.from(565, 595),
                           inertia,
                       mass, draw.from(60, 330), draw.from(1.03, 1.2), draw.from(320, 360), draw.from(0, 2), draw.from(0.4, 1.0),
                       draw.from(0.05, 0.25), air ? std::string() : fmt::format("[plant.gas]\ngamma = {}\n", gamma));
}

/// n of the true pressure over the true volume, by least squares of its logarithm, of compressions without combustion.
class ExponentTruth {
  public:
    ExponentTruth(const PlantEngine &engine, double ratio) : slider_(engine.slider(ratio)), closes_(engine.intake_close_rad - 4 * kPi) {}
    void take(double angle_rad, double pressure_pa) {
        const double at = std::remainder(angle_rad, 4 * kPi);
        if (at < closes_ + 10 * kRadPerDeg || at > -40 * kRadPerDeg) return;
        const double x = std::log(slider_.volume_m3(at)), y = std::log(pressure_pa);
        n_ += 1, x_ += x, y_ += y, xx_ += x * x, xy_ += x * y;
    }
    double value() const { return -(n_ * xy_ - x_ * y_) / (n_ * xx_ - x_ * x_); }

  private:
    CrankSlider slider_;
    double closes_, n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

} // namespace

DrawnEngine draw_engine(std::uint64_t seed) {
    Draw draw(seed);
    const Layout &layout = kLayouts[draw.below(kLayouts.size())];
    const PlantEngine engine = read_plant_engine("drawn", engine_text(draw, layout));
    const std::size_t n = layout.order.size();
    const double low = draw.from(1000, 1700), high = draw.from(2500, 4000);
    DrawnEngine drawn;
    Scenario &s = drawn.scenario;
    s.name = s.file = "drawn";
    s.engine = engine;
    s.seed = seed;
    s.duration_s = 7;
    s.speed_radps = Profile({0, 3, 4.5, 7}, {low, low, high, high}).scaled(kRadpsPerRpm);
    const double low_bar = draw.from(1, 4), high_bar = draw.from(1, 4);
    s.bmep_pa = Profile({0, 3.2, 3.3, 7}, {low_bar, low_bar, high_bar, high_bar}).scaled(kPaPerBar);
    s.fuel_cut_s = {0.6, 3, 5, 7};
    s.fuel_factor.assign(n, 1);
    s.trapped_factor.assign(n, 1);
    s.compression_factor.assign(n, 1);
    for (double &factor : s.trapped_factor) factor += draw.from(-0.015, 0.015);
    for (double &factor : s.compression_factor) factor += draw.from(-0.01, 0.01);
    s.cyclic_cov = Profile(0.05);
    s.encoder.offset_deg = draw.from(-2, 2);
    s.encoder.pattern_rms_deg = draw.from(0.02, 0.2);
    s.encoder.jitter_deg = draw.from(0.005, 0.02);
    drawn.first = engine.shared;
    drawn.first.inertia_kgm2 *= draw.from(0.75, 1.3);
    drawn.first.compression_ratio *= draw.from(0.98, 1.02);
    drawn.first.reciprocating_mass_kg *= draw.from(0.9, 1.1);
    drawn.pressure_gain = draw.from(0.99, 1.01);
    drawn.pressure_zero_bar = draw.from(-5, 5);
    drawn.pressure_noise_bar = 0.02;
    drawn.intake_gain = draw.from(0.99, 1.01);
    drawn.what = fmt::format("{} cylinders, J {:.3f} kg m2, CR {:.1f}, pattern {:.2f} deg, offset {:+.2f} deg", n,
        engine.shared.inertia_kgm2,
                             engine.shared.compression_ratio, s.encoder.pattern_rms_deg, s.encoder.offset_deg);
    return drawn;
}

DrawnRun run_engine(const DrawnEngine &drawn) {
    const Scenario &s = drawn.scenario;
    const EngineFile &engine = s.engine.shared;
    Plant plant(s, s.seed);
    DrawnRun run;
    RandomStream noise(s.seed, stream::kIdentifyNoise);
    ExponentTruth exponent(s.engine, engine.compression_ratio * s.compression_factor[std::size_t(engine.firing_order[0] - 1)]);
    int step = 0;
    plant.watch_steps([&] {
        const StepTruth &now = plant.truth();
        const double pa = plant.model().pressure_pa(0);
        run.record.pressure.push_back({now.time_s, drawn.pressure_gain * pa / kPaPerBar + drawn.pressure_zero_bar
            + drawn.pressure_noise_bar * noise.normal()});
        const bool cut = (now.time_s > 0.9 && now.time_s < 3) || now.time_s > 5.2;
        if (cut) exponent.take(now.angle_rad, pa);
        if (step++ % 20 != 0) return;
        run.truth.load_nm.push_back({now.time_s, now.load_torque_nm});
        run.record.fuel.push_back({now.time_s, plant.commanded_fuel_kg() * 1e6});
        run.record.intake.push_back({now.time_s, drawn.intake_gain * plant.intake_pressure_pa() / kPaPerBar});
    });
    EncoderEdge edge;
    const int positions = engine.wheel.positions;
    long turn = 0;
    int last = -1;
    double last_deg = -1;
    while (plant.next_edge(edge)) {
        if (edge.kind != EdgeKind::crank || edge.spurious) continue;
        // The revolution of the cycle, from the true angle: half a turn beyond position 0 nothing is in doubt.
        if (last < 0) {
            const double off = std::fmod(edge.angle_deg - engine.position_0_deg - 360.0 / positions * edge.tooth + 1440, 720);
            turn = off > 180 && off < 540 ? 1 : 0;
        } else if (edge.tooth < last) ++turn;
        last = edge.tooth, last_deg = edge.angle_deg;
        run.record.teeth.push_back({std::floor(edge.time_s * engine.tick_hz) / engine.tick_hz, turn * positions + edge.tooth});
    }
    (void)last_deg;
    run.truth.inertia_kgm2 = engine.inertia_kgm2;
    run.truth.position_0_deg = std::fmod(engine.position_0_deg + s.encoder.offset_deg + 360, 360);
    run.truth.exponent = exponent.value();
    run.truth.pattern_deg = plant.wheel().pattern_deg(positions);
    return run;
}

} // namespace sixdeg
