// SPDX-License-Identifier: MIT
#include "common/files.hpp"

#include <fstream>
#include <iterator>
#include <memory>
#include <openssl/evp.h>
#include <vector>

#include "common/error.hpp"

namespace fs = std::filesystem;
namespace sixdeg {
namespace {

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

void write_file(const fs::path &path, std::string_view content) {
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
