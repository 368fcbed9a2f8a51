// SPDX-License-Identifier: MIT
#include "io/bus/bus.hpp"

#include <cstring>
#include <fmt/format.h>
#include <random>

#include "common/error.hpp"
extern "C" {
#include "sd_can.h"
#include "sd_lcm.h"
}

namespace sixdeg {
namespace {

/// Tells one start of a program from another.
std::uint16_t draw_session() { return std::uint16_t(std::random_device()()); }

template <class Codec> std::optional<sd_claim_t> take_claim(Codec &codec) {
    if (codec.claim_heard == 0) return std::nullopt;
    codec.claim_heard = 0;
    return codec.claim;
}

class CanBus : public Bus {
  public:
    CanBus(const std::string &interface, sd_role_t role) {
        const int error = sd_can_open(&can_, interface.c_str(), role, draw_session());
        if (error == 0) return;
        const char *const why = error == ENODEV ? "no such interface"
                                : error == EMSGSIZE ? "its mtu is below 72; CAN FD needs `ip link set IFACE mtu 72`"
                                : error == EAFNOSUPPORT ? "this kernel has no CAN; tools/can-kernel runs a command in one that has"
                                                        : std::strerror(error);
        throw InputError("can:" + interface, "", why);
    }
    ~CanBus() override { sd_can_close(&can_); }
    sd_port_t port() override { return sd_can_port(&can_); }
    bool wait(int milliseconds) override { return sd_can_wait(&can_, milliseconds) != 0; }
    void claim(sd_claim_t claim) override {
        sd_can_encode_claim(&can_.codec, claim);
        sd_can_flush(&can_);
    }
    std::optional<sd_claim_t> heard_claim() override { return take_claim(can_.codec); }
    void send_truth(const sd_truth_t &truth) override {
        if (!sd_can_encode_truth(&can_.codec, &truth) && (sd_can_flush(&can_), true)) sd_can_encode_truth(&can_.codec, &truth);
        if (truth.kind == sd_truth_t::SD_TRUTH_END) sd_can_flush(&can_);
    }
    bool next_truth(sd_truth_t &truth) override {
        if (sd_can_read(&can_) == 0) return false;
        truth = can_.codec.truth;
        return true;
    }
    std::uint32_t peer_starts() const override { return can_.codec.peer_starts + can_.codec.order.starts; }
    const sd_port_counts_t &counts() const override { return can_.codec.counts; }

  private:
    sd_can_t can_;
};

class LcmBus : public Bus {
  public:
    LcmBus(const std::string &url, sd_role_t role) {
        if (sd_lcm_open(&lcm_, url.c_str(), role, draw_session()) != 0)
            throw InputError("lcm:" + url, "", "LCM cannot use this; allowed are its own URLs, like udpm://239.255.76.67:7667?ttl=0");
    }
    ~LcmBus() override { sd_lcm_close(&lcm_); }
    sd_port_t port() override { return sd_lcm_port(&lcm_); }
    bool wait(int milliseconds) override {
        return lcm_.codec.in.read != lcm_.codec.in.written || sd_lcm_wait(&lcm_, milliseconds) != 0;
    }
    void claim(sd_claim_t claim) override { sd_lcm_claim(&lcm_, claim); }
    std::optional<sd_claim_t> heard_claim() override { return take_claim(lcm_.codec); }
    void send_truth(const sd_truth_t &truth) override { sd_lcm_truth(&lcm_, &truth); }
    bool next_truth(sd_truth_t &truth) override {
        sd_lcm_codec_t &codec = lcm_.codec;
        if (codec.truth_read == codec.truth_written) return false;
        truth = codec.truth[codec.truth_read++ % SD_LCM_TRUTHS];
        return true;
    }
    std::uint32_t peer_starts() const override { return lcm_.codec.peer_starts + lcm_.codec.order.starts; }
    const sd_port_counts_t &counts() const override { return lcm_.codec.counts; }

  private:
    sd_lcm_t lcm_;
};

} // namespace

std::unique_ptr<Bus> open_bus(const std::string &transport, sd_role_t role) {
    const auto colon = transport.find(':');
    const std::string kind = transport.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : transport.substr(colon + 1);
    if (kind == "can" && !rest.empty()) return std::make_unique<CanBus>(rest, role);
    if (kind == "lcm") return std::make_unique<LcmBus>(rest, role);
    throw InputError("--transport", transport, "not a bus; allowed: can:IFACE, lcm, lcm:URL");
}

std::string describe(const sd_port_counts_t &c) {
    return fmt::format("sent {}, received {}, unsent {}, foreign {}, malformed {}, gaps {}, stale {}", c.sent, c.received,
                       c.unsent, c.foreign, c.malformed, c.gaps, c.stale);
}

} // namespace sixdeg
