# SPDX-License-Identifier: MIT
"""Parts of a page as HTML, and the page itself: one file, which carries the plotting library and needs no network."""
import base64
import gzip
import html
import importlib.util
import json
import os
import pathlib

HERE = pathlib.Path(__file__).resolve().parent


def table(rows, header=()):
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{head}</tr>' if header else ''}{body}</table>"


def text(words, kind="note"):
    return f'<p class="{kind}">{html.escape(words)}</p>'


def listed(items, kind, tag="ul"):
    return f'<{tag} class="{kind}">' + "".join(f"<li>{html.escape(item)}</li>" for item in items) + f"</{tag}>"


def picture(chart, name, missing=""):
    """A chart with its name for those who do not see it; the words `missing` where there is none."""
    if chart is None:
        return text(missing, "none")
    data = json.dumps(chart.as_data(), separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    return (f'<figure class="chart" role="img" aria-label="{html.escape(name)}"><div class="plot">'
            f'<span class="waiting">{html.escape(name)}: drawn when the page is ready; it takes JavaScript.</span></div>'
            f'<script type="application/json">{data}</script></figure>')


def library():
    """plotly.js of the Python package, packed; the package itself, which takes a second to load, is not imported."""
    package = pathlib.Path(importlib.util.find_spec("plotly").submodule_search_locations[0])
    packed = gzip.compress((package / "package_data/plotly.min.js").read_bytes(), compresslevel=6, mtime=0)
    return base64.b64encode(packed).decode()


def whole(title, body):
    """The page. body: parts, as HTML."""
    parts = "\n".join(body)
    style, script = ((HERE / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    scripts = ""
    if 'class="chart"' in parts:
        scripts = f'<script id="library" type="text/plain">{library()}</script>\n<script>{script}</script>'
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
            f"<title>{html.escape(title)}</title>\n<style>{style}</style></head>\n<body>{parts}\n{scripts}</body></html>\n")


def write(path, content):
    """Beside its place, then renamed: a page is whole or not there."""
    with open(path + ".partial", "w", encoding="utf-8", newline="\n") as out:
        out.write(content)
    os.replace(path + ".partial", path)
