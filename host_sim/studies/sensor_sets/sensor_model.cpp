// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/sensor_model.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr std::size_t most_states = 64, most_sensors = 24;
constexpr std::size_t most_lags = 4;

// Where a name stands, and whether it is a shared quantity.
struct Place {
    int number;
    bool is_shared;
};
using Names = std::map<std::string, Place>;

class Reader {
  public:
    explicit Reader(TomlFile &file) : file_(file) {}

    SensorModel read() {
        model_.name = file_.text("name");
        read_names();
        read_structure();
        read_regimes();
        read_sensors();
        model_.targets = file_.has("targets") ? unique_states("targets") : all_states();
        for (std::size_t i = 0; i < file_.array_size("forbidden"); ++i) {
            model_.forbidden.push_back(sensor_set(fmt::format("forbidden[{}].sensors", i)));
        }
        for (std::size_t i = 0; i < file_.array_size("published"); ++i) {
            const std::string entry = fmt::format("published[{}].", i);
            model_.published.push_back(
                {sensor_set(entry + "sensors"), int(file_.integer(entry + "index", 0, 99))});
        }
        return std::move(model_);
    }

  private:
    void read_names() {
        model_.states = table_keys("states", most_states);
        if (file_.has("shared")) model_.shared = table_keys("shared", most_states);
        for (std::size_t i = 0; i < model_.states.size(); ++i) names_[model_.states[i]] = {int(i), false};
        for (std::size_t i = 0; i < model_.shared.size(); ++i) {
            if (!names_.emplace(model_.shared[i], Place{int(i), true}).second) {
                file_.fail("shared." + model_.shared[i], "has the name of a state");
            }
        }
    }

    std::vector<std::string> table_keys(const std::string &table, std::size_t most) {
        auto keys = file_.keys(table);
        if (keys.empty() || keys.size() > most) {
            file_.fail(table, fmt::format("has {} entries, allowed 1 to {}", keys.size(), most));
        }
        return keys;
    }

    void read_structure() {
        Structure whole;
        for (std::size_t i = 0; i < model_.shared.size(); ++i) {
            whole.shared.push_back(links("shared." + model_.shared[i], int(i)));
        }
        for (const auto &name : model_.states) whole.states.push_back(links("states." + name, all_shared()));
        for (const auto &name : table_keys("sensors", most_sensors)) {
            model_.sensors.push_back({name, {}});
            whole.sensors.push_back(links("sensors." + name + ".sees", all_shared()));
        }
        model_.regimes.push_back({file_.text_or("full_regime", "full"), std::move(whole)});
    }

    void read_sensors() {
        for (auto &sensor : model_.sensors) {
            const std::string field = "sensors." + sensor.name + ".";
            if (file_.has(field + "lags_s"))
                sensor.lags_s = file_.numbers(field + "lags_s", {1e-6, 1e4, "s"});
            if (sensor.lags_s.size() > most_lags) {
                file_.fail(field + "lags_s",
                           fmt::format("has {} entries, at most {}", sensor.lags_s.size(), most_lags));
            }
            sensor.cost = file_.number_or(field + "cost", {0, 1e9, ""}, 1);
            sensor.noise = file_.number_or(field + "noise", {1e-12, 1e12, "SI"}, 0);
        }
    }

    // Every further regime is the whole structure less the links it names.
    void read_regimes() {
        if (!file_.has("regimes")) return;
        const Structure whole = model_.regimes.front().structure;
        for (const auto &name : file_.keys("regimes")) {
            if (name == model_.regimes.front().name)
                file_.fail("regimes." + name, "is full_regime, which loses nothing");
            Regime regime{name, whole};
            const std::string table = "regimes." + name;
            const std::size_t lost = lose(table + ".shared", model_.shared, regime.structure.shared) +
                                     lose(table + ".states", model_.states, regime.structure.states) +
                                     lose(table + ".sensors", names_of_sensors(), regime.structure.sensors);
            if (lost == 0)
                file_.fail(table,
                           "is empty: it must name at least one link that full_regime has and it has not");
            model_.regimes.push_back(std::move(regime));
        }
    }

