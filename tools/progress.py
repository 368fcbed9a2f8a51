# SPDX-License-Identifier: MIT
"""How far a long command is, for the one who waits at a terminal: one line on stderr, redrawn, gone at the end. Nothing in the first
second, nor where stderr is no terminal. The programs of sixdeg draw the same line (host_sim/common/progress.hpp).

    for file in progress.over(files, "tool: file"): ...   # "tool: file 3 of 20 [##....] 10 %, 42 s left"
    with progress.Progress("design"): ...                 # "design, 4 s": nobody knows how much there is
"""
import os
import sys
import threading
import time

FIRST_S, REDRAW_S, COLUMNS = 1.0, 0.2, 24
USUAL_COLUMNS = 80  # of a terminal that does not say how wide it is
ERASE = "\r\033[K"


def duration(seconds):
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


class Above:
    """A stream that leads to the terminal: what is printed to it goes above the line."""

    def __init__(self, stream, stage):
        self.stream, self.stage = stream, stage

    def write(self, text):
        with self.stage.lock:
            self.stage.erase()
            self.stage.amid_line = not text.endswith("\n") if text else self.stage.amid_line
            written = self.stream.write(text)
            self.stream.flush()
            return written

    def __getattr__(self, name):
        return getattr(self.stream, name)


class Progress:
    """A stage of a command, `total` things long; 0: the time that passed is shown alone. One at a time."""

    def __init__(self, name, total=0):
        self.name, self.total, self.done = name, total, 0
        self.began, self.ended, self.lock = time.monotonic(), threading.Event(), threading.RLock()
        self.terminal, self.drawer, self.drawn, self.amid_line = sys.stderr, None, False, False

    def __enter__(self):
        if self.terminal.isatty():
            self.streams = sys.stdout, sys.stderr
            sys.stdout, sys.stderr = (Above(s, self) if s.isatty() else s for s in self.streams)
            self.drawer = threading.Thread(target=self.draw, daemon=True)
            self.drawer.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        if self.drawer:
            self.drawer.join()
            sys.stdout, sys.stderr = self.streams

    def next(self):
        self.done += 1

    def line(self):
        passed = time.monotonic() - self.began
        if self.total <= 1:
            return f"{self.name}, {duration(passed)}"
        share = min(1, self.done / self.total)
        bar = "#" * int(share * COLUMNS)
        left = f", {duration(passed * (1 - share) / share)} left" if share else ""
        return f"{self.name} {min(self.done + 1, self.total)} of {self.total} [{bar:.<{COLUMNS}}] {100 * share:.0f} %{left}"

    def show(self, text):
        self.terminal.write(text)
        self.terminal.flush()

    def erase(self):
        if self.drawn:
            self.show(ERASE)
        self.drawn = False

    def draw(self):
        wait = FIRST_S
        while not self.ended.wait(wait):
            wait = REDRAW_S
            with self.lock:
                if not self.amid_line:
                    self.show(ERASE + self.line()[:(os.get_terminal_size(self.terminal.fileno()).columns or USUAL_COLUMNS) - 1])
                    self.drawn = True
        self.erase()


def over(things, name):
    """The things one after the other."""
    things = list(things)
    with Progress(name, len(things)) as stage:
        for thing in things:
            yield thing
            stage.next()
