# SPDX-License-Identifier: MIT
"""Processes on a bus, and the folder that a test of them writes to.

Nothing here depends on how fast the machine is: a test waits until a process has said something or so many clock events
have been answered on the bus, and gives up after a minute or more.
"""
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import time

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools" / "log"))

SIXDEG = os.environ["SIXDEG"]
ENGINE = ROOT / "host_sim" / "data" / "engines" / "diesel_22.toml"
FUEL = "fuel_percent = [10, 0, 0, -20]"
MIXTURE = "[control]\nbalance_on_s = [0, 1000]\n[uego]\nnoise_per_rthz = 1.83e-4\n"
PATIENCE_S = 120


def in_own_network():
    """Runs this program again where LCM's multicast stays within it, if the machine lets us."""
    if os.environ.get("SD_OWN_NETWORK"):
        return
    network = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"
    unshare = ["unshare", "--net"] + ([] if os.getuid() == 0 else ["--map-root-user"])
    if subprocess.run(unshare + ["sh", "-c", network], capture_output=True).returncode == 0:
        os.environ["SD_OWN_NETWORK"] = "1"
        os.execvp("unshare", unshare + ["sh", "-c", network + ' && exec "$@"', "sh", sys.executable] + sys.argv)


def until(condition, what):
    """Waits for it."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain for {what}")
        time.sleep(0.01)


class Process:
    """A program whose output goes to files: it never waits for us to read, and we never for whoever inherits a pipe."""

    def __init__(self, folder, *words):
        self.paths = [folder / f"{name}_{time.monotonic_ns()}" for name in ("out", "err")]
        with self.paths[0].open("w") as out, self.paths[1].open("w") as err:
            self.popen = subprocess.Popen(list(map(str, words)), stdin=subprocess.DEVNULL, stdout=out, stderr=err)

    @property
    def out(self):
        return self.paths[0].read_text()

    @property
    def err(self):
        return self.paths[1].read_text()

    def expect(self, text, times=1):
        """Waits until it has said so on stderr."""
        until(lambda: self.err.count(text) >= times or self.popen.poll() is not None, f"{text!r} in {self.err!r}")
        if self.err.count(text) < times:
            raise AssertionError(f"ended with {self.popen.returncode} before it said {text!r}: {self.err}")

    def wait(self, seconds=PATIENCE_S):
        return self.popen.wait(seconds)

    def end(self, number=signal.SIGTERM):
        self.popen.send_signal(number)
        return self.wait()

    def kill(self):
        if self.popen.poll() is None:
            self.popen.kill()
        self.popen.wait()


class Beats:
    """Counts answered clock events: messages of a socket that are such answers."""

    def __init__(self, socket, is_beat=lambda message: True):
        self.socket, self.is_beat = socket, is_beat
        self.close = socket.close

    def wait(self, count):
        """Until so many more have been seen."""
        self.socket.setblocking(False)
        try:
            while self.socket.recv(65536):
                pass  # of before
        except BlockingIOError:
            pass
        self.socket.settimeout(PATIENCE_S)
        while count > 0:
            count -= self.is_beat(self.socket.recv(65536))


def lcm_beats(group="239.255.76.67", port=7667):
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    heard.bind(("", port))
    heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("=4sI", socket.inet_aton(group), socket.INADDR_ANY))
    # LCM's own wire format: magic, sequence, channel, data.
    return Beats(heard, lambda message: message.startswith(b"LC02") and message[8:].startswith(b"SIXDEG_OUTPUTS\0"))


class BusFolder(Folder):
    transport = None  # of the derived class

    def setUp(self):
        super().setUp()
        self.processes = []
        self.addCleanup(lambda: [process.kill() for process in self.processes])

    def scenario(self, run="cycles = 25", rpm=1000, more=""):
        path = self.folder / f"scenario_{rpm}.toml"
        path.write_text(f'engine = "{ENGINE}"\n[run]\n{run}\n[speed]\nrpm = {rpm}\n[load]\nbmep_bar = 5\n[cylinders]\n{FUEL}\n'
                        f"[[misfires.event]]\ncycle = 20\ncylinder = 4\n{more}")
        return path

    def process(self, *words):
        process = Process(self.folder, *words)
        self.processes.append(process)
        return process

    def start(self, *arguments):
        return self.process(SIXDEG, *arguments)

    def sixdeg(self, *arguments, status=0):
        done = self.start(*arguments)
        self.assertEqual(done.wait(250), status, done.err)
        return done

    def ecu(self, *more):
        process = self.start("ecu", ENGINE, "--transport", self.transport, *more)
        process.expect("running on")
        return process

    def watch(self, *more):
        process = self.start("watch", "--transport", self.transport, *more)
        process.expect("listening on")
        return process

    def beats(self):
        beats = self.new_beats()
        self.addCleanup(beats.close)
        return beats

    def running_plant(self, rpm=3000):
        """In lock-step, with the folder it writes when it is ended."""
        out = self.folder / f"plant_{time.monotonic_ns()}"
        return self.start("plant", self.scenario("duration_s = 6000", rpm), "--transport", self.transport, "--out", out), out

    def csv_bytes(self, name):
        return [(self.folder / name / file).read_bytes() for file in ("cycles.csv", "teeth.csv")]

    def valid_by_cycle(self, out):
        cycles = {}
        for row in table(out / "cycles.csv"):
            cycles[int(row["cycle"])] = cycles.get(int(row["cycle"]), True) and row["health"] == "valid"
        return cycles

    def replays(self, log, *more):
        """The log is whole, and its inputs give its outputs again, event for event."""
        self.sixdeg("replay", log, "--json", self.folder / "replay.json", *more)
        summary = json.loads((self.folder / "replay.json").read_text())
        self.assertTrue(summary["outputs"]["identical"], summary["outputs"])
        return summary
