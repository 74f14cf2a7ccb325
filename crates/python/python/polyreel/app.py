"""A page to try polyreel in: ``pip install 'polyreel[app]'``, then ``python -m polyreel.app``."""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any

import polyreel

#: Where pictures are kept until the program ends.
FOLDER = tempfile.TemporaryDirectory(prefix="polyreel-")


def draw(picture: Any, preset: str, points: float, saturation: float, outline: bool, best: bool) -> tuple[Any, list[str]]:
    """Renders a picture, and writes it as PNG and SVG to download. What is left alone is as the preset has it."""
    if picture is None:
        return None, []
    options: dict[str, Any] = {"preset": preset}
    if points > 0:
        options["points"] = int(points)
    if saturation != 1:
        options["saturation"] = saturation
    if outline:
        options["outline"] = True
    if not best:
        options["quality"] = "normal"
    mesh = polyreel.triangulate(picture, **options)
    folder = Path(tempfile.mkdtemp(dir=FOLDER.name))
    files = [folder / "low-poly.png", folder / "low-poly.svg"]
    for file in files:
        mesh.save(file)
    return str(files[0]), [str(file) for file in files]


def page() -> Any:
    """The page, not yet launched."""
    gr: Any = importlib.import_module("gradio")
    inputs = [
        gr.Image(label="Picture", image_mode="RGBA"),
        gr.Dropdown(list(polyreel.presets()), value="low-poly", label="Preset"),
        gr.Slider(0, 10_000, value=0, step=50, label="Points (0: as many as the preset has)"),
        gr.Slider(0, 2, value=1, label="Saturation (1: as the preset has it)"),
        gr.Checkbox(label="Outline"),
        gr.Checkbox(value=True, label="Best quality"),
    ]
    outputs = [gr.Image(label="Low-poly", format="png"), gr.Files(label="Download")]
    # Gradio's own copies are deleted after a day.
    return gr.Interface(draw, inputs, outputs, title="polyreel", delete_cache=(3600, 86400))


if __name__ == "__main__":
    page().launch(show_error=True)
