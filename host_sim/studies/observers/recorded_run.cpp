// SPDX-License-Identifier: MIT
#include "studies/observers/recorded_run.hpp"

#include "common/error.hpp"

namespace sixdeg {

void FiringListener::hear(bool out, const sd_event_t &event) {
    // Verdicts are complete when the last signal of a firing's row has come.
    static const std::uint16_t last = sd_rate_infos[SD_RATE_FIRING].channels[sd_rate_infos[SD_RATE_FIRING].count - 1];
    if (!out) return;
    said_.take(event);
    if (event.kind != SD_EVENT_SIGNAL || event.channel != last || said_.firings() == firings_) return;
    firings_ = said_.firings();
    const sd_signals_t &s = said_.signals();
    verdicts_.push_back({event.tick, int(s.misfire_cylinder), int(s.misfire_verdict), double(s.misfire_index), double(s.misfire_limit),
                         int(said_.health(SD_OWNER_MISFIRE))});
}

sd_calibration_t with_method(sd_calibration_t page, int method, int arithmetic) {
    page.parameters.misfire_method = float(method);
    page.parameters.misfire_arithmetic = float(arithmetic);
    return page;
}

std::vector<FiringVerdict> verdicts_on(const PlantRecord &record, const sd_calibration_t &page, const sd_kept_t *learned) {
    EcuBench bench(page);
    if (learned && !bench.resume(*learned)) throw InputError("tooth pattern", "", "is of another wheel");
    FiringListener listener;
    bench.listen([&](bool out, const sd_event_t &event) { listener.hear(out, event); });
    for (const sd_event_t &event : record.events) bench.send(event);
    return listener.verdicts();
}

std::vector<double> said_at_deg(const std::vector<FiringVerdict> &verdicts, const PlantRecord &record) {
    std::vector<double> at_deg;
    std::size_t at = 0;
    for (const FiringVerdict &v : verdicts) {
        while (at < record.edges.size() && record.edges[at].tick != v.tick) ++at;
        if (at == record.edges.size()) break;
        at_deg.push_back(record.edges[at].crank_deg);
    }
    return at_deg;
}

MisfireScore score_of(const std::vector<FiringVerdict> &verdicts, const PlantRecord &record, const EngineFile &engine) {
    MisfireScore score(engine);
    const std::vector<double> at_deg = said_at_deg(verdicts, record);
    for (std::size_t i = 0; i < at_deg.size(); ++i) score.said(at_deg[i], verdicts[i].cylinder, verdicts[i].verdict, verdicts[i].index);
    for (const CycleTruth &cycle : record.cycles) score.truth(cycle);
    return score;
}

} // namespace sixdeg
