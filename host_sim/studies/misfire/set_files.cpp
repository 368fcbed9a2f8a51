// SPDX-License-Identifier: MIT
#include "studies/misfire/set_files.hpp"

#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

std::string edges_csv(const SetRun &run, const EngineFile &file) {
    std::string csv = "tick,tooth,angle_deg\n";
    for (const PlantRecord::Edge &edge : run.record.edges) {
        const double place_deg = file.position_0_deg + 360.0 / file.wheel.positions * edge.tooth;
        const double turned_deg = place_deg + 360 * std::round((edge.crank_deg - place_deg) / 360);
        fmt::format_to(std::back_inserter(csv), "{},{},{:g}\n", edge.tick, edge.tooth, turned_deg - 720 * std::floor(turned_deg / 720));
    }
    return csv;
}

std::string firings_csv(const SetRun &run) {
    std::string csv = "cycle,cylinder,tdc_s,fuel_mg,misfire\n";
    for (const SetFiring &f : run.firings)
        fmt::format_to(std::back_inserter(csv), "{},{},{:.6f},{:.4f},{}\n", f.cycle, f.cylinder, f.tdc_time_s, f.fuel_mg,
                       f.misfire ? 1 : 0);
    return csv;
}

} // namespace

SetWriter::SetWriter(const std::string &folder)
    : runs_("run,kind,physics,seed,gamma,wall_factor,pattern_rms_deg,rpm,bmep_bar,road_rms_nm,jitter_deg,intake_bar,tick_hz,cylinders\n") {
    if (!folder.empty()) out_ = std::make_unique<OutputFolder>(folder);
}

void SetWriter::add(const SetEngine &engine, const SetPoint &point, const SetRun &run, const EngineFile &file) {
    if (!out_) return;
    ++count_;
    fmt::format_to(std::back_inserter(runs_), "{},{},{},{},{:.4f},{:.4f},{:.4f},{},{:g},{:g},{:g},{:.4f},{:g},{}\n", count_,
                   name_of(engine.kind), name_of(engine.physics), engine.seed, engine.gamma, engine.wall_factor, engine.pattern_rms_deg,
                   point.rpm, point.bmep_bar, point.road_rms_nm, point.jitter_deg, run.intake_pa / kPaPerBar, file.tick_hz,
                   file.cylinders());
    out_->stream(fmt::format("edges_{:04}.csv", count_)) << edges_csv(run, file);
    out_->stream(fmt::format("firings_{:04}.csv", count_)) << firings_csv(run);
}

void SetWriter::commit() {
    if (!out_) return;
    out_->add("runs.csv", runs_);
    out_->commit();
}

} // namespace sixdeg
