// SPDX-License-Identifier: MIT
// The calibration page as bytes: for files, logs and a target's flash.
#pragma once
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

extern "C" {
#include "sd_calibration.h"
}

namespace sixdeg {

/// The page as it is stored.
std::vector<std::uint8_t> page_bytes(const sd_calibration_t &calibration);

/// A page as it lies in a target's flash: just its own bytes, aligned, read in place.
class StoredPage {
  public:
    explicit StoredPage(const sd_calibration_t &calibration);
    const sd_calibration_t *view() const { return reinterpret_cast<const sd_calibration_t *>(words_.data()); }

  private:
    std::vector<std::uint32_t> words_;
};

/// A stored page, with room behind it to change its tables; nullptr when the bytes are no page of this firmware.
std::unique_ptr<sd_calibration_t> read_page(std::string_view bytes);

} // namespace sixdeg
