// SPDX-License-Identifier: MIT
// How far a long command is, for the one who waits at a terminal: one line on stderr, redrawn five times a second, gone when the command
// ends. Nothing is shown in the first second, nor where stderr is no terminal: what reads stderr there wants errors alone.
#pragma once
#include <atomic>
#include <string>
#include <string_view>

namespace sixdeg {

/// A stage of a command for as long as the object lives; stages lie within one another. The bar shows the outermost stage with a total
/// (of those counted, above 1); the words before it name the stages around it.
///
///     const Progress study("study engines");
///     Progress progress("engine", 20);               // "study engines: engine 3 of 20 [##........] 10 %, 42 s left"
///     for (...) { ...; progress.next(); }
///
/// Stages are made and ended by one thread. While one lives, what is printed to a terminal goes above the line.
class Progress {
  public:
    enum Kind { counted, share };
    /// `total` is what at() and next() count to; 0: nobody knows, and the time that passed is shown alone. A stage of things that are
    /// counted says "3 of 20"; one of a `share`, such as of seconds or bytes, says the share alone.
    explicit Progress(std::string name, double total = 0, Kind kind = counted);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;
    /// So much is done, of `total`. Costs the store of a number: a loop may call it at every step.
    void at(double done) { done_.store(done, std::memory_order_relaxed); }
    void next() { at(done_.load(std::memory_order_relaxed) + 1); }

  private:
    friend class ProgressLine;
    const std::string name_;
    const double total_;
    const Kind kind_;
    const double began_s_;
    std::atomic<double> done_{0};
};

} // namespace sixdeg
