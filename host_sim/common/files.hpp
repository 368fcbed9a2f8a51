// SPDX-License-Identifier: MIT
// Whole files in and out. Nothing is ever left half-written: text goes beside its target, then is renamed.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace sixdeg {

/// The whole file. Throws InputError naming the file when it cannot be read.
std::string read_file(const std::filesystem::path &path);

/// Writes beside `path`, then renames over it. Creates missing parent folders. "-" is standard output. Throws InputError.
void write_file(const std::filesystem::path &path, std::string_view content);

/// True for "-", which stands for standard output wherever one file is written.
inline bool is_standard_output(const std::filesystem::path &path) { return path == "-"; }
/// Writes to standard output at once. Throws InputError when nobody takes it.
void write_standard_output(std::string_view content);
/// From now on standard output takes only what is written by the two functions above; words for people go to standard error, so
/// that a reader of "-" finds the file alone. Called once, before anything is printed. Throws InputError.
void keep_standard_output_for_files();

/// SHA-256 of `content`, 64 lower-case hex digits, as sha256sum prints it.
std::string sha256(std::string_view content);

/// A set of output files that appear together: add() only remembers, commit() writes them all.
class OutputFolder {
  public:
    /// Throws InputError for "-": standard output holds one file, not a folder.
    explicit OutputFolder(std::filesystem::path folder);
    void add(const std::string &name, std::string content) { files_[name] = std::move(content); }
    /// Writes every file beside its target, and only when all are on disk renames them. Throws InputError.
    void commit() const;

  private:
    std::filesystem::path folder_;
    std::map<std::string, std::string> files_;
};

} // namespace sixdeg
