// SPDX-License-Identifier: MIT
#include "loop/ecu_bench.hpp"

#include <stdexcept>

namespace sixdeg {

EcuBench::EcuBench(const sd_calibration_t &calibration)
    : EcuFeed(double(calibration.tick_hz)), page_(calibration), ecu_side_(sd_inproc_ecu_side(&port_)),
      host_side_(sd_inproc_host_side(&port_)) {
    restart();
}

void EcuBench::restart() {
    if (sd_ecu_init(&ecu_, page_.view()) != SD_OK)
        throw std::logic_error("a checked calibration was refused");
}

void EcuBench::listen(EventListener listener) {
    tap_ = std::make_unique<PortTap>(ecu_side_, std::move(listener));
    ecu_side_ = tap_->port();
}

bool EcuBench::exchange(const sd_event_t &event) {
    host_side_.send(host_side_.context, &event, 1);
    sd_ecu_run(&ecu_, page_.view(), &ecu_side_);
    bool cycle_ended = false;
    const std::size_t firings = said_.firings();
    sd_event_t answers[16];
    std::uint32_t count;
    while ((count = host_side_.receive(host_side_.context, answers, 16)) > 0) {
        for (std::uint32_t i = 0; i < count; ++i) {
            cycle_ended |= said_.take(answers[i]);
            hear(answers[i]);
        }
    }
    if (said_.firings() != firings)
        fuel_cut_.firing(ecu_, page_.view()->cylinders, double(said_.signals().firing_torque_nm),
                         said_.health(SD_OWNER_FIRING) == SD_VALID);
    return cycle_ended;
}

Evidence EcuBench::evidence() const {
    Evidence evidence = evidence_of(ecu_, *page_.view());
    fuel_cut_.add_to(evidence);
    return evidence;
}

} // namespace sixdeg
