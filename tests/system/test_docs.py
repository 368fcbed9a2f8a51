#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""README and docs: every link leads somewhere, every file that is named exists, every page can be found."""
import os
import pathlib
import re
import subprocess
import sys
import unittest

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
FOLDERS = ("firmware", "hal", "host_sim", "tests", "tools", "docs", "cmake")


def anchors(page):
    """What a heading is called in a link."""
    for heading in re.findall(r"^#+ (.+)$", page.read_text(), re.M):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def named_files(text):
    """Paths in backticks; NAME, *, {a,b} and options are a reader's to fill in."""
    for path in re.findall(r"`((?:%s)/[\w./-]+)`" % "|".join(FOLDERS), text):
        yield path


class Docs(unittest.TestCase):
    def test_links(self):
        for page in PAGES:
            for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
                if "://" in target:
                    continue
                path, _, anchor = target.partition("#")
                place = (page.parent / path).resolve() if path else page
                with self.subTest(page=page.name, link=target):
                    self.assertTrue(place.exists())
                    if anchor:
                        self.assertIn(anchor, list(anchors(place)))

    def test_files_that_are_named(self):
        for page in PAGES:
            for path in named_files(page.read_text()):
                with self.subTest(page=page.name, path=path):
                    # A block's header and source, or the parts of a name that a page leaves open ("sd_afr_*").
                    self.assertTrue((ROOT / path).exists() or list(ROOT.glob(path.rstrip("/") + "*")))

    def test_every_page_is_reached_from_readme(self):
        reached, waiting = set(), [ROOT / "README.md"]
        while waiting:
            page = waiting.pop()
            if page in reached or page.suffix != ".md":
                continue
            reached.add(page)
            links = re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text())
            waiting += [(page.parent / link).resolve() for link in links if "://" not in link and (page.parent / link).is_file()]
        self.assertEqual(set(PAGES) - reached, set())


class Lines(unittest.TestCase):
    """What is written by hand has lines of 140 columns at most. Left out: what a program writes, options that a tool reads from one line,
    and hal/signals.toml, where a unit or a comment is one string."""

    WRITTEN = (".c", ".h", ".inc", ".cpp", ".hpp", ".py", ".cmake", ".txt", ".toml", "")
    LEFT_OUT = ("hal/generated/", "hal/signals.toml", "tests/proof/eva/", "tests/proof/proved.toml", "LICENSE")

    def test_no_line_is_over_140_columns(self):
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
        if listed.returncode:
            self.skipTest("no git")
        files = [name for name in listed.stdout.splitlines()
                 if pathlib.Path(name).suffix in self.WRITTEN and not name.startswith(self.LEFT_OUT) and (ROOT / name).is_file()]
        self.assertGreater(len(files), 500)
        wide = [f"{name}:{number}" for name in files
                for number, line in enumerate((ROOT / name).read_text().splitlines(), 1) if len(line) > 140]
        self.assertEqual(wide, [])


class Figures(unittest.TestCase):
    """A figure of README stands on the page that its row leads to, which is where a command or a test keeps it true."""

    def numbers(self, text):
        return {number.replace(",", "") for number in re.findall(r"\d[\d,]*(?:\.\d+)?(?:e-?\d+)?", text)}

    def test_figures_of_readme_stand_on_the_pages_they_lead_to(self):
        rows = re.findall(r"^\| (.+?) \| .+? \| (`.+?`.*?\]\(docs/.+?) \|$", (ROOT / "README.md").read_text(), re.M)
        self.assertGreaterEqual(len(rows), 10)
        for claim, shown in rows:
            pages = [(ROOT / link).read_text() for link in re.findall(r"\]\((docs/[^)#]+)", shown)]
            with self.subTest(claim=claim):
                self.assertEqual(self.numbers(claim) - self.numbers(" ".join(pages)), set())


class TwelveQuestions(unittest.TestCase):
    """docs/start/twelve-questions.md: a reader finds each answer from README in at most three steps."""

    PAGE = DOCS / "start/twelve-questions.md"

    @staticmethod
    def links(page):
        return [(page.parent / target).resolve() for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)",
                                                                          page.read_text()) if "://" not in target]

    def rows(self):
        for line in self.PAGE.read_text().splitlines():
            cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            if len(cells) == 3 and cells[0].endswith("?"):
                yield cells

    def test_each_answer_is_found(self):
        rows = list(self.rows())
        self.assertEqual(len(rows), 12)
        for question, steps, answer in rows:
            with self.subTest(question=question):
                pages = [(self.PAGE.parent / target).resolve() for target in re.findall(r"\]\(([^)]+)\)", steps)]
                self.assertTrue(1 <= len(pages) <= 3)
                here = ROOT / "README.md"
                for page in pages:
                    self.assertIn(page, self.links(here), f"a step from {here.name}")
                    here = page
                self.assertIn(" ".join(answer.split()), " ".join(here.read_text().split()), here.name)


class Tuning(unittest.TestCase):
    @unittest.skipUnless(os.environ.get("SD_FULL") == "1", "36 runs, 15 s of a core; SD_FULL=1 asks for them")
    def test_each_change_does_what_the_page_says(self):
        done = subprocess.run([sys.executable, ROOT / "tests/system/tuning_effects.py"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)


class Overview(Folder):
    def test_the_picture_of_readme_is_drawn_from_a_run(self):
        scenario = ROOT / "host_sim/data/scenarios/balance_1000rpm_5bar.toml"
        subprocess.run([os.environ["SIXDEG"], "run", scenario, "--set", "misfires.one_in=20", "--set", "run.cycles=80", "--out",
                        self.folder / "run"], capture_output=True, check=True)
        subprocess.run([sys.executable, ROOT / "tools/report/overview.py", self.folder / "run", self.folder / "overview.svg"], check=True)
        new, kept = ((folder / "overview.svg").read_text() for folder in (self.folder, DOCS))
        words = re.findall(r"<text[^>]*>([^<]+)</text>", kept)
        self.assertIn("Out: every firing, its cylinder, and a misfire named (red)", words)
        self.assertEqual(re.findall(r"<text[^>]*>([^<]{12,})</text>", new), [w for w in words if len(w) >= 12])
        for picture in (new, kept):
            self.assertEqual(picture.count("#c23b22"), 1, "one misfire, named")


if __name__ == "__main__":
    unittest.main()
