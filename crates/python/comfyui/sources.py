"""The file that a VIDEO of ComfyUI is read from.

A VIDEO is a file, a part of a file, a file in memory, or frames; some have edits that are carried out where they are saved.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from comfy_api.latest import InputImpl


@contextmanager
def file_of(video: Any, name: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yields the name of a file with ``video`` in it, and the options ``start`` and ``end`` where only a part of it is
    meant. What is in no file yet is written to one whose name begins with ``name``, and removed afterwards."""
    unsaved = is_unsaved(video)
    source, part = (None, {}) if unsaved else (video.get_stream_source(), part_of(video))
    if isinstance(source, (str, os.PathLike)):
        yield os.fspath(source), part
        return
    written = f"{name}-source.mp4"
    try:
        if unsaved:
            video.save_to(written)
        else:
            copy(source, written)
        yield written, part
    finally:
        if os.path.exists(written):
            os.remove(written)


def is_unsaved(video: Any) -> bool:
    """Whether ``video`` has frames that no file has yet. (``get_stream_source`` of frames fails in ComfyUI 0.3.64.)"""
    edited = getattr(video, "has_pending_frame_edits", None)
    return isinstance(video, InputImpl.VideoFromComponents) or (edited is not None and edited())


def part_of(video: Any) -> dict[str, str]:
    """The options for the part of its file that ``video`` is, in ComfyUI newer than 0.3.64; none for all of it."""
    window = getattr(video, "get_active_trim_window", None)
    start, duration = window() if window is not None else (0.0, 0.0)
    part = {}
    if start > 0:
        part["start"] = f"{start:.6f}"
    if duration > 0:
        part["end"] = f"{start + duration:.6f}"
    return part


def copy(source: Any, path: str) -> None:
    """Writes a file in memory to ``path``."""
    source.seek(0)
    with open(path, "wb") as file:
        shutil.copyfileobj(source, file)