    std::size_t lose(const std::string &table, const std::vector<std::string> &owners,
                     std::vector<Links> &rows) {
        if (!file_.has(table)) return 0;
        std::size_t lost = 0;
        for (const auto &owner : file_.keys(table)) {
            const std::string field = table + "." + owner;
            const auto at = std::find(owners.begin(), owners.end(), owner);
            if (at == owners.end()) file_.fail(field, "'" + owner + "' is not defined");
            Links &row = rows[std::size_t(at - owners.begin())];
            for (const auto &name : unique_texts(field)) {
                const Place place = find(name, field);
                auto &list = place.is_shared ? row.shared : row.states;
                const auto link = std::find(list.begin(), list.end(), place.number);
                if (link == list.end())
                    file_.fail(field, fmt::format("{} does not depend on '{}'", owner, name));
                list.erase(link);
                ++lost;
            }
        }
        return lost;
    }

    // `shared_before`: how many shared quantities are defined already, so that none depends on itself.
    Links links(const std::string &field, int shared_before) {
        Links found;
        for (const auto &name : unique_texts(field)) {
            const Place place = find(name, field);
            if (place.is_shared && place.number >= shared_before) {
                file_.fail(field, fmt::format("'{}' must be defined before it is used", name));
            }
            (place.is_shared ? found.shared : found.states).push_back(place.number);
        }
        return found;
    }

    Place find(const std::string &name, const std::string &field) const {
        const auto at = names_.find(name);
        if (at == names_.end())
            file_.fail(field, fmt::format("'{}' is not a state{}", name,
                                          model_.shared.empty() ? "" : " or shared quantity"));
        return at->second;
    }

    std::vector<std::string> unique_texts(const std::string &field) {
        const auto names = file_.texts(field);
        for (auto name = names.begin(); name != names.end(); ++name) {
            if (std::find(names.begin(), name, *name) != name)
                file_.fail(field, "names '" + *name + "' twice");
        }
        return names;
    }

    std::vector<int> unique_states(const std::string &field) {
        std::vector<int> states;
        for (const auto &name : unique_texts(field)) {
            const Place place = find(name, field);
            if (place.is_shared) file_.fail(field, "'" + name + "' is not a state");
            states.push_back(place.number);
        }
        if (states.empty()) file_.fail(field, "names no state");
        return states;
    }

    SensorSet sensor_set(const std::string &field) {
        SensorSet set = 0;
        const auto known = names_of_sensors();
        for (const auto &name : unique_texts(field)) {
            const auto at = std::find(known.begin(), known.end(), name);
            if (at == known.end()) file_.fail(field, "'" + name + "' is not a sensor");
            set |= SensorSet(1) << (at - known.begin());
        }
        if (set == 0) file_.fail(field, "names no sensor");
        return set;
    }

    std::vector<std::string> names_of_sensors() const {
        std::vector<std::string> names;
        for (const auto &sensor : model_.sensors) names.push_back(sensor.name);
        return names;
    }

    std::vector<int> all_states() const {
        std::vector<int> states(model_.states.size());
        for (std::size_t i = 0; i < states.size(); ++i) states[i] = int(i);
        return states;
    }

    int all_shared() const { return int(model_.shared.size()); }

    TomlFile &file_;
    SensorModel model_;
    Names names_;
};

} // namespace

std::vector<int> SensorModel::find_states(const std::vector<std::string> &names,
                                          const std::string &from) const {
    std::vector<int> found;
    for (const auto &wanted : names) {
        const auto at = std::find(states.begin(), states.end(), wanted);
        if (at == states.end()) {
            throw InputError(from, wanted,
                             fmt::format("is not a state of the model; allowed: {}", fmt::join(states, " ")));
        }
        const int number = int(at - states.begin());
        if (std::count(found.begin(), found.end(), number)) throw InputError(from, wanted, "is named twice");
        found.push_back(number);
    }
    return found;
}

std::vector<std::string> SensorModel::sensor_names(SensorSet set) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
        if (set >> i & 1) names.push_back(sensors[i].name);
    }
    return names;
}

double SensorModel::cost(SensorSet set) const {
    double sum = 0;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
        if (set >> i & 1) sum += sensors[i].cost;
    }
    return sum;
}

SensorModel read_sensor_model(TomlFile &file) { return Reader(file).read(); }

} // namespace sixdeg
