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

namespace fs = std::filesystem;
namespace sixdeg {
namespace {

int standard_output = STDOUT_FILENO; // where "-" goes

fs::path beside(const fs::path &path) { return path.string() + ".partial"; }

void write_beside(const fs::path &path, std::string_view content) {
    std::error_code ec;
    if (path.has_parent_path()) fs::create_directories(path.parent_path(), ec);
    std::ofstream out(beside(path), std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) {
        fs::remove(beside(path), ec);
        throw InputError(path.string(), "", "cannot be written");
    }
}

void rename_into_place(const fs::path &path) {
    std::error_code ec;
    fs::rename(beside(path), path, ec);
    if (!ec) return;
    const std::string why = ec.message();
    fs::remove(beside(path), ec);
    throw InputError(path.string(), "", "cannot be written (" + why + ")");
}

} // namespace

std::string read_file(const fs::path &path) {
    std::error_code ec;
    if (fs::is_directory(path, ec)) throw InputError(path.string(), "", "is a folder, not a file");
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path.string(), "", "cannot be read");
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

void write_file(const fs::path &path, std::string_view content) {
    if (is_standard_output(path)) return write_standard_output(content);
    write_beside(path, content);
    rename_into_place(path);
}

std::string sha256(std::string_view content) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_Digest(content.data(), content.size(), digest, &size, EVP_sha256(), nullptr);
    static const char hex[] = "0123456789abcdef";
    std::string text;
    for (unsigned int i = 0; i < size; ++i) {
        text += hex[digest[i] >> 4];
        text += hex[digest[i] & 15];
    }
    return text;
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
    if (is_standard_output(folder_)) throw InputError("-", "", "standard output holds one file; give a folder");
}

void OutputFolder::commit() const {
    std::vector<fs::path> written;
    try {
        for (const auto &[name, content] : files_) {
            write_beside(folder_ / name, content);
            written.push_back(folder_ / name);
        }
    } catch (...) {
        std::error_code ec;
        for (const auto &path : written) fs::remove(beside(path), ec);
        throw;
    }
    for (const auto &path : written) rename_into_place(path);
}

} // namespace sixdeg
