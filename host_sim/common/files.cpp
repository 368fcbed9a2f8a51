// SPDX-License-Identifier: MIT
#include "common/files.hpp"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <openssl/evp.h>
#include <unistd.h>
#include <vector>

#include "common/error.hpp"
#include "common/nearest.hpp"

namespace fs = std::filesystem;
namespace sixdeg {
namespace {

int standard_output = STDOUT_FILENO; // where "-" goes

std::vector<fs::path> inputs; // not to be written over

fs::path beside(const fs::path &path) { return path.string() + ".partial"; }

/// Where a path leads: through links, whether or not the last one leads to a file.
fs::path followed(fs::path path) {
    std::error_code ec;
    for (int links = 0; links < 40 && fs::is_symlink(path, ec); ++links) {
        const fs::path target = fs::read_symlink(path, ec);
        path = target.is_absolute() ? target : path.parent_path() / target;
    }
    return path;
}

/// A device, a FIFO, a socket: there is nothing to rename.
bool is_written_through(const fs::path &path) {
    std::error_code ec;
    return fs::is_other(fs::status(path, ec));
}

/// Where to write for `path`. Throws InputError for an input.
fs::path target_of(const fs::path &path) {
    std::error_code ec;
    for (const fs::path &input : inputs) {
        if (fs::equivalent(path, input, ec)) throw InputError(path.string(), "", "is an input of this command; it is not written over");
    }
    return followed(path);
}

[[noreturn]] void fail_to_write(const fs::path &path) { throw InputError(path.string(), "", "cannot be written"); }

void write_beside(const fs::path &path, std::string_view content) {
    std::error_code ec;
    if (path.has_parent_path()) fs::create_directories(path.parent_path(), ec);
    std::ofstream out(beside(path), std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) {
        fs::remove(beside(path), ec);
        fail_to_write(path);
    }
}

void write_through(const fs::path &path, std::string_view content) {
    std::ofstream out(path, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) fail_to_write(path);
}

void rename_into_place(const fs::path &path) {
    std::error_code ec;
    fs::rename(beside(path), path, ec);
    if (!ec) return;
    const std::string why = ec.message();
    fs::remove(beside(path), ec);
    throw InputError(path.string(), "", "cannot be written (" + why + ")");
}

std::string hex_of(const unsigned char *digest, unsigned int size) {
    static const char hex[] = "0123456789abcdef";
    std::string text;
    for (unsigned int i = 0; i < size; ++i) {
        text += hex[digest[i] >> 4];
        text += hex[digest[i] & 15];
    }
    return text;
}

} // namespace

std::string read_file(const fs::path &path) {
    std::error_code ec;
    if (fs::is_directory(path, ec)) throw InputError(path.string(), "", "is a folder, not a file");
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path.string(), "", "cannot be read" + nearest_file_hint(path));
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_standard_output(std::string_view content) {
    while (!content.empty()) {
        const ssize_t wrote = ::write(standard_output, content.data(), content.size());
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) throw InputError("-", "", "standard output cannot be written");
        content.remove_prefix(std::size_t(wrote));
    }
}

void keep_standard_output_for_files() {
    const int kept = ::dup(STDOUT_FILENO);
    if (kept < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) throw InputError("-", "", "standard output cannot be written");
    standard_output = kept;
}

void protect_input(const fs::path &path) { inputs.push_back(path); }

void check_output(const fs::path &path) { (void)target_of(path); }

void write_file(const fs::path &path, std::string_view content) {
    if (is_standard_output(path)) return write_standard_output(content);
    const fs::path target = target_of(path);
    if (is_written_through(target)) return write_through(target, content);
    write_beside(target, content);
    rename_into_place(target);
}

std::string sha256(std::string_view content) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_Digest(content.data(), content.size(), digest, &size, EVP_sha256(), nullptr);
    return hex_of(digest, size);
}

std::string sha256_of_file(const fs::path &path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path.string(), "", "cannot be read" + nearest_file_hint(path));
    const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
    EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
    std::string piece(std::size_t(1) << 18, 0);
    while (in) {
        in.read(piece.data(), std::streamsize(piece.size()));
        EVP_DigestUpdate(context.get(), piece.data(), std::size_t(in.gcount()));
    }
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context.get(), digest, &size);
    return hex_of(digest, size);
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
    if (is_standard_output(folder_)) throw InputError("-", "", "standard output holds one file; give a folder");
}

OutputFolder::~OutputFolder() {
    std::error_code ec;
    for (const auto &[name, stream] : streams_) fs::remove(beside(folder_ / name), ec);
}

std::ostream &OutputFolder::stream(const std::string &name) {
    const fs::path path = target_of(folder_ / name);
    if (is_written_through(path) || path != folder_ / name) throw InputError(path.string(), "",
                                                                             "is a link or no regular file; it is not written over");
    std::error_code ec;
    fs::create_directories(folder_, ec);
    auto &stream = streams_[name];
    stream = std::make_unique<std::ofstream>(beside(path), std::ios::binary);
    if (!*stream) fail_to_write(path);
    return *stream;
}

void OutputFolder::commit() {
    std::vector<fs::path> written;
    try {
        for (const auto &[name, content] : files_) {
            const fs::path path = target_of(folder_ / name);
            if (is_written_through(path)) {
                write_through(path, content);
                continue;
            }
            write_beside(path, content);
            written.push_back(path);
        }
        for (const auto &[name, stream] : streams_) {
            stream->close();
            if (!*stream) fail_to_write(folder_ / name);
        }
    } catch (...) {
        std::error_code ec;
        for (const auto &path : written) fs::remove(beside(path), ec);
        throw;
    }
    for (const auto &[name, stream] : streams_) written.push_back(folder_ / name);
    streams_.clear();
    for (const auto &path : written) rename_into_place(path);
}

} // namespace sixdeg
