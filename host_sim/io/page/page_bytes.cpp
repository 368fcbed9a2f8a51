// SPDX-License-Identifier: MIT
#include "io/page/page_bytes.hpp"

#include <cstring>

namespace sixdeg {

std::vector<std::uint8_t> page_bytes(const sd_calibration_t &calibration) {
    const auto sealed = std::make_unique<sd_calibration_t>(calibration);
    sd_calibration_seal(sealed.get());
    const auto *bytes = reinterpret_cast<const std::uint8_t *>(sealed.get());
    return {bytes, bytes + sd_calibration_bytes(sealed.get())};
}

StoredPage::StoredPage(const sd_calibration_t &calibration) {
    const std::vector<std::uint8_t> bytes = page_bytes(calibration);
    words_.resize((bytes.size() + 3) / 4);
    std::memcpy(words_.data(), bytes.data(), bytes.size());
}

std::unique_ptr<sd_calibration_t> read_page(std::string_view bytes) {
    auto page = std::make_unique<sd_calibration_t>(); // zeroed, and aligned as bytes of a file need not be
    if (bytes.size() > sizeof *page) return nullptr;
    std::memcpy(static_cast<void *>(page.get()), bytes.data(), bytes.size());
    return sd_calibration_view(page.get(), std::uint32_t(bytes.size())) ? std::move(page) : nullptr;
}

} // namespace sixdeg
