"""Low-poly art for ComfyUI: nodes for pictures, clips, video files and SVG, by the package ``polyreel``."""

from __future__ import annotations

from comfy_api.latest import ComfyExtension, io

from .nodes import LowPoly, LowPolyPreset, LowPolySVG, LowPolyVideo


class PolyreelExtension(ComfyExtension):
    """The nodes."""

    async def get_node_list(self) -> list[type[io.ComfyNode]]:
        return [LowPoly, LowPolyVideo, LowPolySVG, LowPolyPreset]


async def comfy_entrypoint() -> PolyreelExtension:
    return PolyreelExtension()
