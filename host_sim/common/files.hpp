// SPDX-License-Identifier: MIT
// Whole files in and out. Nothing is ever left half-written: text goes beside its target, then is renamed.
#pragma once
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace sixdeg {

/// The whole file. Throws InputError naming the file when it cannot be read.
std::string read_file(const std::filesystem::path &path);

/// Writes beside `path`, then renames over it. Creates missing parent folders. "-" is standard output. A link stays, and the file that
/// it names is written; a device or a FIFO is written through. Throws InputError, also for a file that was protected.
void write_file(const std::filesystem::path &path, std::string_view content);

/// True for "-", which stands for standard output wherever one file is written.
inline bool is_standard_output(const std::filesystem::path &path) { return path == "-"; }
/// Writes to standard output at once. Throws InputError when nobody takes it.
void write_standard_output(std::string_view content);
/// From now on standard output takes only what is written by the two functions above; words for people go to standard error, so
/// that a reader of "-" finds the file alone. Called once, before anything is printed. Throws InputError.
void keep_standard_output_for_files();

/// From now on nothing is written over this file: it is an input.
void protect_input(const std::filesystem::path &path);

/// Throws InputError where `path` is one of them: to be asked of every output before the first is written.
void check_output(const std::filesystem::path &path);

/// SHA-256 of `content`, 64 lower-case hex digits, as sha256sum prints it.
std::string sha256(std::string_view content);
/// The same of a file of any size, a piece at a time. Throws InputError.
std::string sha256_of_file(const std::filesystem::path &path);

/// A set of output files that appear together: add() only remembers, commit() writes them all.
class OutputFolder {
  public:
    /// Throws InputError for "-": standard output holds one file, not a folder.
    explicit OutputFolder(std::filesystem::path folder);
    ~OutputFolder();
    OutputFolder(const OutputFolder &) = delete;
    OutputFolder &operator=(const OutputFolder &) = delete;
    void add(const std::string &name, std::string content) { files_[name] = std::move(content); }
    /// A file that is too long to remember: what is put there goes to disk at once, and appears with the others. Throws InputError.
    std::ostream &stream(const std::string &name);
    /// Writes every file beside its target, and only when all are on disk renames them. Throws InputError.
    void commit();

  private:
    std::filesystem::path folder_;
    std::map<std::string, std::string> files_;
    std::map<std::string, std::unique_ptr<std::ofstream>> streams_;
};

} // namespace sixdeg
