// SPDX-License-Identifier: MIT
#include "io/log/event_log.hpp"

#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <openssl/evp.h>
#include <string_view>

#include "common/error.hpp"
#include "common/files.hpp"
#include "io/page/page_bytes.hpp"
extern "C" {
#include "sd_ecu.h"
}

namespace fs = std::filesystem;
namespace sixdeg {
namespace {

constexpr char kMagic[] = "SDL1";
constexpr std::size_t kHeaderBytes = 24, kEventBytes = 16, kDigestBytes = 32, kChunkBytes = 1 << 16;

/// Little endian, whatever the host.
template <typename T> void put(std::string &bytes, T value) {
    for (std::size_t i = 0; i < sizeof value; ++i) bytes += char(std::uint64_t(value) >> (8 * i) & 0xff);
}

template <typename T> T take(const char *bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t(std::uint8_t(bytes[i])) << (8 * i);
    return T(value);
}

class Sha256 {
  public:
    Sha256() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
    void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
    std::string digest() {
        std::string bytes(kDigestBytes, '\0');
        EVP_DigestFinal_ex(context_.get(), reinterpret_cast<unsigned char *>(bytes.data()), nullptr);
        return bytes;
    }

  private:
    std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX *)> context_{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

std::string header(const std::string &about, const sd_calibration_t &calibration) {
    const std::vector<std::uint8_t> page = page_bytes(calibration);
    const double tick_hz = double(calibration.tick_hz);
    std::uint64_t tick_bits;
    std::memcpy(&tick_bits, &tick_hz, sizeof tick_bits);
    std::string bytes(kMagic, 4);
    put(bytes, std::uint32_t(SD_SIGNALS_SIGNATURE));
    put(bytes, std::uint32_t(about.size()));
    put(bytes, std::uint32_t(page.size()));
    put(bytes, tick_bits);
    return bytes + about + std::string(page.begin(), page.end());
}

} // namespace

struct LogWriter::File {
    fs::path path, partial;
    std::ofstream out;
    std::string waiting;
    Sha256 sha;

    void flush() {
        sha.add(waiting);
        write(waiting);
        waiting.clear();
    }
    void write(std::string_view bytes) {
        if (is_standard_output(path)) write_standard_output(bytes);
        else out.write(bytes.data(), std::streamsize(bytes.size()));
    }
    [[noreturn]] void fail() const { throw InputError(path.string(), "", "cannot be written"); }
};

LogWriter::LogWriter(fs::path path, const std::string &about, const sd_calibration_t &calibration)
    : file_(new File{path, path.string() + ".partial", {}, header(about, calibration), {}}) {
    if (is_standard_output(path)) return;
    std::error_code ec;
    if (path.has_parent_path()) fs::create_directories(path.parent_path(), ec);
    file_->out.open(file_->partial, std::ios::binary);
    if (!file_->out || fs::is_directory(path, ec)) {
        fs::remove(file_->partial, ec);
        file_->fail();
    }
}

LogWriter::~LogWriter() {
    if (!file_ || is_standard_output(file_->path)) return;
    file_->out.close();
    std::error_code ec;
    fs::remove(file_->partial, ec);
}

void LogWriter::add(bool out, const sd_event_t &event) {
    std::string &bytes = file_->waiting;
    put(bytes, event.tick);
    put(bytes, std::uint16_t(event.kind | (out ? kLoggedOut : 0)));
    put(bytes, event.channel);
    put(bytes, event.value);
    put(bytes, event.flags);
    if (bytes.size() >= kChunkBytes) file_->flush();
}

void LogWriter::finish() {
    file_->flush();
    file_->write(file_->sha.digest());
    if (is_standard_output(file_->path)) return file_.reset();
    file_->out.close();
    std::error_code ec;
    if (file_->out) fs::rename(file_->partial, file_->path, ec);
    if (!file_->out || ec) file_->fail(); // the destructor takes the rest away
    file_.reset();
}

bool is_log(const fs::path &path) {
    char magic[4] = {};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return std::memcmp(magic, kMagic, sizeof magic) == 0;
}

EventLog read_log(const fs::path &path) {
    const std::string bytes = read_file(path);
    const auto fail = [&](const std::string &why) -> EventLog { throw InputError(path.string(), "", why); };
    if (bytes.compare(0, 4, kMagic) != 0) return fail("is no event log: it does not begin with SDL1");
    if (bytes.size() < kHeaderBytes + kDigestBytes) return fail("is truncated");
    const std::size_t end = bytes.size() - kDigestBytes;
    Sha256 sha;
    sha.add(std::string_view(bytes).substr(0, end));
    if (sha.digest() != std::string_view(bytes).substr(end))
        return fail("is truncated or damaged: its checksum is wrong");

    const auto signature = take<std::uint32_t>(&bytes[4]);
    if (signature != SD_SIGNALS_SIGNATURE) {
        return fail(fmt::format("was written with signal table {:08x}; this program replays {:08x} only",
                                signature, SD_SIGNALS_SIGNATURE));
    }
    const std::uint64_t about = take<std::uint32_t>(&bytes[8]), page = take<std::uint32_t>(&bytes[12]);
    const std::uint64_t first = kHeaderBytes + about + page;
    if (first > end || (end - first) % kEventBytes != 0)
        return fail("has a header that does not fit its size");
    EventLog log{bytes.substr(kHeaderBytes, about), {}, {}};
    const auto calibration = read_page(std::string_view(bytes).substr(kHeaderBytes + about, page));
    const auto ecu = std::make_unique<sd_ecu_t>();
    if (!calibration || sd_ecu_init(ecu.get(), calibration.get()) != SD_OK)
        return fail("holds a calibration page that cannot be used");
    log.calibration = *calibration;
    for (std::size_t at = first; at < end; at += kEventBytes) {
        const char *event = &bytes[at];
        log.events.push_back({take<std::uint32_t>(event), take<std::uint16_t>(event + 4),
                              take<std::uint16_t>(event + 6), take<std::uint32_t>(event + 8),
                              take<std::uint32_t>(event + 12)});
    }
    return log;
}

} // namespace sixdeg
