"""Kinds of pictures: how to make each a numpy array, and how to give it back as it came."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

#: An array, and a function that makes an array of the same layout a picture of the kind that it was.
Unpacked = tuple["np.ndarray[Any, Any]", Callable[["np.ndarray[Any, Any]"], Any]]


def unpack(picture: Any) -> Unpacked:
    """Returns the picture as an array, and a function that makes an array a picture of its kind."""
    if isinstance(picture, np.ndarray):
        return _unpack_array(picture)
    module = type(picture).__module__.partition(".")[0]
    if module == "PIL":
        return _unpack_pil(picture)
    if module == "torch" and hasattr(picture, "detach"):
        return _unpack_torch(picture)
    if hasattr(picture, "__array__"):
        return _unpack_array(np.asarray(picture))
    if hasattr(picture, "__dlpack__"):
        return _unpack_array(np.from_dlpack(picture))
    raise TypeError(
        f"a {type(picture).__name__} is not a picture: give a numpy array, a PIL image or a CPU tensor"
    )


def _same(out: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return out


def _unpack_array(array: np.ndarray[Any, Any]) -> Unpacked:
    dtype = array.dtype
    if dtype == np.float16:
        return array.astype(np.float32), lambda out: out.astype(dtype)
    if not dtype.isnative:
        return array.astype(dtype.newbyteorder("=")), lambda out: out.astype(dtype)
    return array, _same


def _unpack_pil(image: Any) -> Unpacked:
    # Who has an image has the module.
    pillow = sys.modules["PIL.Image"]
    mode = image.mode
    if mode not in ("RGB", "RGBA", "L", "LA", "P", "1", "CMYK", "YCbCr", "La", "RGBa", "PA", "RGBX"):
        raise TypeError(f"an image of mode {mode} is not supported: convert it to RGB or RGBA")
    has_alpha = "A" in image.getbands() or "a" in image.getbands() or "transparency" in image.info
    array = np.asarray(image.convert("RGBA" if has_alpha else "RGB"))

    def back(out: np.ndarray[Any, Any]) -> Any:
        made = pillow.fromarray(out)
        return made.convert(mode) if mode in ("L", "LA") else made

    return array, back


def _unpack_torch(tensor: Any) -> Unpacked:
    torch = sys.modules["torch"]
    if tensor.device.type != "cpu":
        raise TypeError(f"the tensor is on {tensor.device}: move it with .cpu() first")
    dtype = tensor.dtype
    tensor = tensor.detach()
    if dtype in (torch.float16, torch.bfloat16):
        tensor = tensor.float()
    return tensor.numpy(), lambda out: torch.from_numpy(out).to(dtype)
