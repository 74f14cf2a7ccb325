"""The nodes. Each ``execute`` works on the CPU whatever device its tensors are on, and leaves models where they are."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import folder_paths
import numpy as np
import polyreel
import torch
from comfy import model_management
from comfy.utils import ProgressBar
from comfy_api.latest import InputImpl, io
from PIL import Image

from .sources import file_of
from .streams import Streams, batch

CATEGORY = "image/low-poly"
#: Options as a node hands them to another.
Look = io.Custom("POLYREEL_LOOK")
#: Seconds between two messages to the browser, and between two pictures for it; their longest side.
REPORT_INTERVAL, SHOWN, SIDE = 0.1, 0.5, 512

streams = Streams()


class Progress:
    """Tells the browser how far a node is, shows it pictures, and honours the wish to stop."""

    def __init__(self, node: str | None) -> None:
        self._node = node
        self._bar: ProgressBar | None = None
        self._reported = self._shown = 0.0
        self._picture: tuple[str, Image.Image, int] | None = None

    def show(self, picture: Callable[[], np.ndarray[Any, Any]] | np.ndarray[Any, Any]) -> None:
        """Sends a picture of the work along with the next message, not too often."""
        now = time.monotonic()
        if now - self._shown >= SHOWN:
            self._shown = now
            image = Image.fromarray(picture() if callable(picture) else picture)
            image.thumbnail((SIDE, SIDE))
            self._picture = ("JPEG", image, SIDE)

    def frame(self, done: int, total: int | None) -> None:
        """Tells that a frame is done. Raises ComfyUI's exception where the user wants to stop."""
        model_management.throw_exception_if_processing_interrupted()
        now = time.monotonic()
        if now - self._reported >= REPORT_INTERVAL or done == total:
            self._reported = now
            most = total or done + 1
            self._bar = self._bar or ProgressBar(most, node_id=self._node)
            self._bar.update_absolute(done, total=most, preview=self._picture)
            self._picture = None


def look_of(look: dict[str, Any] | None, points: int, quality: str, coherence: float, seed: int) -> dict[str, Any]:
    """The options of a node: what the preset node says, with the node's own fields over it."""
    options = dict(look or {})
    if points > 0:
        options["points"] = points
    if quality != PRESETS_OWN and "refine" not in options:
        options["quality"] = quality
    options["coherence"] = coherence
    options["seed"] = seed
    return options


PRESETS_OWN = "as the preset"
QUALITIES = [PRESETS_OWN, "draft", "normal", "best"]


def look_inputs() -> list[Any]:
    """What all nodes that render ask for."""
    return [
        io.Int.Input(
            "points", default=1500, min=0, max=200_000,
            tooltip="Vertices of the mesh: fewer are larger facets. 0 takes the preset's share of the pixels.",
        ),
        io.Combo.Input(
            "quality", options=QUALITIES, default="normal",
            tooltip="How closely the facets are fitted to the picture: best takes a few times as long.",
        ),
        io.Float.Input(
            "coherence", default=0.4, min=0.0, max=1.0, step=0.05,
            tooltip="How firmly a frame holds to the one before: 0 is each frame alone, 1 least flicker.",
        ),
        io.Int.Input("seed", default=0, min=0, max=0xFFFF_FFFF_FFFF_FFFF, tooltip="The same seed gives the same picture."),
        Look.Input("look", optional=True, tooltip="From the node 'Low-poly preset'."),
    ]


def pictures(images: torch.Tensor) -> np.ndarray[Any, Any]:
    """A batch of frames as an array on the CPU, without a copy where it is there already."""
    return images.detach().to("cpu", torch.float32).numpy()


