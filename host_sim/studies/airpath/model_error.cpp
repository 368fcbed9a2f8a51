// SPDX-License-Identifier: MIT
#include "studies/airpath/model_error.hpp"

#include <algorithm>
#include <cmath>

#include "io/tables/fixed_text.hpp"
#include "plant/airpath/mean_value.hpp"
#include "studies/airpath/full_run.hpp"

namespace sixdeg {
namespace {

constexpr double kSettledS = 2, kStepS = 1e-3;
constexpr int kStepsARead = 10;

FullCase drive() {
    FullCase c;
    c.seconds = 120, c.seed = 4;
    c.speed_radps = Profile({0, 10, 18, 40, 44, 60, 75, 90, 100, 120}, {1200, 1200, 1600, 1600, 1350, 1350, 1900, 1900, 1450,
        1450}).scaled(kRadpsPerRpm);
    c.bmep_pa = Profile({0, 6, 6.5, 22, 23, 34, 34.5, 50, 52, 68, 70, 84, 85, 104, 105, 120}, {6, 6, 9, 9, 7, 7, 10, 10, 6.5, 6.5, 8.5,
        8.5, 11, 11, 8, 8}).scaled(1e5);
    c.setup.egr = Profile({0, 13, 13.2, 28, 28.2, 47, 47.2, 56, 60, 79, 79.2, 96, 96.2, 112, 112.2},
                          {0.3, 0.3, 0.4, 0.4, 0.22, 0.22, 0.35, 0.35, 0.15, 0.15, 0.3, 0.3, 0.45, 0.45, 0.25});
    c.setup.vgt = Profile({0, 16, 16.2, 31, 31.2, 46, 50, 65, 65.2, 82, 82.3, 99, 99.3, 109, 109.3},
                          {0.45, 0.45, 0.38, 0.38, 0.5, 0.5, 0.42, 0.42, 0.55, 0.55, 0.47, 0.47, 0.36, 0.36, 0.44});
    return c;
}

MeanValueInput input_of(const airpath::Readings &readings, const airpath::Truth &truth) {
    MeanValueInput in;
    in.speed_radps = truth.speed_radps, in.fuel_kgps = truth.fuel_kgps;
    in.air_kgps = *readings.value[airpath::kAirFlow];
    in.egr_opening = *readings.value[airpath::kEgrPosition], in.vgt_position = *readings.value[airpath::kVgtPosition];
    return in;
}

void set_temperatures(MeanValueModel &model, const airpath::Readings &r) {
    model.set_temperatures(*r.value[airpath::kChargeTemperature], *r.value[airpath::kEgrTemperature],
        *r.value[airpath::kExhaustTemperature]);
}

ModelError error_of(const char *name, const std::vector<ModelRow> &rows, double (*truth)(const ModelRow &),
    double (*model)(const ModelRow &)) {
    double sum = 0, error = 0, largest = 0;
    std::size_t n = 0;
    for (const ModelRow &row : rows) {
        if (row.truth.time_s < kSettledS) continue;
        const double off = std::abs(model(row) - truth(row));
        sum += truth(row), error += off, largest = std::max(largest, off);
        ++n;
    }
    return {name, 100 * error / sum, 100 * largest * double(n) / sum};
}

} // namespace

std::vector<ModelRow> model_drive(const PlantEngine &engine) {
    MeanValueModel model(*engine.shared.air_path, engine.displacement_m3());
    std::vector<ModelRow> rows;
    run_full(engine, drive(), [&](const airpath::Readings &readings, const airpath::Truth &truth) {
        const MeanValueInput in = input_of(readings, truth);
        set_temperatures(model, readings);
        if (rows.empty()) model.rest(in);
        const double drawn = model.emptying_ps(in.speed_radps) * (model.air_kg() + model.egr_kg());
        rows.push_back({truth, readings, model.intake_pa(), model.exhaust_pa(), drawn, drawn + in.fuel_kgps});
        for (int i = 0; i < kStepsARead; ++i) model.step(in, kStepS);
    });
    return rows;
}

std::vector<ModelError> model_errors(const std::vector<ModelRow> &rows) {
    using Row = const ModelRow &;
    return {error_of("intake pressure", rows, [](Row r) { return r.truth.flows.intake_pa; }, [](Row r) { return r.intake_pa; }),
            error_of("exhaust pressure", rows, [](Row r) { return r.truth.flows.exhaust_pa; }, [](Row r) { return r.exhaust_pa; }),
            error_of("gas into the cylinders", rows, [](Row r) { return r.truth.flows.cylinder_kgps; }, [](Row r) { return r.drawn_kgps; }),
            error_of("gas out of them", rows, [](Row r) { return r.truth.flows.leaving_kgps; }, [](Row r) { return r.leaving_kgps; })};
}

std::string model_csv(const std::vector<ModelRow> &rows) {
    std::string text = "t_s,rpm,fuel_gps,air_gps,egr,vgt,intake_kpa,intake_model_kpa,exhaust_kpa,exhaust_model_kpa,intake_read_kpa,"
                       "exhaust_read_kpa,"
                       "drawn_gps,drawn_model_gps,leaving_gps,leaving_model_gps\n";
    for (const ModelRow &r : rows) {
        const auto add = [&text](double value, int decimals) { text += ',', append_fixed(text, value, decimals); };
        append_fixed(text, r.truth.time_s, 2);
        add(r.truth.speed_radps / kRadpsPerRpm, 1), add(1e3 * r.truth.fuel_kgps, 4), add(1e3 * *r.readings.value[airpath::kAirFlow], 3);
        add(r.truth.egr, 4), add(r.truth.vgt, 4);
        add(1e-3 * r.truth.flows.intake_pa, 3), add(1e-3 * r.intake_pa, 3), add(1e-3 * r.truth.flows.exhaust_pa, 3), add(1e-3 *
            r.exhaust_pa, 3);
        add(1e-3 * *r.readings.value[airpath::kIntakePressure], 3), add(1e-3 * *r.readings.value[airpath::kExhaustPressure], 3);
        add(1e3 * r.truth.flows.cylinder_kgps, 3), add(1e3 * r.drawn_kgps, 3), add(1e3 * r.truth.flows.leaving_kgps, 3), add(1e3 *
            r.leaving_kgps, 3);
        text += '\n';
    }
    return text;
}

} // namespace sixdeg
