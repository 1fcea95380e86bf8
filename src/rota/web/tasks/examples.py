"""The examples that come with Rota: in the wheel beside this package, in a checkout in its folder examples."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from rota.web.refusal import Json

_WEB = Path(__file__).parent.parent
_NAME = re.compile(r"^name:[ \t]*([^#\n]+?)[ \t]*(#.*)?$", re.MULTILINE)


def examples_folder() -> Path:
    """Where the examples lie."""
    packed = _WEB / "examples"
    return packed if packed.is_dir() else _WEB.parent.parent.parent / "examples"


@cache
def _titles() -> dict[str, str]:
    """What each example is called, by the name of its file."""
    found = {}
    for path in sorted(examples_folder().glob("*.yaml")):
        text = path.read_text(encoding="utf-8")
        if re.search(r"^rota:", text, re.MULTILINE) and (name := _NAME.search(text)):
            comment = re.match(r"#\s*(.+?)(?:\.\s|\.?$)", text.splitlines()[0])
            found[path.stem] = comment[1] if comment else name[1].strip("\"'")
    return found


def example_names() -> list[Json]:
    """Name and title of each example."""
    return [{"name": name, "title": title} for name, title in _titles().items()]
