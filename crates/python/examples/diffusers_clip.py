"""Frames of a video model to a low-poly MP4.

Pipelines of Diffusers return a clip as a list of PIL images (``output.frames[0]``) or as an array (F, H, W, C) of 0..1.
Either is rendered as one stream here, a few frames at a time in memory, and goes to ffmpeg.

    python diffusers_clip.py out.mp4
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import polyreel


def generated(count: int, height: int = 240, width: int = 432) -> Iterator[Any]:
    """Stands for ``pipe(prompt).frames[0]``: PIL images where Pillow is installed, else arrays."""
    y, x = np.mgrid[0:height, 0:width]
    for t in range(count):
        sun = np.hypot(x - 60 - 6 * t, y - 70) < 34
        hills = y > height * 0.62 + 24 * np.sin((x + 2 * t) / 40)
        sky = np.stack([120 + y // 3, 90 + y // 4, 200 - y // 3], axis=-1)
        frame = np.where(sun[..., None], [250, 220, 120], sky)
        frame = np.where(hills[..., None], [40, 70 + t, 80], frame).astype(np.uint8)
        yield _as_image(frame)


def _as_image(frame: NDArray[np.uint8]) -> Any:
    try:
        pillow: Any = importlib.import_module("PIL.Image")
    except ImportError:
        return frame
    return pillow.fromarray(frame)


def write_mp4(frames: Iterable[Any], destination: str, fps: int) -> int:
    """Writes frames of any kind to an MP4 by ffmpeg, and returns their number."""
    encoder: subprocess.Popen[bytes] | None = None
    count = 0
    for frame in frames:
        array = np.ascontiguousarray(np.asarray(frame)[..., :3])
        if array.dtype != np.uint8:
            array = (array * 255 + 0.5).astype(np.uint8)
        if encoder is None:
            size = f"{array.shape[1]}x{array.shape[0]}"
            command = ["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(fps)]
            command += ["-i", "-", "-pix_fmt", "yuv420p", "-crf", "18", destination]
            encoder = subprocess.Popen(command, stdin=subprocess.PIPE)
        assert encoder.stdin is not None
        encoder.stdin.write(array.tobytes())
        count += 1
    if encoder is not None and encoder.stdin is not None:
        encoder.stdin.close()
        if encoder.wait() != 0:
            raise RuntimeError(f"ffmpeg could not write {destination}")
    return count


def main() -> None:
    destination = sys.argv[1] if len(sys.argv) > 1 else "lowpoly.mp4"
    renderer = polyreel.Renderer(points=900, coherence=0.5)
    count = write_mp4(renderer.stream(generated(24)), destination, fps=12)
    print(f"{destination}: {count} frames")


if __name__ == "__main__":
    main()
