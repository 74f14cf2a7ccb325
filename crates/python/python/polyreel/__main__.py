"""The program: ``python -m polyreel render clip.mp4 -o lowpoly.mp4``."""

from __future__ import annotations

import sys

from . import _polyreel


def main() -> int:
    """Runs the command line of this process, and returns its exit code."""
    sys.stdout.flush()
    return _polyreel.main(["polyreel", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
