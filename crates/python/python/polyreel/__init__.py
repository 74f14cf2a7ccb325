"""Low-poly art from pictures, clips and live frames, coherent from frame to frame.

A picture is a numpy array of shape (height, width, 3) or (height, width, 4), uint8 of 0..255 or float of 0..1; a
PIL image; a torch tensor on the CPU; or anything with ``__array__`` or ``__dlpack__``. What comes back is of the same
kind, shape and dtype. Options have the names of the command line, with underscores: ``points=1500``,
``preset="bold"``, ``outline_width=2``. ``polyreel.options()`` tells what they do.

Errors are ``polyreel.Error`` with the subclasses ``UsageError``, ``InputError`` and ``OutputError``; a name that is no
option is a ``TypeError`` that suggests one. Ctrl-C ends every long call. Work is done on threads without the
interpreter's lock.
"""

from __future__ import annotations

import atexit
import json
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from . import _kinds, _polyreel
from ._polyreel import Error, InputError, Mesh, OutputError, UsageError, __version__

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import FileOptions, LookOptions
    from ._results import FileReport, FrameStats, StreamInfo

__all__ = [
    "Error",
    "InputError",
    "Mesh",
    "OutputError",
    "Renderer",
    "UsageError",
    "__version__",
    "options",
    "presets",
    "probe",
    "render",
    "render_batch",
    "render_file",
    "triangulate",
]

Picture = TypeVar("Picture")

# Programs that a run has started end with the interpreter, and so do its unfinished files.
atexit.register(_polyreel.end_all)


def presets() -> dict[str, str]:
    """Returns what each preset looks like, by its name."""
    return dict(_polyreel.presets())


def options(look: bool = False) -> dict[str, str]:
    """Returns what each option does, by its name: of ``render_file`` all, with ``look`` those of pictures as well."""
    return {name: about for name, about, _, _, is_look in _polyreel.described() if is_look or not look}


def render(picture: Picture, **options: Unpack[LookOptions]) -> Picture:
    """Renders one picture as low-poly art and returns it in the same kind, shape and dtype.

    The pixels are those of ``polyreel render`` on a still with the same options.

    Raises ``TypeError`` for a picture or an option that polyreel does not know, ``ValueError`` for a wrong shape,
    NaN, or floats above 2, and ``polyreel.UsageError`` for an option out of its range.
    """
    array, back = _kinds.unpack(picture)
    out: Picture = back(_polyreel.render(array, **options))
    return out


def triangulate(picture: Any, **options: Unpack[LookOptions]) -> Mesh:
    """Returns the mesh of one picture: ``vertices`` (n, 2) float64 in pixels, ``triangles`` (m, 3) uint32,
    ``colors`` (m, 4) uint8, ``ids`` (n,) uint64 and ``size`` (width, height), with ``svg()`` and ``save()``.

    Raises as ``polyreel.render``.
    """
    array, _ = _kinds.unpack(picture)
    return _polyreel.triangulate(array, **options)


class Renderer:
    """Renders a stream of frames. The mesh lives on from frame to frame, so that the picture does not flicker.

    Use one renderer for each stream. Calls from several threads take turns. Pickled, it is one with the same options
    that has seen no frames.

    Raises ``TypeError`` for an unknown option and ``polyreel.UsageError`` for one out of its range.
    """

    def __init__(self, **options: Unpack[LookOptions]) -> None:
        self._native = _polyreel.Renderer(**options)
        self._options: dict[str, Any] = dict(options)

    def render(self, frame: Picture) -> Picture:
        """Renders the next frame and returns it in the same kind. A frame of another size begins a new stream.

        Raises as ``polyreel.render``. After Ctrl-C the next frame begins a new stream.
        """
        array, back = _kinds.unpack(frame)
        out: Picture = back(self._native.render(array))
        return out

    def stream(self, frames: Iterable[Picture]) -> Iterator[Picture]:
        """Renders the frames of any iterable, in order, on several threads, some frames ahead.

        Memory does not grow with their number: at most 12 frames are under way. The stream is one of its own: it has
        the options of this renderer (``retune`` included) and sets its ``stats``, but does not share its mesh.

        Raises ``polyreel.UsageError`` where a frame has another size than the first; an exception of the iterable
        is raised here.
        """
        # Their number is that of the frames under way.
        backs: deque[Callable[[Any], Any]] = deque()

        def arrays() -> Iterator[Any]:
            for frame in frames:
                array, back = _kinds.unpack(frame)
                backs.append(back)
                yield array

        native = self._native.stream(arrays())
        try:
            for picture in native:
                yield backs.popleft()(picture)
        finally:
            native.close()

    def reset(self) -> None:
        """Forgets all frames: the next one begins a new stream."""
        self._native.reset()

    def retune(self, **options: Unpack[LookOptions]) -> None:
        """Changes some options from the next frame on; the others stay, and ``None`` takes one away.

        The mesh lives on where only what is done with it changes (coherence, refinement, colours, lines); else the
        next frame starts afresh. Raises as the constructor; nothing is changed then.
        """
        merged = {**self._options, **options}
        self._native.retune(**merged)
        self._options = merged

    @property
    def options(self) -> dict[str, Any]:
        """The options that were given, by their names."""
        return {name: value for name, value in self._options.items() if value is not None}

    @property
    def stats(self) -> FrameStats | None:
        """How the last frame came to be: ``cut``, ``kept``, ``moved``, ``born``, ``died`` (seeds), ``seeds``,
        ``triangles``, ``refine_steps`` and ``milliseconds``; ``None`` before the first one."""
        return self._native.stats

    def __reduce__(self) -> tuple[Callable[[dict[str, Any]], Renderer], tuple[dict[str, Any]]]:
        return (_renderer, (self.options,))

    def __repr__(self) -> str:
        return f"polyreel.Renderer({', '.join(f'{name}={value!r}' for name, value in self.options.items())})"


