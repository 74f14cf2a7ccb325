"""A page to try polyreel in: ``pip install 'polyreel[app]'``, then ``python -m polyreel.app``."""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any

import polyreel


def draw(picture: Any, preset: str, points: float, saturation: float, outline: bool, best: bool) -> tuple[Any, list[str]]:
    """Renders a picture, and writes it as PNG and SVG to download."""
    if picture is None:
        return None, []
    options: dict[str, Any] = {"points": int(points), "saturation": saturation, "outline": outline}
    options["quality"] = "best" if best else "normal"
    options["preset"] = None if preset == "default" else preset
    folder = Path(tempfile.mkdtemp(prefix="polyreel-"))
    mesh = polyreel.triangulate(picture, **options)
    files = [folder / "low-poly.png", folder / "low-poly.svg"]
    for file in files:
        mesh.save(file)
    return polyreel.render(picture, **options), [str(file) for file in files]


def page() -> Any:
    """The page, not yet launched."""
    gr: Any = importlib.import_module("gradio")
    inputs = [
        gr.Image(label="Picture"),
        gr.Dropdown(["default", *polyreel.presets()], value="default", label="Preset"),
        gr.Slider(50, 10_000, value=1500, step=50, label="Points"),
        gr.Slider(0, 2, value=1, label="Saturation"),
        gr.Checkbox(label="Outline"),
        gr.Checkbox(value=True, label="Best quality"),
    ]
    return gr.Interface(draw, inputs, [gr.Image(label="Low-poly"), gr.Files(label="Download")], title="polyreel")


if __name__ == "__main__":
    page().launch()
