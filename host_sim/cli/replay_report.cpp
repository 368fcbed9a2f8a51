// SPDX-License-Identifier: MIT
// sixdeg replay: summary.json, the tables and the words printed, of recordings and event logs alike.
#include <fmt/format.h>

#include "cli/replay_command.hpp"

namespace sixdeg {

using Json = nlohmann::ordered_json;

Json figures_json(const ReplayResult &result) {
    const auto or_null = [](const auto &value) { return value ? Json(*value) : Json(); };
    Json figures;
    figures["edges"] = result.edges;
    figures["revolutions"] = result.revolutions;
    figures["sync_losses"] = result.counts.sync_losses;
    figures["faults_coasted"] = result.counts.coasted + result.counts.spurious;
    figures["first_sync_edge"] = or_null(result.first_sync_edge);
    figures["synced_percent"] = result.turned_s > 0 ? 100 * result.synced_s / result.turned_s : 0;
    figures["rpm_last"] = or_null(result.rpm_last);
    return figures;
}

Json decoder_json(const ReplayResult &result) {
    return {{"sync_gains", result.counts.sync_gains}, {"teeth_coasted", result.counts.coasted},
            {"edges_left_out", result.counts.spurious}, {"slips_corrected", result.counts.slips},
            {"marks_missed", result.counts.marks_missed}, {"stalls", result.counts.stalls},
            {"cam_edges", result.cam_edges}, {"cam_edges_rejected", result.counts.cam_rejected},
            {"mark_spacings", result.mark_spacings}};
}

Json misfire_json(const ReplayResult &result, const std::vector<int> &firing_order) {
    Json cylinders = Json::array();
    std::vector<int> numbers = firing_order;
    std::sort(numbers.begin(), numbers.end());
    std::size_t judged = 0;
    for (int number : numbers) {
        const MisfireCounts &counts = result.misfires[std::size_t(number - 1)];
        judged += counts.judged;
        cylinders.push_back({{"cylinder", number}, {"judged", counts.judged}, {"misfires", counts.misfires}, {"partial", counts.partial},
                             {"window_200_percent", result.last.misfire_rate_200_percent[number - 1]},
                             {"window_1000_percent", result.last.misfire_rate_1000_percent[number - 1]}});
    }
    return {{"firings", result.firings}, {"judged", judged}, {"lamp", int(result.last.misfire_lamp)}, {"cylinders", cylinders}};
}

void print_counts(const ReplayResult &result) {
    fmt::print("{} edges, {} whole revolutions, sync at edge {}, {} losses, {} faults coasted through\n", result.edges,
               result.revolutions, result.first_sync_edge ? std::to_string(*result.first_sync_edge) : std::string("none"),
               result.counts.sync_losses, result.counts.coasted + result.counts.spurious);
    if (result.rpm_last)
        fmt::print("{:.1f} rpm in the last revolution followed, which ended at {:.3f} s\n", *result.rpm_last, result.rpm_last_s);
}

ReplayOutput::ReplayOutput(const ReplayOptions &options, const ReplayEngine &engine) : options_(options) {
    if (options.out.empty()) return;
    folder_.emplace(options.out);
    const auto stream = [&](const char *name) -> std::ostream & { return folder_->stream(name); };
    tables_.emplace(ReplayStreams{stream("teeth.csv"), stream("cycles.csv"), stream("firings.csv"), stream("work.csv")}, engine);
}

void ReplayOutput::commit(const Json &summary) {
    const std::string text = summary.dump(2) + "\n";
    if (folder_) {
        folder_->add("summary.json", text);
        folder_->commit();
    }
    if (!options_.json.empty()) write_file(options_.json, text);
}

} // namespace sixdeg
