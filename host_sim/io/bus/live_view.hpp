// SPDX-License-Identifier: MIT
// What an ecu says, as a page of text: torque, misfire, mixture and trim of every cylinder, and how far to trust them.
#pragma once
#include <array>
#include <map>
#include <string>

#include "io/events/ecu_feed.hpp"

namespace sixdeg {

class LiveView {
  public:
    void take(const sd_event_t &event);
    /// `silent`: nothing has been heard for a while, so all of it is old.
    std::string text(bool silent) const;

  private:
    struct Firing {
        int verdict;
        float index, limit;
    };
    std::string cylinder(int number, float mean_nm, float largest_nm) const;

    EcuSaid said_;
    std::map<int, Firing> firings_; ///< The last one of each cylinder.
    std::size_t cycles_ = 0;
};

} // namespace sixdeg
