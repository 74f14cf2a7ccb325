"""Renderers that live across calls of a node.

A node of ComfyUI has no state of its own, and VideoHelperSuite's Meta Batch hands a clip over in pieces, each in a run
of its own. The mesh has to live on between them, else it begins anew at every piece, and the picture jumps.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import polyreel

#: A node, and the batch manager above it.
Key = tuple[str, str]

MANAGER = "VHS_BatchManager"


def batch(prompt: Mapping[str, Any] | None, node: str | None) -> tuple[str, int] | None:
    """Returns the batch manager that node ``node`` gets its frames by and the number of its run, from 0; ``None``
    without one."""
    if not prompt or node is None:
        return None
    waiting, seen = [str(node)], set()
    while waiting:
        name = waiting.pop()
        if name in seen or name not in prompt:
            continue
        seen.add(name)
        inputs = prompt[name].get("inputs", {})
        if prompt[name].get("class_type") == MANAGER:
            return name, int(inputs.get("requeue", 0))
        # A link is the name of a node and the number of its output.
        waiting += [str(value[0]) for value in inputs.values() if isinstance(value, (list, tuple)) and len(value) == 2]
    return None


class Streams:
    """The renderers of clips that come in pieces; the oldest goes when there are too many."""

    def __init__(self, most: int = 4) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._renderers: OrderedDict[Key, tuple[int, list[polyreel.Renderer]]] = OrderedDict()

    def renderers(
        self, prompt: Mapping[str, Any] | None, node: str | None, looks: list[dict[str, Any]]
    ) -> list[polyreel.Renderer]:
        """Returns a renderer for each of ``looks``: those of the last piece of this clip, or new ones where a clip
        begins, a piece is missing, or a run is repeated."""
        found = batch(prompt, node)
        if found is None:
            return [polyreel.Renderer(**look) for look in looks]
        key, run = (str(node), found[0]), found[1]
        with self._lock:
            last, renderers = self._renderers.pop(key, (-1, []))
            if run != last + 1 or run == 0 or len(renderers) != len(looks):
                renderers = [polyreel.Renderer(**look) for look in looks]
            for renderer, look in zip(renderers, looks):
                if renderer.options != look:
                    renderer.retune(**{**dict.fromkeys(renderer.options), **look})
            self._renderers[key] = (run, renderers)
            while len(self._renderers) > self._most:
                self._renderers.popitem(last=False)
            return renderers

    def forget(self, node: str | None) -> None:
        """Drops what belongs to ``node``: its run failed or was interrupted."""
        with self._lock:
            for key in [key for key in self._renderers if key[0] == str(node)]:
                del self._renderers[key]
