// SPDX-License-Identifier: MIT
#include "io/bus/collector.hpp"

#include <algorithm>

namespace sixdeg {

void Collector::truth(const sd_truth_t &truth) {
    if (truth.kind == sd_truth_t::SD_TRUTH_EDGE) edges_.push_back(truth.edge);
    if (truth.kind == sd_truth_t::SD_TRUTH_CYCLE) cycles_.push_back(truth.cycle);
    if (truth.kind != sd_truth_t::SD_TRUTH_END) return;
    sent_ = truth.end;
    ended_ = true;
}

RunTables Collector::tables(const EngineFile &engine) const {
    RunTables tables(engine);
    Answers answers;
    answers.add(said_);
    EcuSaid said;
    for (const sd_truth_edge_t &truth : edges_) {
        EncoderEdge edge;
        edge.time_s = truth.time_s;
        edge.tick = truth.tick;
        edge.tooth = truth.tooth == 255 ? -1 : truth.tooth;
        edge.spurious = (truth.flags & 1) != 0;
        edge.backward = (truth.flags & 2) != 0;
        edge.angle_deg = truth.angle_deg;
        edge.speed_radps = truth.speed_radps;
        edge.net_torque_nm = truth.net_torque_nm;
        const bool cycle_ended = answers.take(edge.tick, said);
        tables.edge(edge, truth.crank_deg, said, cycle_ended);
    }
    for (const sd_truth_cycle_t &truth : cycles_) {
        CycleTruth cycle;
        cycle.cycle = truth.cycle;
        cycle.cylinder = truth.cylinder;
        cycle.combustion_torque_nm = truth.torque_nm;
        cycle.imep_pa = truth.imep_pa;
        cycle.tdc_time_s = truth.tdc_time_s;
        cycle.exhaust_lambda = truth.exhaust_lambda;
        cycle.misfire = truth.misfire != 0;
        tables.true_cycle(cycle);
    }
    unanswered_ = answers.missing();
    return tables;
}

std::size_t Collector::truth_lost() const {
    return sent_.edges + sent_.cycles - std::min<std::size_t>(sent_.edges + sent_.cycles, edges_.size() + cycles_.size());
}

} // namespace sixdeg