@contextmanager
def numbered(number: int, count: int) -> Iterator[None]:
    """Says which picture of a batch an error is about."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"picture {number} of {count}: {error}") from error


class LowPoly(io.ComfyNode):
    """IMAGE -> IMAGE, MASK: a picture, or a whole clip as one stream."""

    @classmethod
    def define_schema(cls) -> io.Schema:
        return io.Schema(
            node_id="PolyreelLowPoly",
            display_name="Low-poly",
            category=CATEGORY,
            description="Turns pictures into low-poly art. A batch is one clip: its facets move with the picture "
            "instead of flickering. With VideoHelperSuite's Meta Batch they live on from piece to piece.",
            inputs=[
                io.Image.Input("images", tooltip="A picture, or the frames of a clip in their order."),
                *look_inputs(),
                io.Mask.Input(
                    "mask", optional=True,
                    tooltip="Where the picture matters: there facets are smaller. One mask for all frames, or one each.",
                ),
                io.Float.Input(
                    "focus", default=4.0, min=1.0, max=16.0, step=0.5, optional=True,
                    tooltip="How many times as many vertices there are where the mask is white.",
                ),
            ],
            outputs=[
                io.Image.Output(display_name="images"),
                io.Mask.Output(display_name="mask", tooltip="What is transparent; else the mask that came in."),
            ],
            hidden=[io.Hidden.unique_id, io.Hidden.prompt],
        )

    @classmethod
    def execute(
        cls,
        images: torch.Tensor,
        points: int,
        quality: str,
        coherence: float,
        seed: int,
        look: dict[str, Any] | None = None,
        mask: torch.Tensor | None = None,
        focus: float = 4.0,
    ) -> io.NodeOutput:
        node = cls.hidden.unique_id
        if len(images) == 1 and batch(cls.hidden.prompt, node) is None:
            # As the program renders a still: nothing comes after it.
            coherence = 0.0
        options = look_of(look, points, quality, coherence, seed)
        looks = [options] if mask is None else [options, {**options, "points": finer(options, focus, images)}]
        renderers = streams.renderers(cls.hidden.prompt, node, looks)
        frames = pictures(images)
        weights = None if mask is None else weights_of(mask, frames.shape)
        out = np.empty(frames.shape, np.float32)
        progress = Progress(node)
        try:
            for i, frame in enumerate(frames):
                with numbered(i + 1, len(frames)):
                    picture = renderers[0].render(frame)
                    if weights is not None:
                        weight = weights[min(i, len(weights) - 1)][..., None]
                        picture += (renderers[1].render(frame) - picture) * weight
                out[i] = picture
                progress.show(lambda: (out[i, ..., :3] * 255).astype(np.uint8))
                progress.frame(i + 1, len(frames))
        except BaseException:
            streams.forget(node)
            raise
        result = torch.from_numpy(out)
        return io.NodeOutput(result, mask_of(result, mask))


def finer(options: dict[str, Any], focus: float, images: torch.Tensor) -> int:
    """The points of the picture that is shown where the mask is white."""
    pixels = images.shape[1] * images.shape[2]
    points = options.get("points")
    if not isinstance(points, int):
        points = len(polyreel.triangulate(np.zeros((images.shape[1], images.shape[2], 3), np.uint8), **options).ids) - 4
    return max(1, min(pixels // 4, round(points * focus)))


def weights_of(mask: torch.Tensor, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
    """The mask, or masks, at the size of the frames: (n, height, width), 0 to 1."""
    values = mask.detach().to("cpu", torch.float32).numpy()
    if values.size == 0:
        raise ValueError("the mask is empty: give one mask for all pictures, or one for each")
    if np.isnan(values).any():
        raise ValueError("the mask holds NaN: its values are 0 to 1")
    height, width = shape[1:3]
    weights = [
        np.asarray(Image.fromarray(value).resize((width, height), Image.Resampling.BILINEAR))
        for value in values.reshape(-1, *values.shape[-2:])
    ]
    return np.clip(weights, 0, 1)


def mask_of(images: torch.Tensor, mask: torch.Tensor | None) -> torch.Tensor:
    """ComfyUI's mask of pictures: 1 where they are transparent."""
    if images.shape[-1] == 4:
        return 1.0 - images[..., 3]
    return torch.from_numpy(np.zeros(images.shape[:3], np.float32)) if mask is None else mask


