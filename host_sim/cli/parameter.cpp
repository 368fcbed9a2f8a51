// SPDX-License-Identifier: MIT
// sixdeg parameter: reads and sets parameters of an ecu while it runs.
#include <chrono>
#include <cstring>
#include <fmt/format.h>

#include "io/bus/bus.hpp"
#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/nearest.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string action, transport;
    std::vector<std::string> names;
};

std::uint16_t index_of(const std::string &name) {
    std::vector<std::string> names;
    for (std::uint16_t i = 0; i < SD_PARAMETER_COUNT; ++i) {
        if (name == sd_parameter_infos[i].name) return i;
        names.emplace_back(sd_parameter_infos[i].name);
    }
    throw InputError("parameter", name, "not a parameter; docs/reference/signals.md lists them" + nearest_hint(name, names));
}

/// The page as a tune file: `sixdeg ecu ENGINE.toml --tune FILE` starts with it.
std::string tune_file(const std::vector<std::pair<std::uint16_t, float>> &values) {
    std::string text, table;
    for (const auto &[index, value] : values) {
        const sd_signal_info_t &info = sd_parameter_infos[index];
        const std::string name = info.name, of = name.substr(0, name.find('.'));
        if (of != table) text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", of);
        table = of;
        text += fmt::format("{} = {}{}{}\n", name.substr(of.size() + 1), value, *info.unit ? " # " : "", info.unit);
    }
    return text;
}

/// One question at a time; what is lost on the way is asked again.
class Client {
  public:
    explicit Client(const std::string &transport) : bus_(open_bus(transport, SD_ROLE_TOOL)) {}

    float ask(std::uint16_t index, sd_parameter_command_t command, float value = 0) {
        sd_event_t request{0, SD_EVENT_PARAMETER, index, 0, command};
        std::memcpy(&request.value, &value, sizeof value);
        for (int tries = 0; tries < 10; ++tries) {
            const sd_port_t port = bus_->port();
            port.send(port.context, &request, 1);
            if (const auto answer = wait_for(request)) return checked(index, *answer);
        }
        throw InputError("ecu", "", "none answers; start `sixdeg ecu ENGINE.toml --transport ...`");
    }

  private:
    std::optional<sd_event_t> wait_for(const sd_event_t &request) {
        using Clock = std::chrono::steady_clock;
        const auto until = Clock::now() + std::chrono::milliseconds(200);
        const sd_port_t port = bus_->port();
        while (Clock::now() < until) {
            sd_event_t event;
            sd_truth_t truth; // not ours to read
            bus_->wait(20);
            while (bus_->next_truth(truth)) {}
            while (port.receive(port.context, &event, 1) == 1) {
                if (event.kind == SD_EVENT_PARAMETER && event.channel == request.channel &&
                    (event.flags & 0xff) == request.flags) return event;
            }
        }
        return std::nullopt;
    }

    static float checked(std::uint16_t index, const sd_event_t &answer) {
        static const sd_signal_info_t all{"all", "", 0, 0, 0, 0, 0, 0};
        const sd_signal_info_t &info = index < SD_PARAMETER_COUNT ? sd_parameter_infos[index] : all;
        float value;
        std::memcpy(&value, &answer.value, sizeof value);
        switch (answer.flags >> 8) {
        case SD_PARAMETER_OK: return value;
        case SD_PARAMETER_RANGE:
            throw InputError("ecu", info.name,
                             fmt::format("out of range; allowed is [{:g}, {:g}] {}; it stays {:g}", info.low, info.high, info.unit, value));
        case SD_PARAMETER_AT_START:
            throw InputError("ecu", info.name,
                             fmt::format("goes into tables that `sixdeg calibrate` makes, so an ecu takes it at its start only; "
                                         "it stays {:g}", value));
        case SD_PARAMETER_REFUSED:
            throw InputError("ecu", info.name, fmt::format("its block cannot run with this value beside the others; it stays {:g}", value));
        default: throw InputError("ecu", info.name, "it knows no such parameter");
        }
    }

    std::unique_ptr<Bus> bus_;
};

void print(std::uint16_t index, float value) {
    const sd_signal_info_t &info = sd_parameter_infos[index];
    fmt::print("{} = {:g}{}{}\n", info.name, value, *info.unit ? " # " : "", info.unit);
}

void set(Client &client, const std::string &assignment) {
    const auto equals = assignment.find('=');
    const std::uint16_t index = index_of(assignment.substr(0, equals));
    char *end = nullptr;
    const std::string text = equals == std::string::npos ? "" : assignment.substr(equals + 1);
    const float value = std::strtof(text.c_str(), &end);
    if (text.empty() || *end != '\0') throw InputError("parameter", assignment, "give NAME=NUMBER");
    print(index, client.ask(index, SD_PARAMETER_SET, value));
}

void run(const Options &options) {
    std::vector<std::uint16_t> chosen;
    for (const std::string &name : options.names) chosen.push_back(index_of(name.substr(0, name.find('='))));
    Client client(options.transport);
    for (std::uint16_t i = 0; options.names.empty() && i < SD_PARAMETER_COUNT; ++i) chosen.push_back(i);
    if (options.action == "set") {
        for (const std::string &assignment : options.names) set(client, assignment);
        return;
    }
    if (options.action == "restore" && options.names.empty()) client.ask(SD_PARAMETER_ALL, SD_PARAMETER_RESTORE);
    std::vector<std::pair<std::uint16_t, float>> dumped;
    for (const std::uint16_t index : chosen) {
        if (options.action == "restore" && !options.names.empty()) client.ask(index, SD_PARAMETER_RESTORE);
        const float working = client.ask(index, SD_PARAMETER_READ);
        if (options.action == "dump") {
            dumped.emplace_back(index, working);
            continue;
        }
        if (options.action != "diff") {
            print(index, working);
            continue;
        }
        const float reference = client.ask(index, SD_PARAMETER_READ_REFERENCE);
        if (working != reference) fmt::print("{}: {:g}, reference {:g}\n", sd_parameter_infos[index].name, working, reference);
    }
    fmt::print("{}", tune_file(dumped));
}

} // namespace

void add_parameter(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("parameter", "reads and sets parameters of an ecu while it runs");
    command.task("Over a bus", "parameter get torque.harmonics --transport lcm");
    command.option("ACTION", options->action,
                   "get, set, dump (as a tune file), diff (against the reference page) or restore").required().one_of({"get", "set", "dump",
                       "diff", "restore"});
    command.option("NAME", options->names, "names, or NAME=VALUE to set; all when none is given");
    command.option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/reference/bus.md)").required();
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
