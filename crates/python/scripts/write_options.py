"""Writes python/polyreel/_options.py, the types of all options, from the program's own list of them.

    python scripts/write_options.py
"""

from __future__ import annotations

import textwrap
from pathlib import Path

from polyreel import _polyreel

TARGET = Path(__file__).parents[1] / "python" / "polyreel" / "_options.py"
HEAD = '''"""The options of the command line as types. Written by scripts/write_options.py; do not edit."""

from __future__ import annotations

from os import PathLike
from typing import Literal, TypedDict

Colour = str | bool | tuple[int, int, int] | tuple[int, int, int, int]
Text = str | int | float | PathLike[str] | tuple[float, ...] | tuple[str, ...]
Path = str | PathLike[str]
'''
KINDS = {"flag": "bool", "int": "int", "float": "float", "colour": "Colour", "path": "Path", "text": "Text"}


def field(name: str, about: str, kind: str, choices: list[str]) -> str:
    value = "Literal[" + ", ".join(f'"{choice}"' for choice in choices) + "]" if choices else KINDS[kind]
    lines = textwrap.wrap(" ".join(about.split()), 108)
    return f"    {name}: {value} | None\n" + textwrap.indent('"""' + "\n".join(lines) + '"""', "    ") + "\n"


def text() -> str:
    fields: dict[bool, list[str]] = {True: [], False: []}
    for name, about, kind, choices, is_look in _polyreel.described():
        fields[is_look].append(field(name, about, kind, choices))
    look = '\n\nclass LookOptions(TypedDict, total=False):\n    """What decides how a picture looks."""\n\n'
    file = '\n\nclass FileOptions(LookOptions, total=False):\n    """What ``polyreel.render_file`` takes besides."""\n\n'
    return HEAD + look + "".join(fields[True]) + file + "".join(fields[False])


if __name__ == "__main__":
    TARGET.write_text(text(), encoding="utf-8")
