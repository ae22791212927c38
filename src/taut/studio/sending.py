"""A plan as one HTML file that plays by itself: the page's own modules, styles and the plan, without a server."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Callable, Mapping
from importlib import resources
from importlib.metadata import version
from typing import Any

ENTRY = "standalone.js"
STYLES = ("time.css", "standalone.css")

# an import or export at the beginning of a line; those in comments begin with a star or two slashes
_IMPORT = re.compile(r'^(?:import|export)\b[^;"\']*?["\']studio/([\w.-]+\.js)["\']', re.MULTILINE)

_POLICY = "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data: blob:"

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="taut {version}">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{title}</title>
<style>
{styles}
</style>
<script type="importmap">{imports}</script>
</head>
<body>
<noscript>This page shows robots in motion and needs JavaScript to do so.</noscript>
<script type="application/json" id="data">{data}</script>
<script type="module">import "studio/{entry}";</script>
</body>
</html>
"""


def page_of(title: str, data: Mapping[str, Any], read: Callable[[str], str] | None = None) -> str:
    """Return a page that shows some data and asks nobody for anything.

    Parameters
    ----------
    title : of the page.
    data : what its script shows; finite numbers only.
    read : gives the text of a file of the page by its name; those of the package if None.
    """
    text_of = _packed if read is None else read
    imports = {f"studio/{name}": _address(text) for name, text in modules_of(ENTRY, text_of).items()}
    return _PAGE.format(
        version=html.escape(version("taut")),
        policy=_POLICY,
        title=html.escape(title),
        styles="\n".join(text_of(name) for name in STYLES),
        imports=_within_script(json.dumps({"imports": imports})),
        data=_within_script(json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))),
        entry=ENTRY,
    )


def modules_of(entry: str, read: Callable[[str], str]) -> dict[str, str]:
    """Return a module and all that it imports, also by way of others: texts by their names."""
    found: dict[str, str] = {}
    waiting = [entry]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = read(name)
            waiting += _IMPORT.findall(found[name])
    return found


def _packed(name: str) -> str:
    return (resources.files("taut.studio") / "page" / name).read_text(encoding="utf-8")


def _address(text: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(text.encode()).decode()


def _within_script(text: str) -> str:
    """Return JSON that no HTML parser takes for the end of its script or for a comment."""
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
