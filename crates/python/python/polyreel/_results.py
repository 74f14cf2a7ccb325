"""What functions return, for type checkers."""

from __future__ import annotations

from typing import Any, TypedDict


class FrameStats(TypedDict):
    """How a frame came to be."""

    cut: bool
    """Whether a new shot begins with it."""
    kept: int
    """Seeds of the frame before that stayed where they were."""
    moved: int
    """Seeds of the frame before that moved."""
    born: int
    """Seeds that were not there before."""
    died: int
    """Seeds of the frame before that are gone."""
    seeds: int
    triangles: int
    refine_steps: int
    milliseconds: float
    """Time of the engine."""


class FileReport(TypedDict):
    """What ``polyreel.render_file`` did."""

    frames: int
    """Frames written."""
    dropped: int
    """Frames of a live source that were dropped."""
    seconds: float
    size: tuple[int, int]
    """Width and height of the output."""
    warnings: list[str]


class Size(TypedDict):
    width: int
    height: int


class StreamInfo(TypedDict):
    """What is known of a file before its frames are read."""

    paths: list[str]
    format: str
    size: Size
    frames: int | None
    rate: Any
    """Frames per second: numerator and denominator."""
    duration: Any
    """Seconds: numerator and denominator."""
    alpha: bool
    still: bool
    loops: Any
    audio: str | None
    live: bool
    colour: dict[str, str | None] | None
