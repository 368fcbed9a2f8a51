// SPDX-License-Identifier: MIT
// The plant's truth on its own channel, for whoever compares. No ecu hears it.
#pragma once
#include "io/bus/bus.hpp"
#include "loop/bench_run.hpp"

namespace sixdeg {

class BusTruth : public TruthSink {
  public:
    explicit BusTruth(Bus &bus) : bus_(bus) {}

    void edge(const EncoderEdge &edge, double crank_deg) override {
        sd_truth_t truth{};
        truth.kind = sd_truth_t::SD_TRUTH_EDGE;
        truth.edge = {edge.time_s,
                      edge.angle_deg,
                      crank_deg,
                      edge.speed_radps,
                      edge.net_torque_nm,
                      edge.tick,
                      std::uint8_t(edge.tooth),
                      std::uint8_t(edge.spurious | edge.backward << 1)};
        bus_.send_truth(truth);
        ++sent_.edges;
    }
    void cycle(const CycleTruth &cycle) override {
        sd_truth_t truth{};
        truth.kind = sd_truth_t::SD_TRUTH_CYCLE;
        truth.cycle = {cycle.combustion_torque_nm,
                       cycle.imep_pa,
                       cycle.tdc_time_s,
                       cycle.exhaust_lambda,
                       std::int32_t(cycle.cycle),
                       std::uint8_t(cycle.cylinder),
                       cycle.misfire};
        bus_.send_truth(truth);
        ++sent_.cycles;
    }
    void end() {
        sd_truth_t truth{};
        truth.kind = sd_truth_t::SD_TRUTH_END;
        truth.end = sent_;
        bus_.send_truth(truth);
    }

  private:
    Bus &bus_;
    sd_truth_end_t sent_{};
};

} // namespace sixdeg
