// SPDX-License-Identifier: MIT
#include "studies/driveline/own_torque.hpp"

#include <cstring>
#include <deque>
#include <memory>

#include "common/random.hpp"
#include "design/calibration.hpp"
#include "design/driveline/guard_design.hpp"
#include "loop/ecu_bench.hpp"
#include "plant/engine/units.hpp"
#include "plant/scenario/plant.hpp"

namespace sixdeg {
namespace {

constexpr const char *kBase = "engine = \"vw_aba_car.toml\"\n[run]\nduration_s = 60\n[speed]\nmode = \"free\"\nrpm = 2000\n"
                              "[load]\nbmep_bar = 1\n[vehicle]\ngear = 2\n[cyclic]\ncov_percent = 3\n[encoder]\njitter_deg = 0.02\n";
constexpr std::uint32_t kDriver = 1; // random stream

/// Without fuel the engine takes some 19 N m and 0.036 N m s, as the plant has it.
double overrun_nm(double speed_radps) { return -19 - 0.036 * speed_radps; }

struct Wish {
    double torque_nm, ramp_s, hold_s;
};
Wish next_wish(RandomStream &random, double speed_rpm) {
    const double torque = speed_rpm > 2900   ? -15 + 5 * random.uniform()
                          : speed_rpm < 1500 ? 40 + 40 * random.uniform()
                                             : -15 + 75 * random.uniform();
    const double ramp = 0.05 + 0.25 * random.uniform();
    return {torque, ramp, 0.6 + 2.4 * random.uniform()};
}

/// A driver against a car without a shaft, which is near enough to hold the range of speed.
void draw_driver(Scenario &s, std::uint64_t seed) {
    RandomStream random(seed, kDriver);
    const Driveline &car = s.vehicle->car;
    const double ratio = car.ratios[s.vehicle->gear], inertia = car.vehicle_inertia_kgm2 * ratio * ratio + 0.2;
    std::vector<double> time{0}, torque{15}, cut;
    double speed = s.speed_radps.at(0), given = 15, now = 0, next = 3;
    bool without_fuel = false;
    while (now < s.duration_s) {
        for (constexpr int kSteps = 100; now < next - 1e-9;) {
            const double h = std::min(next - now, 3.0 / kSteps);
            speed += h * ((without_fuel ? overrun_nm(speed) : given) - ratio * car.road_nm(ratio * speed)) / inertia;
            now += h;
        }
        const Wish wish = next_wish(random, speed / kRadpsPerRpm);
        const bool cuts = wish.torque_nm < -5;
        if (cuts != without_fuel) cut.push_back(now + wish.ramp_s / 2);
        without_fuel = cuts;
        time.insert(time.end(), {now, now + wish.ramp_s});
        torque.insert(torque.end(), {given, std::max(wish.torque_nm, 0.1)});
        given = torque.back();
        next = now + wish.hold_s;
    }
    if (without_fuel) cut.push_back(now + 100);
    s.bmep_pa = Profile(time, torque).scaled(1 / s.engine.torque_of_mep_nm(1));
    s.fuel_cut_s = cut;
}

/// A step of the plant.
struct Point {
    double angle_deg, gas_nm, speed_radps, twist_rad, shaft_nm;
};

struct Follower {
    sd_driveline_tables_t tables;
    sd_driveline_guard_f32_t filter;
    sd_driveline_out_f32_t out;
    DriveScore score;
    explicit Follower(const sd_driveline_tables_t &t) : tables(t), out{} { sd_driveline_guard_init_f32(&filter, &tables); }
};

class Run {
  public:
    Run(const Scenario &drive, const EngineFile &believed)
        : drive_(drive), page_(std::make_unique<sd_calibration_t>(calibrate(believed, read_tune(tune_), "tune"))), bench_(*page_),
          plant_(drive, drive.seed), driveline_(*sd_calibration_driveline(page_.get())), same_(tables()), believing_(own_tables(believed)) {
        plant_.watch_steps([this] { note_step(); });
    }

    OwnTorqueFigures finish() {
        EncoderEdge edge;
        while (plant_.next_edge(edge)) take(edge);
        return {own_.figures(), same_.score.figures(), believing_.score.figures()};
    }

  private:
    /// Stored only as far as the gears go.
    sd_driveline_tables_t tables() const {
        sd_driveline_tables_t t{};
        const std::size_t words = sd_page_driveline_words(driveline_.tables.gears);
        std::memcpy(static_cast<void *>(&t), &driveline_.tables, words * sizeof(float) - offsetof(sd_page_driveline_t, tables));
        return t;
    }
    sd_driveline_tables_t own_tables(const EngineFile &believed) const {
        Driveline car = believed.driveline->car;
        car.engine_inertia_kgm2 = 1 / double(driveline_.tables.per_inertia);
        return guard_tables(car, GuardBelief(), believed.wheel.positions, 1 / believed.tick_hz);
    }

