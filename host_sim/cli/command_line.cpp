// SPDX-License-Identifier: MIT
#include "cli/command_line.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/nearest.hpp"
#include "common/progress.hpp"

namespace sixdeg {

Option &Option::required() { return option_->required(), *this; }
Option &Option::one_of(const std::vector<std::string> &words) {
    const auto wrong = [words](std::string &text) {
        if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
        return fmt::format("'{}' is none of {}{}", text, fmt::join(words, ", "), nearest_hint(text, words));
    };
    return option_->check(CLI::Validator(wrong, fmt::format("{{{}}}", fmt::join(words, ",")))), *this;
}
Option &Option::within(double low, double high) { return option_->check(CLI::Range(low, high)), *this; }
Option &Option::within_whole(std::int64_t low, std::int64_t high) { return option_->check(CLI::Range(low, high)), *this; }
Option &Option::checked(const std::function<std::string(const std::string &)> &wrong) { return option_->check(wrong), *this; }
Option &Option::one_at_a_time() { return option_->allow_extra_args(false), *this; }
Option &Option::separated_by(char c) { return option_->delimiter(c), *this; }
Option &Option::excludes(const Option &other) { return option_->excludes(other.option_), *this; }
Option &Option::shows_default() { return option_->capture_default_str(), *this; }

Command Command::add(const std::string &name, const std::string &help) { return Command(app_->add_subcommand(name, help)); }

Command &Command::task(const std::string &name, const std::string &example) {
    app_->group(name)->description(app_->get_description() + "\ne.g. sixdeg " + example);
    return *this;
}

Option Command::option(const std::string &name, std::string &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, std::vector<std::string> &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, int &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, unsigned &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, std::uint64_t &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, std::optional<std::uint64_t> &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::option(const std::string &name, double &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::flag(const std::string &name, bool &value, const std::string &help) { return Option(app_->add_flag(name, value, help)); }

Option Command::output_folder(std::string &folder, const std::string &help) {
    return option("--out", folder, help).checked([](const std::string &path) {
        return std::string(path == "-" ? "standard output holds one file; give a folder" : "");
    });
}
Option Command::number(std::string &value) { return option("--number", value, "f32 or q31").one_of({"f32", "q31"}); }
Option Command::settings(std::vector<std::string> &value, const std::string &help) { return option("--set", value, help).one_at_a_time(); }

void Command::runs(std::function<void()> action) {
    std::string name = app_->get_name(); // such as "study afr"
    for (const CLI::App *above = app_->get_parent(); above && above->get_parent(); above = above->get_parent())
        name = above->get_name() + " " + name;
    app_->callback([name, action = std::move(action)] {
        const Progress progress(name);
        action();
    });
}
void Command::runs_without_progress(std::function<void()> action) { app_->callback(std::move(action)); }
void Command::needs_command() { app_->require_subcommand(1); }

namespace {

/// Which word means nothing to the command that was reached, and the nearest valid name; "" where none is near.
std::string hint_for_extras(const CLI::App &top) {
    const CLI::App *command = &top;
    while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
    std::vector<std::string> names;
    for (const CLI::App *below : command->get_subcommands([](const CLI::App *) { return true; })) names.push_back(below->get_name());
    for (const CLI::Option *option : command->get_options()) names.push_back(option->get_name());
    for (const std::string &word : top.remaining(true)) {
        if (const std::string hint = nearest_hint(word.substr(0, word.find('=')), names); !hint.empty())
            return (command == &top ? "" : command->get_name() + ": ") + "'" + word + "' is not known" + hint;
    }
    return "";
}

} // namespace

int run_command_line(const std::string &about, const std::function<void(Command &)> &add_commands, int argc, char **argv) {
    CLI::App app{about};
    Command top(&app);
    top.needs_command();
    add_commands(top);
    try {
        app.parse(argc, argv);
        return 0;
    } catch (const CLI::ParseError &error) {
        if (const std::string hint = error.get_exit_code() != 0 ? hint_for_extras(app) : ""; !hint.empty()) {
            fmt::print(stderr, "sixdeg: {}\n", hint);
            return 2;
        }
        return app.exit(error) == 0 ? 0 : 2; // CLI11 also throws for --help, which is no error
    }
}

} // namespace sixdeg
