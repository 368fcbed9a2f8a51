// SPDX-License-Identifier: MIT
// The command line of `sixdeg`, in front of CLI11: the only file that compiles CLI11 is command_line.cpp, since its headers take the
// compiler 10 s in each file that includes them.
//
//     Command command = parent.add("calibrate", "engine file to the firmware's calibration page");
//     command.option("ENGINE", options->engine, "engine file (docs/reference/files.md)").required();
//     command.option("--jobs", options->jobs, "runs at a time").within(1, 256).shows_default();
//     command.runs([options] { run(*options); });
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace sixdeg {

/// An option of a command. Every function returns the option itself; what it demands is said in one line when it does not hold.
class Option {
  public:
    explicit Option(CLI::Option *option) : option_(option) {}
    Option &required();
    Option &one_of(const std::vector<std::string> &words);
    Option &within(double low, double high);             ///< Both ends allowed.
    Option &within(int low, int high) { return within_whole(low, high); }
    Option &within_whole(std::int64_t low, std::int64_t high);
    /// `wrong` returns what is wrong with the text, or nothing.
    Option &checked(const std::function<std::string(const std::string &)> &wrong);
    Option &one_at_a_time();      ///< Of a list: one value for each time the option is given.
    Option &separated_by(char c); ///< Of a list: several values in one word.
    Option &excludes(const Option &other);
    Option &shows_default(); ///< --help shows the value that the variable has now.

  private:
    CLI::Option *option_;
};

/// A command, or a group of commands. Names that begin with -- are options, others come in the order in which they are added.
class Command {
  public:
    explicit Command(CLI::App *app) : app_(app) {}
    /// A command below this one.
    Command add(const std::string &name, const std::string &help);
    /// The task under which --help lists this command, and a command line to begin with.
    Command &task(const std::string &name, const std::string &example);
    /// The value is written to `value`, which must live until the command has run; it keeps what it has where nothing is given.
    Option option(const std::string &name, std::string &value, const std::string &help);
    Option option(const std::string &name, std::vector<std::string> &value, const std::string &help);
    Option option(const std::string &name, int &value, const std::string &help);
    Option option(const std::string &name, unsigned &value, const std::string &help);
    Option option(const std::string &name, std::uint64_t &value, const std::string &help);
    Option option(const std::string &name, std::optional<std::uint64_t> &value, const std::string &help);
    Option option(const std::string &name, double &value, const std::string &help);
    Option flag(const std::string &name, bool &value, const std::string &help);
    /// --out FOLDER. "-" is refused before anything runs: standard output holds one file.
    Option output_folder(std::string &folder, const std::string &help);
    /// --number f32 or q31.
    Option number(std::string &value);
    /// --set KEY=VALUE, as often as one likes.
    Option settings(std::vector<std::string> &value, const std::string &help);
    /// What happens when the command is given. A terminal shows how far it is (common/progress.hpp).
    void runs(std::function<void()> action);
    /// The same for a command that waits for others, or draws on the terminal itself.
    void runs_without_progress(std::function<void()> action);
    /// A group: one of the commands below it must be given.
    void needs_command();

  private:
    CLI::App *app_;
};

/// Reads the words of the command line and runs what they say. Returns the exit status of reading: 0, or 2 after a line that says what
/// is wrong with them. What an action throws passes through.
int run_command_line(const std::string &about, const std::function<void(Command &)> &add_commands, int argc, char **argv);

} // namespace sixdeg
