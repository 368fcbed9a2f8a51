#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Document 003's Figure 6 as a PNG, for the docs:

  build/venv/bin/python tools/report/driveline_picture.py FOLDER PICTURE.png

FOLDER is what `sixdeg study driveline figure-6 --out FOLDER` wrote."""
import argparse

import driveline_pictures
from chart_png import as_png
from driveline_folder import Driveline


def main():
    parser = argparse.ArgumentParser(description="Figure 6 of document 003 as a picture")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("picture", metavar="PICTURE.png")
    options = parser.parse_args()
    with open(options.picture, "wb") as file:
        file.write(as_png(driveline_pictures.figure_6(Driveline(options.folder))))


if __name__ == "__main__":
    main()