def _renderer(options: dict[str, Any]) -> Renderer:
    return Renderer(**options)


_ORDERS: dict[str, tuple[int, ...] | None] = {
    "BHWC": None,
    "FHWC": None,
    "BCHW": (0, 2, 3, 1),
    "FCHW": (0, 2, 3, 1),
}


def render_batch(
    batch: Picture,
    *,
    layout: str = "BHWC",
    progress: Callable[[int, int], object] | None = None,
    renderer: Renderer | None = None,
    **options: Unpack[LookOptions],
) -> Picture:
    """Renders a clip that is one array or tensor of four dimensions, as one stream; returns one of the same kind,
    shape and dtype.

    ``layout`` is ``"BHWC"`` (also ``"FHWC"``; ComfyUI, numpy) or ``"BCHW"`` (also ``"FCHW"``; Diffusers, torch).
    ``progress`` is called with the number of frames done and of all frames; an exception that it raises cancels the
    work and comes out here. With ``renderer`` the clip goes on from the frames that it has rendered: pieces give the
    same bytes as the whole. It cannot be given together with options.

    Raises ``ValueError`` for another number of dimensions or an unknown layout, else as ``polyreel.render``.
    """
    array, back = _kinds.unpack(batch)
    if array.ndim != 4:
        raise ValueError(f"a batch has four dimensions, not the shape {tuple(array.shape)}")
    if layout not in _ORDERS:
        raise ValueError(f"layout is {layout!r}; it can be 'BHWC', 'FHWC', 'BCHW' or 'FCHW'")
    if renderer is not None and options:
        raise TypeError("options are the renderer's: give them to it, or to its retune")
    order = _ORDERS[layout]
    frames = array if order is None else array.transpose(order)
    out = np.empty(array.shape, array.dtype)
    into = out if order is None else out.transpose(order)
    if renderer is None:
        pictures = Renderer(**options).stream(frames)
    else:
        pictures = map(renderer.render, frames)
    total = len(frames)
    for done, picture in enumerate(pictures, 1):
        into[done - 1] = picture
        if progress is not None:
            progress(done, total)
    result: Picture = back(out)
    return result


def render_file(
    source: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    destination: str | os.PathLike[str],
    *,
    progress: Callable[[int, int | None], object] | None = None,
    preview: Callable[[np.ndarray[Any, np.dtype[np.uint8]]], object] | None = None,
    **options: Unpack[FileOptions],
) -> FileReport:
    """Renders a file (or several pictures, a folder, a pattern) to a file, as ``polyreel render`` does: with sound,
    variable rate and transparency, in little memory whatever the length. It takes all options of that command.

    ``progress`` is called with the number of frames done and of all frames (``None`` where that is not known), and
    ``preview`` twice a second with a picture, (height, width, 3) uint8. An exception that they raise, and Ctrl-C,
    cancel the work: then there is no output. Returns ``frames``, ``dropped``, ``seconds``, ``size`` and ``warnings``.

    Raises ``TypeError`` for an unknown option, ``polyreel.UsageError``, ``polyreel.InputError`` and
    ``polyreel.OutputError``.
    """
    sources = [source] if isinstance(source, (str, os.PathLike)) else list(source)
    return _polyreel.render_file(sources, destination, progress, preview, dict(options))


def probe(source: str | os.PathLike[str]) -> StreamInfo:
    """Tells what a file is: ``format``, ``size``, ``frames``, ``rate``, ``duration``, ``alpha``, ``still``, ``audio``
    and so on, as ``polyreel info --json`` does; only its headers are read. Raises ``polyreel.InputError``."""
    info: StreamInfo = json.loads(_polyreel.probe(source))
    return info
