from collections.abc import Callable, Iterable, Iterator, Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._results import FileReport, FrameStats

__version__: str

class Error(Exception):
    """What polyreel raises; its subclasses say what is wrong."""

class UsageError(Error):
    """The request itself cannot be meant: an option out of its range."""

class InputError(Error):
    """An input cannot be read or understood."""

class OutputError(Error):
    """An output cannot be written."""

class Mesh:
    """Vertices, triangles and their colours. The arrays cannot be written to."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels."""
    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 2): x and y in pixels from the top left corner of the picture."""
    @property
    def ids(self) -> NDArray[np.uint64]:
        """(n,): a number for each vertex that lasts from frame to frame."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(m, 3): rows of ``vertices``."""
    @property
    def colors(self) -> NDArray[np.uint8]:
        """(m, 4): red, green, blue, alpha."""
    def svg(self, title: str = "", *, seams: str = "underlap") -> str:
        """The mesh as an SVG document, which begins with ``<svg``; ``seams`` is underlap, stroke or none.

        Raises ``polyreel.UsageError`` for other seams."""
    def save(self, destination: str | PathLike[str], *, scale: float = 1.0, overwrite: bool = False) -> None:
        """Writes the mesh in the format that the name ends in: .svg, .usda, .polyreel, or a picture (.png ...) that is
        painted ``scale`` times as large, 0.05 to 64.

        Raises ``polyreel.OutputError`` where it cannot be written, or is there and not to be overwritten."""

class FrameStream:
    def __iter__(self) -> Iterator[NDArray[Any]]: ...
    def __next__(self) -> NDArray[Any]: ...
    def close(self) -> None: ...

class Renderer:
    def __new__(cls, **options: Any) -> Renderer: ...
    def render(self, frame: NDArray[Any]) -> NDArray[Any]: ...
    def stream(self, frames: Iterable[NDArray[Any]]) -> FrameStream: ...
    def reset(self) -> None: ...
    def retune(self, **options: Any) -> None: ...
    @property
    def stats(self) -> FrameStats | None: ...

def main(arguments: list[str]) -> int: ...
def render(picture: NDArray[Any], **options: Any) -> NDArray[Any]: ...
def triangulate(picture: NDArray[Any], **options: Any) -> Mesh: ...
def probe(source: str | PathLike[str]) -> str: ...
def render_file(
    sources: Sequence[str | PathLike[str]],
    destination: str | PathLike[str],
    progress: Callable[[int, int | None], object] | None,
    preview: Callable[[NDArray[np.uint8]], object] | None,
    options: dict[str, Any],
) -> FileReport: ...
def end_all() -> None: ...
def presets() -> list[tuple[str, str]]: ...
def described() -> list[tuple[str, str, str, list[str], bool]]: ...
