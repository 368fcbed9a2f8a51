// SPDX-License-Identifier: MIT
#include "common/stop.hpp"

#include <csignal>
#include <cstdio>

namespace sixdeg {
namespace {

volatile std::sig_atomic_t came = 0;

void on_signal(int number) { came = number; }

} // namespace

void stop_on_signals() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESETHAND; // no SA_RESTART: a blocking read returns, so that its loop can ask
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

int stop_signal() { return came; }

void end_by_signal() {
    if (came == 0) return;
    std::fflush(nullptr);
    std::raise(came); // its handler is gone since it came
}

} // namespace sixdeg
