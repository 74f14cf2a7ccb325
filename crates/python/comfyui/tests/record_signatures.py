"""Records the signatures of what the nodes use of ComfyUI, from its source, in signatures.json:

    python record_signatures.py /path/to/ComfyUI

The tests hold their stand-in against that file, so that it has the shape of the real one.
"""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path

#: File, and the classes or functions of it.
WANTED = {
    "comfy_api/latest/_io.py": [
        "Schema", "Input", "Output", "Int.Input", "Float.Input", "Combo.Input", "String.Input", "Hidden",
        "NodeOutput", "Custom",
    ],
    "comfy_api/latest/__init__.py": ["ComfyExtension.get_node_list"],
    "comfy_api/latest/_input_impl/video_types.py": [
        "VideoFromFile", "VideoFromFile.get_stream_source", "VideoFromComponents", "VideoFromComponents.save_to",
    ],
    "comfy_extras/nodes_images.py": ["SVG"],
    "comfy/model_management.py": ["throw_exception_if_processing_interrupted"],
    "comfy/utils.py": ["ProgressBar", "ProgressBar.update_absolute"],
    "folder_paths.py": ["get_temp_directory"],
}


def find(body: list[ast.stmt], path: list[str]) -> ast.stmt | None:
    for node in body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and node.name == path[0]:
            if len(path) == 1:
                return node
            return find(node.body, path[1:]) if isinstance(node, ast.ClassDef) else None
    return None


def parameters(node: ast.stmt | None) -> list[str] | None:
    """The names of parameters, or the fields of a class that has no constructor."""
    if isinstance(node, ast.ClassDef):
        made = find(node.body, ["__init__"])
        if made is not None:
            return parameters(made)
        fields = [field.target.id for field in node.body if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)]
        words = [field.targets[0].id for field in node.body if isinstance(field, ast.Assign) and isinstance(field.targets[0], ast.Name)]
        return fields or words
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        names = [argument.arg for argument in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]]
        names += ["*" + node.args.vararg.arg] if node.args.vararg else []
        return [name for name in names if name not in ("self", "cls")]
    return None


def main() -> None:
    root = Path(sys.argv[1])
    found = {}
    for file, names in WANTED.items():
        body = ast.parse((root / file).read_text(encoding="utf-8")).body
        found[file] = {name: parameters(find(body, name.split("."))) for name in names}
    target = Path(__file__).with_name("signatures.json")
    target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
