// SPDX-License-Identifier: MIT
// The tooth pattern between runs, alike in `run` and `replay`.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "common/error.hpp"
#include "common/files.hpp"
extern "C" {
#include "sd_learned.h"
}

namespace sixdeg {

/// Throws InputError for a page that is damaged. Its checksum goes into `files`.
inline sd_pattern_sums_t read_learned_page(const std::string &path, nlohmann::ordered_json &files) {
    const std::string bytes = read_file(path);
    const sd_pattern_sums_t *learned = sd_learned_view(bytes.data(), std::uint32_t(bytes.size()));
    if (!learned) throw InputError(path, "learned page", "it is damaged, or of another version of the signal table");
    files[path] = sha256(bytes);
    return *learned;
}

inline std::string learned_page(const sd_pattern_sums_t &learned) {
    sd_learned_t page{};
    sd_learned_make(&page, &learned);
    return {reinterpret_cast<const char *>(&page), sizeof page};
}

} // namespace sixdeg
