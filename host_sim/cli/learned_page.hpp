// SPDX-License-Identifier: MIT
// What the firmware learned, between runs, alike in `run` and `replay`.
#pragma once
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string>

#include "common/error.hpp"
#include "common/files.hpp"
extern "C" {
#include "sd_learned.h"
}

namespace sixdeg {

/// Why these bytes are no learned page, in words.
inline std::string no_learned_page(const std::string &bytes) {
    const std::uint32_t magic = SD_LEARNED_MAGIC;
    const std::string format(reinterpret_cast<const char *>(&magic), sizeof magic), found = bytes.substr(0, format.size());
    if (found != format && found.substr(0, 3) == format.substr(0, 3))
        return fmt::format("it is of format {}, and this firmware reads {}: let it learn anew (--learn)", found, format);
    return "it is damaged, or of another version of the signal table";
}

/// Throws InputError for a page that is damaged or of another format. Its checksum goes into `files`.
inline sd_kept_t read_learned_page(const std::string &path, nlohmann::ordered_json &files) {
    const std::string bytes = read_file(path);
    const sd_kept_t *kept = sd_learned_view(bytes.data(), std::uint32_t(bytes.size()));
    if (!kept) throw InputError(path, "learned page", no_learned_page(bytes));
    files[path] = sha256(bytes);
    return *kept;
}

inline std::string learned_page(const sd_kept_t &kept) {
    sd_learned_t page{};
    sd_learned_make(&page, &kept);
    return {reinterpret_cast<const char *>(&page), sizeof page};
}

} // namespace sixdeg
