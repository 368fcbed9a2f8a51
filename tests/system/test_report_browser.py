#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The report in a real browser without a network: every picture holds its traces, nothing is logged as an error, dark mode, paper, zoom.

Of made folders; SD_REPORT=out/demo/report.html names another report to be looked at, which tools/demo has made."""
import io
import os
import pathlib
import unittest

import numpy as np
from PIL import Image

from browser import Browser, program
from sixdeg_test import ReportFolder, charts
from test_report_mixture import write_run as write_mixture
from test_report_run import write_misfires, write_run

MOST_BYTES = 8_000_000  # of the whole report
# A picture's traces that are drawn: lines or points that are somewhere, bars that have their value beside them.
DRAWN = """[...document.querySelectorAll('figure.chart')].map((figure) => {
    const shown = (trace) => trace.matches('.bars') ? trace.querySelector('.bartext') :
        [...trace.querySelectorAll('path')].some((p) => p.getTotalLength() > 0);
    return {name: figure.getAttribute('aria-label'), asked: figure.querySelector('.plot').data.length,
            drawn: [...figure.querySelectorAll('.trace')].filter(shown).length,
            height: figure.querySelector('.main-svg').getBoundingClientRect().height};
})"""
PLACE = """(() => { const r = document.querySelectorAll('figure.chart')[%d].getBoundingClientRect();
    return {x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height}; })()"""
SCREENS = {"light": (255, 255, 255), "dark": (0x16, 0x18, 0x1c)}  # paper of page.css


@unittest.skipIf(program() is None, "no Chromium here; tools/setup --browser installs one")
class ReportInABrowser(ReportFolder):
    def setUp(self):
        super().setUp()
        if "SD_REPORT" in os.environ:
            self.page = pathlib.Path(os.environ["SD_REPORT"])
            page = self.page.read_text()
        else:
            write_misfires(self.folder / "monitor")
            write_misfires(self.folder / "other", "FOLSMO, f32")
            write_run(self.folder / "run")
            write_mixture(self.folder / "mixture")
            page = self.drawn("--misfire", self.folder / "monitor", self.folder / "other", "--figure-6", self.folder / "run", "--figure-16",
                              self.folder / "mixture")
        self.asked = charts(page)
        self.browser = Browser()
        self.addCleanup(self.browser.close)

    def picture(self, number):
        png = self.browser.screenshot(clip=self.browser.ask(PLACE % number))
        return np.array(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def test_pictures_are_drawn_light_and_dark_on_paper_and_can_be_zoomed(self):
        self.assertLess(self.page.stat().st_size, MOST_BYTES)
        for screen, paper in SCREENS.items():
            self.browser.open(self.page, dark=screen == "dark")
            pictures = self.browser.ask(DRAWN)
            self.assertEqual([p["asked"] for p in pictures], [len(c["data"]) for c in self.asked])
            for number, picture in enumerate(pictures):
                with self.subTest(screen=screen, picture=picture["name"]):
                    self.assertGreater(picture["height"], 200)
                    self.assertEqual(picture["drawn"], picture["asked"])
                    self.looked_at(number, paper)
        self.zoomed_and_switched_off()
        self.on_paper()
        self.assertEqual(self.browser.faults, [])

    def looked_at(self, number, paper):
        """Much of a picture is paper, and what is written on it stands out."""
        pixels = self.picture(number)
        off = np.abs(pixels - paper).max(axis=2)
        self.assertGreater((off < 8).mean(), 0.3)
        self.assertGreater((off > 60).mean(), 0.005)
        left = off[:, :60]  # numbers and name of the vertical axis
        self.assertGreater(left.max(), 120, "words that cannot be read on this paper")

    def zoomed_and_switched_off(self):
        """As a reader does it: a rectangle is drawn, a name in the legend is clicked."""
        first = "document.querySelector('.plot')"
        before = self.browser.ask(f"{first}._fullLayout.xaxis.range.slice()")
        place = self.browser.ask(f"(() => {{ const plot = {first}; plot.scrollIntoView(); "
                                 "const r = plot.querySelector('.nsewdrag').getBoundingClientRect(); return [r.x, r.y, r.width, "
                                 "r.height]; })()")
        self.browser.drag(place[0] + 0.3 * place[2], place[1] + 20, place[0] + 0.6 * place[2], place[1] + place[3] - 20)
        after = self.browser.ask(f"{first}._fullLayout.xaxis.range.slice()")
        self.assertAlmostEqual((after[1] - after[0]) / (before[1] - before[0]), 0.3, delta=0.02)
        shown = f"[...{first}.querySelectorAll('.trace')].length"
        count = self.browser.ask(shown)
        place = self.browser.ask(f"(() => {{ const r = {first}.querySelector('.legendtoggle').getBoundingClientRect(); "
                                 "return [r.x + r.width / 2, r.y + r.height / 2]; })()")
        self.browser.click(*place)
        self.browser.wait_for(f"{shown} < {count}")

    def on_paper(self):
        """From a dark screen: white paper, each picture as wide as the page, no button bar."""
        pdf = self.browser.printed()
        self.assertEqual(pdf[:5], b"%PDF-")
        self.assertGreater(pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page "), 3)
        self.browser.call("Emulation.setEmulatedMedia", media="print", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        self.browser.ask("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(self.browser.ask("getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)")
        widths = self.browser.ask("[...document.querySelectorAll('.main-svg')].map((svg) => svg.getBoundingClientRect().width)")
        self.assertEqual(set(widths), {680})
        self.assertEqual(self.browser.ask("getComputedStyle(document.querySelector('.modebar-container')).display"), "none")


if __name__ == "__main__":
    unittest.main()
