// SPDX-License-Identifier: MIT
#include "design/kept_pages.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <unistd.h>
#include <vector>

#include "common/files.hpp"

namespace fs = std::filesystem;
namespace sixdeg {
namespace {

constexpr std::size_t kMostPages = 64;
constexpr const char *kEnding = ".page";

/// Which program this is: another build may design other pages. Empty where the system does not tell.
std::string program() {
    std::error_code failed;
    const fs::path file = fs::read_symlink("/proc/self/exe", failed);
    if (failed) return "";
    const auto size = fs::file_size(file, failed);
    if (failed) return "";
    const auto written = fs::last_write_time(file, failed);
    return failed ? "" : fmt::format("{} {} {}", file.string(), size, written.time_since_epoch().count());
}

/// Empty where nothing can be kept.
std::string key_of(const std::string &engine_text, const sd_parameters_t &tune) {
    const std::string made_by = program();
    if (made_by.empty()) return "";
    const std::string numbers(reinterpret_cast<const char *>(&tune), sizeof tune);
    return sha256(fmt::format("{}\n{}\n{}\n", made_by, SD_SIGNALS_SIGNATURE, engine_text.size()) + engine_text + numbers);
}

/// A page lies behind its key, so that one under a wrong name is not taken.
std::unique_ptr<sd_calibration_t> read_kept(const fs::path &path, const std::string &key) {
    std::ifstream in(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    if (bytes.compare(0, key.size(), key) != 0) return nullptr;
    return read_page(std::string_view(bytes).substr(key.size()));
}

void forget_oldest(const fs::path &folder) {
    std::error_code failed;
    std::vector<std::pair<fs::file_time_type, fs::path>> pages;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
        std::error_code gone;
        const auto written = fs::last_write_time(entry->path(), gone);
        if (!gone && entry->path().extension() == kEnding) pages.emplace_back(written, entry->path());
    }
    if (pages.size() <= kMostPages) return;
    std::sort(pages.begin(), pages.end());
    for (std::size_t i = 0; i < pages.size() - kMostPages; ++i) fs::remove(pages[i].second, failed);
}

/// Under a name of this process's own first: nobody reads half a page.
void keep(const fs::path &path, const std::string &key, const sd_calibration_t &page) {
    std::error_code failed;
    fs::create_directories(path.parent_path(), failed);
    const fs::path beside = path.string() + fmt::format(".{}.partial", ::getpid());
    const std::vector<std::uint8_t> bytes = page_bytes(page);
    std::ofstream out(beside, std::ios::binary);
    out.write(key.data(), std::streamsize(key.size()));
    out.write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    out.close();
    if (out) fs::rename(beside, path, failed);
    if (!out || failed) fs::remove(beside, failed);
    forget_oldest(path.parent_path());
}

} // namespace

fs::path KeptPages::usual_folder() {
    const auto set = [](const char *name) {
        const char *value = std::getenv(name);
        return fs::path(value ? value : "");
    };
    const fs::path cache = set("XDG_CACHE_HOME"), home = set("HOME");
    if (cache.is_absolute()) return cache / "sixdeg"; // a relative one is to be ignored, the XDG base directories say
    return home.is_absolute() ? home / ".cache" / "sixdeg" : fs::path();
}

sd_calibration_t KeptPages::calibrate(const EngineFile &engine, const std::string &engine_text, const sd_parameters_t &tune,
                                      const std::string &tune_name) const {
    const std::string text = engine_text + (engine.air_path ? engine.air_path->design_text : "");
    const std::string key = folder_.empty() ? "" : key_of(text, tune);
    if (key.empty()) return sixdeg::calibrate(engine, tune, tune_name);
    const fs::path path = folder_ / (key + kEnding);
    if (const auto kept = read_kept(path, key)) {
        std::error_code failed;
        fs::last_write_time(path, fs::file_time_type::clock::now(), failed); // used just now
        return *kept;
    }
    const sd_calibration_t page = sixdeg::calibrate(engine, tune, tune_name);
    keep(path, key, page);
    return page;
}

} // namespace sixdeg