    void note_step() {
        const StepTruth &now = plant_.truth();
        const VehicleModel &car = plant_.car()->model();
        for (DriveScore *score : {&own_, &same_.score, &believing_.score}) {
            for (std::size_t i = changes_; i < car.changes().size(); ++i) score->changed(car.changes()[i]);
            score->pass(now.time_s, now.time_s - last_s_, car.location());
        }
        changes_ = car.changes().size();
        last_s_ = now.time_s;
        points_.push_back({now.angle_rad * kDegPerRad, now.gas_torque_nm, now.speed_radps, car.state().twist_rad,
                           car.ratio() * car.shaft_nm()});
    }

    void take(const EncoderEdge &edge) {
        bench_.show(SD_INPUT_AIR_INTAKE_PRESSURE, plant_.intake_pressure_pa() / kPaPerBar);
        bench_.show(SD_INPUT_FUEL_INJECTED, plant_.commanded_fuel_kg() * 1e6);
        bench_.show(SD_INPUT_DRIVELINE_GEAR, plant_.car()->gear());
        bench_.tell_time_until(edge.time_s);
        const bool crank = edge.kind == EdgeKind::crank;
        const std::uint32_t before = bench_.ecu().driveline.tick;
        bench_.exchange(std::uint16_t(crank ? SD_EVENT_CRANK_EDGE : SD_EVENT_CAM_EDGE), edge.tick);
        if (!crank || bench_.ecu().driveline.tick == before) return; // not placed
        const double deg = edge.angle_deg + 720 * std::round((plant_.truth().angle_rad * kDegPerRad - edge.angle_deg) / 720);
        const int position = int(bench_.signals().crank_tooth);
        if (position_ >= 0) tooth(edge.time_s, edge.tick - before, deg, position);
        position_ = position;
        last_deg_ = deg;
    }

    void tooth(double now_s, std::uint32_t period_ticks, double deg, int position) {
        const int positions = page_->positions;
        const sd_firings_t &firings = bench_.ecu().firings;
        const bool learned = firings.pattern.sd_rad > 0 && firings.pattern.sd_rad < firings.unlearned_rad;
        sd_driveline_tooth_f32_t tooth{};
        tooth.period_ticks = period_ticks;
        tooth.advance = std::uint16_t((position - position_ + positions) % positions);
        tooth.health = SD_VALID;
        tooth.gear = std::uint8_t(sd_inputs_value(&bench_.ecu().inputs, SD_INPUT_DRIVELINE_GEAR));
        tooth.torque_nm = float(true_torque_nm(deg));
        tooth.lead_rad = driveline_.place_rad[position];
        tooth.place_rad = learned ? firings.pattern.late_rad[position] : 0;
        const double weight = period_ticks / double(page_->tick_hz);
        const Point &real = points_.front();
        const auto note = [&](DriveScore &score, const sd_driveline_out_f32_t &out) {
            score.said(now_s, weight, out, double(out.twist_rad) - real.twist_rad, double(out.shaft_nm) - real.shaft_nm);
        };
        for (Follower *f : {&same_, &believing_}) {
            sd_driveline_guard_step_f32(&f->filter, &f->tables, &tooth, &f->out);
            note(f->score, f->out);
        }
        note(own_, bench_.ecu().driveline.out);
    }

    /// Of the cylinders over the interval that ends at `deg`, less friction beyond the part that the filter takes off itself. What lies
    /// before that is forgotten.
    double true_torque_nm(double deg) {
        double work = 0, angle = 0;
        while (points_.size() > 1 && points_[1].angle_deg <= deg + 1e-6) {
            const double h = points_[1].angle_deg - points_[0].angle_deg;
            if (points_[0].angle_deg >= last_deg_ - 1e-6) {
                work += h * (points_[0].gas_nm + points_[1].gas_nm) / 2;
                angle += h;
            }
            points_.pop_front();
        }
        const double speed = points_.front().speed_radps;
        return (angle > 0 ? work / angle : points_.front().gas_nm) - drive_.engine.torque_of_mep_nm(drive_.engine.fmep_at_pa(speed)) +
               double(driveline_.tables.viscous_nms) * speed;
    }

    const Scenario &drive_;
    TomlFile tune_{"tune", ""};
    std::unique_ptr<sd_calibration_t> page_;
    EcuBench bench_;
    Plant plant_;
    const sd_page_driveline_t &driveline_;
    DriveScore own_;
    Follower same_, believing_;
    std::deque<Point> points_;
    std::size_t changes_ = 0;
    int position_ = -1;
    double last_s_ = 0, last_deg_ = 0;
};

} // namespace

Scenario own_torque_drive(double seconds, std::uint64_t seed) {
    TomlFile base("drive", kBase);
    Scenario drive = read_scenario(base, SD_DATA "/engines");
    drive.duration_s = seconds;
    drive.seed = seed;
    draw_driver(drive, seed);
    return drive;
}

OwnTorqueFigures run_own_torque(const Scenario &drive, const EngineFile &believed) {
    return std::make_unique<Run>(drive, believed)->finish();
}

} // namespace sixdeg
