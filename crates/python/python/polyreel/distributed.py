"""Films in parts on a Ray cluster: ``pip install polyreel ray`` on every node.

    from polyreel.distributed import render_film
    render_film("film.mp4", "lowpoly.mp4", options=["--preset", "bold"], address="auto")

The film is that of one render, frame for frame. A chunk whose node died is rendered again elsewhere.
"""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

__all__ = ["render_film"]


def render_film(
    film: str | Path,
    output: str | Path,
    *,
    options: Sequence[str] = (),
    plan: str | Path | None = None,
    address: str | None = None,
    cpus: int = 1,
    store: str | None = None,
    program: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Renders ``film`` to ``output`` on the cluster at ``address`` (without one, on this machine).

    ``options`` are those of ``polyreel plan``. The plan is kept at ``plan`` (``OUTPUT.plan.json``); one that is there
    already is used. All nodes must see film and plan under the same names. Parts go to the folder ``parts`` beside
    the plan, which all nodes share; or to ``store``, an address that fsspec knows (``s3://bucket/film``), and from
    there to this machine, which joins them. A chunk has ``cpus`` processors. ``program`` is the command in place of
    this package's own. ``progress`` is called after every chunk, with the number of
    chunks that are there and the number of all.

    What was finished before is not rendered again.
    """
    ray: Any = importlib.import_module("ray")
    command = list(program) if program else [sys.executable, "-m", "polyreel"]
    path = Path(plan) if plan else Path(f"{output}.plan.json")
    path = path.absolute()
    if not path.exists():
        subprocess.run([*command, "plan", "--quiet", str(film), "-o", str(path), *options], check=True)
    chunks = json.loads(path.read_text())["chunks"]
    parts = path.parent / "parts"
    ray.init(address=address, ignore_reinit_error=True)
    # Ray by itself tries again only what was lost with its node.
    failures = [subprocess.CalledProcessError]
    task = ray.remote(num_cpus=cpus, max_retries=5, retry_exceptions=failures)(_render)
    longest_first = sorted(chunks, key=lambda chunk: -int(chunk["frames"]))
    waiting = [
        task.remote(command, str(path), int(chunk["chunk"]), cpus, str(parts), store) for chunk in longest_first
    ]
    while waiting:
        done, waiting = ray.wait(waiting)
        ray.get(done)
        if progress:
            progress(len(chunks) - len(waiting), len(chunks))
    with tempfile.TemporaryDirectory() as scratch:
        if store:
            for chunk in chunks:
                _copy(store, scratch, int(chunk["chunk"]), up=False)
        join = [*command, "join", "--quiet", str(path), "--parts", scratch if store else str(parts)]
        subprocess.run([*join, "-o", str(output), "-y"], check=True)


def _render(command: list[str], plan: str, chunk: int, threads: int, parts: str, store: str | None) -> None:
    """Renders a chunk, on a node."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = scratch if store else parts
        if store:
            _copy(store, folder, chunk, up=False)
        render = [*command, "render", "--quiet", "--plan", plan, "--chunk", str(chunk), "-o", folder]
        subprocess.run([*render, "--threads", str(threads)], check=True)
        if store:
            _copy(store, folder, chunk, up=True)


def _copy(store: str, folder: str, chunk: int, *, up: bool) -> None:
    """Copies a part between ``store`` and ``folder``, its report last: without that it does not count."""
    fsspec: Any = importlib.import_module("fsspec")
    for name in (f"{chunk:04}.polyreel", f"{chunk:04}.json"):
        system, there = fsspec.core.url_to_fs(f"{store}/{name}")
        here = str(Path(folder) / name)
        if up:
            system.makedirs(there.rpartition("/")[0], exist_ok=True)
            system.put_file(here, there)
        elif system.exists(there):
            system.get_file(there, here)
