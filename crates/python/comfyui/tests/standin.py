"""A stand-in for what the nodes use of ComfyUI and torch. What it takes is what the real ones take: the parameters are
those in signatures.json, and any other is an error."""

from __future__ import annotations

import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np

SIGNATURES: dict[str, dict[str, list[str]]] = json.loads(Path(__file__).with_name("signatures.json").read_text())
IO = SIGNATURES["comfy_api/latest/_io.py"]


class Interrupted(Exception):
    """What ComfyUI raises where the user wants to stop."""


#: What the tests look at and set.
state = types.SimpleNamespace(reports=[], interrupt_at=None, temp="", checks=0)


def recorded(name: str, parameters: list[str]) -> type:
    """A class that takes the recorded parameters, and keeps them."""

    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        unknown = set(kwargs) - set(parameters)
        if unknown or len(args) > len(parameters):
            raise TypeError(f"{name} of ComfyUI takes {parameters}, not {unknown or args}")
        self.given = {**dict(zip(parameters, args)), **kwargs}

    return type(name.replace(".", "_"), (), {"__init__": init})


def kind(io_type: str) -> Any:
    """A type of ComfyUI's with its input and output."""
    own = f"{io_type.capitalize()}.Input"
    given = recorded(own, IO.get(own, IO["Input"]))
    shown = recorded("Output", IO["Output"])
    for part in (given, shown):
        part.io_type = io_type
    return types.SimpleNamespace(Input=given, Output=shown, Type=Any)


class Tensor:
    """An array with the few methods of a tensor that the nodes call."""

    def __init__(self, array: np.ndarray[Any, Any]) -> None:
        self.array, self.shape = array, array.shape

    def detach(self) -> Tensor:
        return self

    def to(self, device: str, dtype: Any) -> Tensor:
        assert device == "cpu"
        return Tensor(self.array.astype(dtype, copy=False))

    def numpy(self) -> np.ndarray[Any, Any]:
        return self.array

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, at: Any) -> Tensor:
        return Tensor(self.array[at])

    def __rsub__(self, other: float) -> Tensor:
        return Tensor(other - self.array)


class VideoFromFile:
    def __init__(self, file: Any) -> None:
        self.file = file

    def get_stream_source(self) -> Any:
        return self.file


class VideoFromComponents:
    """Frames; the stand-in has the bytes that they are saved as."""

    def __init__(self, components: bytes) -> None:
        self.components = components

    def get_stream_source(self) -> Any:
        raise ValueError("Could not determine output format")

    def save_to(self, path: str) -> None:
        Path(path).write_bytes(self.components)


class SVG:
    def __init__(self, data: list[Any]) -> None:
        self.data = data


class ProgressBar(recorded("ProgressBar", SIGNATURES["comfy/utils.py"]["ProgressBar"])):
    def update_absolute(self, *args: Any, **kwargs: Any) -> None:
        names = SIGNATURES["comfy/utils.py"]["ProgressBar.update_absolute"]
        assert set(kwargs) <= set(names), kwargs
        state.reports.append({**dict(zip(names, args)), **kwargs, "node": self.given["node_id"]})


class ComfyNode:
    hidden = types.SimpleNamespace(unique_id="7", prompt=None)


class NodeOutput:
    def __init__(self, *args: Any) -> None:
        self.args = args


class ComfyExtension:
    pass


def throw_exception_if_processing_interrupted() -> None:
    state.checks += 1
    if state.interrupt_at is not None and state.checks >= state.interrupt_at:
        raise Interrupted


def module(name: str, **members: Any) -> types.ModuleType:
    made = types.ModuleType(name)
    made.__dict__.update(members)
    sys.modules[name] = made
    return made


def install() -> None:
    """Puts the stand-in where the nodes import ComfyUI and torch from."""
    names = ["Int", "Float", "Combo", "String", "Image", "Mask", "Video", "SVG"]
    kinds = {name: kind(name if name == "SVG" else name.upper()) for name in names}
    hidden = types.SimpleNamespace(**{name: name for name in IO["Hidden"]})
    io = types.SimpleNamespace(
        **kinds, Custom=kind, Hidden=hidden, Schema=recorded("Schema", IO["Schema"]), ComfyNode=ComfyNode,
        NodeOutput=NodeOutput,
    )
    latest = module(
        "comfy_api.latest", io=io, ComfyExtension=ComfyExtension,
        InputImpl=types.SimpleNamespace(VideoFromFile=VideoFromFile, VideoFromComponents=VideoFromComponents),
    )
    module("comfy_api", latest=latest)
    management = module(
        "comfy.model_management",
        throw_exception_if_processing_interrupted=throw_exception_if_processing_interrupted,
    )
    module("comfy", model_management=management, utils=module("comfy.utils", ProgressBar=ProgressBar))
    module("comfy_extras", nodes_images=module("comfy_extras.nodes_images", SVG=SVG))
    module("folder_paths", get_temp_directory=lambda: state.temp)
    module("torch", Tensor=Tensor, float32=np.float32, from_numpy=Tensor)
