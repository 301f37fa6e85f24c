"""The page as one HTML text: markup, style, scripts and data, under a policy that lets nothing else in."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from string import Template

_STATIC = Path(__file__).resolve().parent / "static"
_MODULES = (
    "colours.js",
    "dom.js",
    "scales.js",
    "run.js",
    "unpacking.js",
    "fronts.js",
    "view.js",
    "heatmap.js",
    "pointer.js",
    "colourbar.js",
    "charts.js",
    "profile.js",
    "curves.js",
    "events.js",
    "tables.js",
    "controls.js",
    "desk.js",
    "live.js",
    "app.js",
)
"""Each after what it imports from."""
_IMPORT = re.compile(r"^import \{[^}]*\} from \"\./[a-z]+\.js\";\n", re.M)
_EXPORT = re.compile(r"^export (?=async |class |const |function )", re.M)


def page(contents: Mapping[str, object], connect: str = "'none'") -> str:
    """The page with these contents, which may be anybody's text; ``connect`` says where its scripts may connect to.

    It loads nothing. Its policy allows the very scripts and styles that it is made of, by their hashes, so that text
    which became markup could do nothing.
    """
    title = str(contents["title"])
    scripts, style = (_text("uplot.min.js"), _program()), _style()
    sources = " ".join(map(_hash, scripts))
    policy = (
        f"default-src 'none'; script-src {sources}; style-src {_hash(style)}; img-src data:; connect-src {connect}; "
        "base-uri 'none'; form-action 'none'"
    )
    uplot, program = scripts
    return Template(_text("page.html")).substitute(
        policy=html.escape(policy),
        title=html.escape(title),
        style=style,
        contents=json_text(contents),
        scripts=f'<script>{uplot}</script>\n<script type="module">{program}</script>',
    )


def json_text(contents: Mapping[str, object]) -> str:
    """JSON that can stand inside a script element whatever text it holds; its numbers are finite."""
    text = json.dumps(contents, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@cache
def _program() -> str:
    """The modules as a single one, in which they need not be loaded from anywhere."""
    return "".join(_EXPORT.sub("", _IMPORT.sub("", _text(name))) for name in _MODULES)


@cache
def _style() -> str:
    return _text("uplot.min.css") + _text("page.css")


@cache
def _text(name: str) -> str:
    return (_STATIC / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