class LowPolyVideo(io.ComfyNode):
    """VIDEO -> VIDEO: from file to file, with sound, in memory that does not grow with the length."""

    @classmethod
    def define_schema(cls) -> io.Schema:
        return io.Schema(
            node_id="PolyreelLowPolyVideo",
            display_name="Low-poly video",
            category=CATEGORY,
            description="Turns a video into low-poly art, from file to file: with its sound and times, never all of it "
            "in memory.",
            inputs=[
                io.Video.Input("video"),
                *look_inputs(),
                io.Int.Input(
                    "crf", default=18, min=0, max=51, tooltip="Constant quality of H.264: smaller is better and larger."
                ),
            ],
            outputs=[io.Video.Output(display_name="video")],
            hidden=[io.Hidden.unique_id],
        )

    @classmethod
    def execute(
        cls,
        video: Any,
        points: int,
        quality: str,
        coherence: float,
        seed: int,
        crf: int,
        look: dict[str, Any] | None = None,
    ) -> io.NodeOutput:
        options = look_of(look, points, quality, coherence, seed)
        folder = folder_paths.get_temp_directory()
        os.makedirs(folder, exist_ok=True)
        name = os.path.join(folder, f"low-poly-{uuid.uuid4().hex}")
        progress = Progress(cls.hidden.unique_id)
        with file_of(video, name) as (source, part):
            options = {**options, "crf": crf, **part}
            polyreel.render_file(source, f"{name}.mp4", progress=progress.frame, preview=progress.show, **options)
        return io.NodeOutput(InputImpl.VideoFromFile(f"{name}.mp4"))


class LowPolySVG(io.ComfyNode):
    """IMAGE -> SVG: each picture as vectors, without seams between facets."""

    @classmethod
    def define_schema(cls) -> io.Schema:
        return io.Schema(
            node_id="PolyreelLowPolySVG",
            display_name="Low-poly SVG",
            category=CATEGORY,
            description="Turns pictures into SVG of flat triangles, for print, cutters and vector programs.",
            inputs=[
                io.Image.Input("images"),
                *look_inputs(),
                io.Combo.Input(
                    "seams", options=["underlap", "stroke", "none"], default="underlap",
                    tooltip="What keeps the ground from showing between facets.",
                ),
            ],
            outputs=[io.SVG.Output(display_name="svg")],
            hidden=[io.Hidden.unique_id],
        )

    @classmethod
    def execute(
        cls,
        images: torch.Tensor,
        points: int,
        quality: str,
        coherence: float,
        seed: int,
        seams: str,
        look: dict[str, Any] | None = None,
    ) -> io.NodeOutput:
        options = look_of(look, points, quality, coherence, seed)
        progress = Progress(cls.hidden.unique_id)
        documents = []
        frames = pictures(images)
        for i, frame in enumerate(frames):
            with numbered(i + 1, len(frames)):
                text = polyreel.triangulate(frame, **options).svg(seams=seams)
            documents.append(BytesIO(text.encode()))
            progress.frame(i + 1, len(frames))
        return io.NodeOutput(svg_type()(documents))


def svg_type() -> Any:
    """ComfyUI's class of SVGs: first it was only with the nodes that make them, later with the types."""
    if io.SVG.Type is not Any:
        return io.SVG.Type
    from comfy_extras.nodes_images import SVG

    return SVG


class LowPolyPreset(io.ComfyNode):
    """A preset, and any other option by its name, for the other nodes."""

    @classmethod
    def define_schema(cls) -> io.Schema:
        about = "\n".join(f"{name}: {text}" for name, text in polyreel.presets().items())
        return io.Schema(
            node_id="PolyreelLowPolyPreset",
            display_name="Low-poly preset",
            category=CATEGORY,
            description=f"Chooses how the other low-poly nodes draw. Set their points to 0 to have the preset's.\n{about}",
            inputs=[
                io.Combo.Input("preset", options=["default", *polyreel.presets()], tooltip=about),
                io.String.Input(
                    "options", default="", multiline=True, placeholder="outline=white\nsaturation=1.3",
                    tooltip="More options, one a line: name=value, by the names of the command line.",
                ),
            ],
            outputs=[Look.Output(display_name="look")],
        )

    @classmethod
    def validate_inputs(cls, options: str | None) -> bool | str:
        if options is None:
            # Another node gives the text: what it says is known when that node has run.
            return True
        try:
            polyreel.Renderer(**parsed(options))
        except (TypeError, polyreel.Error) as error:
            return str(error)
        return True

    @classmethod
    def execute(cls, preset: str, options: str) -> io.NodeOutput:
        look = parsed(options)
        if preset != "default":
            look["preset"] = preset
        polyreel.Renderer(**look)
        return io.NodeOutput(look)


def parsed(text: str) -> dict[str, Any]:
    """Options written one a line: ``name=value``; a name alone is a flag."""
    options: dict[str, Any] = {}
    for line in filter(None, map(str.strip, text.splitlines())):
        name, equals, value = line.removeprefix("--").partition("=")
        options[name.strip().replace("-", "_")] = value.strip() if equals else True
    return options
