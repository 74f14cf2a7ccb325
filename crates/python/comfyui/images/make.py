"""Makes the pictures of the README and the icon from the repository's samples: python make.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polyreel
from PIL import Image, ImageDraw, ImageSequence

HERE = Path(__file__).parent
SAMPLES = HERE.parents[3] / "samples"


def sheet(rows: list[list[tuple[str, Image.Image]]], width: int) -> Image.Image:
    """Pictures in rows, each with its name on it."""
    height = rows[0][0][1].height * width // rows[0][0][1].width
    out = Image.new("RGB", (len(rows[0]) * (width + 4), len(rows) * (height + 4)), "white")
    for y, row in enumerate(rows):
        for x, (name, picture) in enumerate(row):
            tile = picture.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
            pen = ImageDraw.Draw(tile)
            box = pen.textbbox((8, 6), name, font_size=15)
            if name:
                pen.rectangle((box[0] - 4, box[1] - 3, box[2] + 4, box[3] + 3), fill="white")
                pen.text((8, 6), name, fill="black", font_size=15)
            out.paste(tile, (x * (width + 4), y * (height + 4)))
    return out


def clip() -> None:
    frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(SAMPLES / "planet.gif"))]
    art = list(polyreel.Renderer(points=700).stream(frames))
    chosen = [0, len(frames) // 3, 2 * len(frames) // 3]
    rows = [[(f"frame {i + 1}", frames[i]) for i in chosen], [("Low-poly", art[i]) for i in chosen]]
    sheet(rows, 300).save(HERE / "clip.jpg", quality=85)


def presets() -> None:
    lake = Image.open(SAMPLES / "lake.jpg").convert("RGB")
    lake.thumbnail((640, 640))
    looks = [("source", lake), *((name, polyreel.render(lake, preset=name)) for name in polyreel.presets())]
    half = (len(looks) + 1) // 2
    looks += [("points 300", polyreel.render(lake, points=300, quality="best"))][: 2 * half - len(looks)]
    sheet([looks[:half], looks[half:]], 240).save(HERE / "presets.jpg", quality=85)


def icon() -> None:
    y, x = np.mgrid[0:256, 0:256]
    sphere = np.clip(1.15 - np.hypot(x - 96, y - 92) / 150, 0.35, 1)[..., None] * [70, 190, 240]
    inside = np.hypot(x - 128, y - 128)[..., None] < 112
    picture = np.where(inside, sphere, [24, 28, 48]).astype(np.uint8)
    art = Image.fromarray(polyreel.render(picture, points=60, quality="best", edges="hard"))
    art.save(HERE.parent / "icon.png", optimize=True)


if __name__ == "__main__":
    clip()
    presets()
    icon()
