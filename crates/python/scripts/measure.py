"""Measures what docs/python.md states: run it on an idle machine, with a wheel of the release profile.

    python scripts/measure.py            all
    python scripts/measure.py stream     one of overhead, rate, stream, video
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import polyreel

HEIGHT, WIDTH = 720, 1280


def frames(count: int) -> Iterator[NDArray[np.uint8]]:
    """A picture with grain that moves, as uint8 of 720p."""
    rng = np.random.default_rng(1)
    y, x = np.mgrid[0 : HEIGHT + 64, 0 : WIDTH + 64]
    scene = np.stack([np.sin(x / 37) * 60 + 120, np.sin((x + 2 * y) / 53) * 60 + 120, y * 200 / HEIGHT], axis=-1)
    scene += 40 * ((x // 90 + y // 70) % 2)[..., None] + rng.normal(0, 4, scene.shape)
    scene = np.clip(scene, 0, 255).astype(np.uint8)
    for t in range(count):
        at = t % 64
        yield np.ascontiguousarray(scene[at : at + HEIGHT, at : at + WIDTH])


def overhead() -> None:
    """Time of a call over the time of the engine."""
    renderer = polyreel.Renderer()
    for kind in (np.uint8, np.float32):
        spent = []
        for frame in frames(40):
            given = frame if kind is np.uint8 else (frame / 255).astype(kind)
            began = time.perf_counter()
            renderer.render(given)
            whole = (time.perf_counter() - began) * 1e3
            stats = renderer.stats
            assert stats is not None
            spent.append(whole - stats["milliseconds"])
        print(f"overhead of a 720p frame, {np.dtype(kind)}: median {np.median(spent):.2f} ms, most {max(spent):.2f} ms")


def rate() -> None:
    """Frames a second of `stream`, and of the program on the same frames as y4m to `null:`."""
    count = 240
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.y4m"
        with clip.open("wb") as file:
            file.write(f"YUV4MPEG2 W{WIDTH} H{HEIGHT} F25:1 Ip A1:1 C444\n".encode())
            for frame in frames(count):
                file.write(b"FRAME\n" + np.ascontiguousarray(frame.transpose(2, 0, 1)).tobytes())
        for _ in range(2):
            began = time.perf_counter()
            subprocess.run([sys.executable, "-m", "polyreel", "render", clip, "-o", "null:", "-q"], check=True)
            program = count / (time.perf_counter() - began)
            given = list(frames(count))
            began = time.perf_counter()
            done = sum(1 for _ in polyreel.Renderer().stream(given))
            streamed = done / (time.perf_counter() - began)
            print(f"720p to null: {program:.1f} frames a second by the program, {streamed:.1f} by stream "
                  f"({100 * streamed / program:.0f} %)")


def stream() -> None:
    """Peak memory of 2,000 frames of 720p through `stream`."""
    count = sum(1 for _ in polyreel.Renderer(quality="draft").stream(frames(2000)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{count} frames of 720p through stream: peak {peak:.0f} MiB")


def resident() -> float:
    """MiB that this process and its children have in memory."""
    me, pages = os.getpid(), 0
    for entry in Path("/proc").iterdir():
        try:
            parent = (entry / "stat").read_text().rsplit(")", 1)[1].split()[1] if entry.name.isdigit() else ""
            if entry.name == str(me) or parent == str(me):
                pages += int((entry / "statm").read_text().split()[1])
        except OSError:
            continue
    return pages * resource.getpagesize() / 2**20


def video() -> None:
    """Peak memory, of ffmpeg as well, of a film of three minutes."""
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        command: list[Any] = ["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "testsrc2=size=1280x720:rate=24:duration=180"]
        command += ["-f", "lavfi", "-i", "sine=duration=180", "-preset", "ultrafast", "-shortest", film]
        subprocess.run(command, check=True)
        peaks, over = [0.0], threading.Event()

        def watch() -> None:
            while not over.wait(0.2):
                peaks.append(resident())

        watcher = threading.Thread(target=watch)
        watcher.start()
        report = polyreel.render_file(film, Path(folder) / "art.mp4", quality="draft", encoder_preset="ultrafast")
        over.set()
        watcher.join()
        own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{report['frames']} frames of 720p from MP4 to MP4: peak {own:.0f} MiB of Python's, {max(peaks):.0f} with ffmpeg's")


def main() -> None:
    named = {"overhead": overhead, "rate": rate, "stream": stream, "video": video}
    if len(sys.argv) > 1:
        named[sys.argv[1]]()
        return
    for name in named:
        # Peaks are of a process.
        subprocess.run([sys.executable, __file__, name], check=True)


if __name__ == "__main__":
    main()
