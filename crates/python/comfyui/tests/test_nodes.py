"""The nodes against a stand-in for ComfyUI. Frames of a clip in pieces have the bytes of the whole."""

import asyncio
import importlib.util
import inspect
import json
import subprocess
import sys
import types
from io import BytesIO
from pathlib import Path

import numpy as np
import polyreel
import pytest
import standin
from PIL import Image

FOLDER = Path(__file__).parents[1]
standin.install()
spec = importlib.util.spec_from_file_location("nodes_pack", FOLDER / "__init__.py", submodule_search_locations=[str(FOLDER)])
pack = importlib.util.module_from_spec(spec)
sys.modules["nodes_pack"] = pack
spec.loader.exec_module(pack)
nodes = sys.modules["nodes_pack.nodes"]
FIELDS = {"points": 60, "quality": "normal", "coherence": 0.4, "seed": 0}


@pytest.fixture(autouse=True)
def fresh(tmp_path):
    standin.state.reports.clear()
    standin.state.interrupt_at, standin.state.checks, standin.state.temp = None, 0, str(tmp_path / "temp")
    nodes.streams._renderers.clear()
    standin.ComfyNode.hidden = types.SimpleNamespace(unique_id="7", prompt=None)


def clip(count, channels=3, height=48, width=64):
    y, x = np.mgrid[0:height, 0:width]
    frames = [
        np.stack([((x + 3 * i) % 30 < 11) * 0.7 + 0.1, y / height, (x + y) / (height + width), (y > 8) * 1.0], -1)
        for i in range(count)
    ]
    return np.stack(frames)[..., :channels].astype(np.float32)


def run(frames, **more):
    out = nodes.LowPoly.execute(standin.Tensor(frames), **{**FIELDS, **more})
    return out.args[0].array, out.args[1].array


def test_the_nodes_are_listed_and_their_schemas_are_sound():
    extension = asyncio.run(pack.comfy_entrypoint())
    listed = asyncio.run(extension.get_node_list())
    assert [node.__name__ for node in listed] == ["LowPoly", "LowPolyVideo", "LowPolySVG", "LowPolyPreset"]
    for node in listed:
        schema = node.define_schema().given
        inputs = [entry.given["id"] for entry in schema["inputs"]]
        taken = inspect.signature(node.execute).parameters
        assert sorted(inputs) == sorted(taken), schema["node_id"]
        for entry in schema["inputs"]:
            optional = entry.given.get("optional", False)
            assert (taken[entry.given["id"]].default is not inspect.Parameter.empty) == optional


def test_the_stand_in_refuses_what_comfyui_would():
    io = sys.modules["comfy_api.latest"].io
    with pytest.raises(TypeError, match="takes"):
        io.Int.Input("points", maximum=4)


@pytest.mark.parametrize("channels", [3, 4])
def test_a_clip_is_one_stream(channels):
    frames = clip(8, channels)
    out, mask = run(frames)
    expected = np.stack(list(polyreel.Renderer(points=60, quality="normal", coherence=0.4, seed=0).stream(frames)))
    assert out.dtype == np.float32 and np.array_equal(out, expected)
    assert np.array_equal(mask, 1 - out[..., 3] if channels == 4 else np.zeros(frames.shape[:3]))
    assert standin.state.reports[-1]["value"] == 8 and standin.state.reports[-1]["total"] == 8
    assert standin.state.reports[0]["preview"][1].size == (64, 48) and standin.state.reports[0]["node"] == "7"
    assert standin.state.checks == 8


def test_a_picture_is_a_still():
    out, _ = run(clip(1))
    assert np.array_equal(out[0], polyreel.render(clip(1)[0], points=60, quality="normal"))


def meta_batch(requeue):
    """A prompt as VideoHelperSuite queues it, with a node between the loader and ours."""
    return {
        "1": {"class_type": "VHS_BatchManager", "inputs": {"frames_per_batch": 16, "requeue": requeue}},
        "2": {"class_type": "VHS_LoadVideo", "inputs": {"video": "a.mp4", "meta_batch": ["1", 0]}},
        "3": {"class_type": "ImageScale", "inputs": {"image": ["2", 0], "width": 64}},
        "7": {"class_type": "PolyreelLowPoly", "inputs": {"images": ["3", 0], "points": 60}},
    }


def in_pieces(frames, size, **more):
    pieces = []
    for number, at in enumerate(range(0, len(frames), size)):
        standin.ComfyNode.hidden = types.SimpleNamespace(unique_id="7", prompt=meta_batch(number))
        pieces.append(run(frames[at : at + size], **more)[0])
    return np.concatenate(pieces)


@pytest.mark.parametrize("size", [16, 1, 7])
def test_pieces_of_a_meta_batch_have_the_bytes_of_the_whole(size):
    frames = clip(40)
    whole, _ = run(frames)
    assert np.array_equal(in_pieces(frames, size), whole)
    # A new queue begins anew.
    assert np.array_equal(in_pieces(frames, size), whole)


def test_pieces_with_a_mask_have_the_bytes_of_the_whole():
    frames, mask = clip(20), np.zeros((1, 24, 32), np.float32)
    mask[:, :, 16:] = 1
    whole, _ = run(frames, mask=standin.Tensor(mask))
    assert np.array_equal(in_pieces(frames, 8, mask=standin.Tensor(mask)), whole)


def test_other_options_in_the_middle_keep_the_stream():
    frames = clip(8)
    standin.ComfyNode.hidden = types.SimpleNamespace(unique_id="7", prompt=meta_batch(0))
    run(frames[:4])
    standin.ComfyNode.hidden = types.SimpleNamespace(unique_id="7", prompt=meta_batch(1))
    out, _ = run(frames[4:], look={"saturation": "0"})
    assert np.ptp(out, axis=-1).max() < 0.01


def test_a_mask_makes_facets_smaller_where_it_is_white():
    frames, mask = clip(1), np.zeros((48, 64), np.float32)
    mask[:, 32:] = 1
    out, returned = run(frames, mask=standin.Tensor(mask), focus=8.0)
    plain, _ = run(frames)
    assert np.array_equal(out[:, :, :31], plain[:, :, :31]) and np.array_equal(returned, mask)
    error = lambda picture: np.square(picture[:, :, 33:] - frames[:, :, 33:]).mean()
    assert error(out) < 0.7 * error(plain)


def test_interruption_is_honoured_at_every_frame():
    standin.state.interrupt_at = 3
    standin.ComfyNode.hidden = types.SimpleNamespace(unique_id="7", prompt=meta_batch(0))
    with pytest.raises(standin.Interrupted):
        run(clip(8))
    assert standin.state.checks == 3 and not nodes.streams._renderers


def test_only_so_many_clips_are_remembered():
    for number in range(9):
        prompt = meta_batch(0)
        prompt[str(100 + number)] = prompt.pop("7")
        standin.ComfyNode.hidden = types.SimpleNamespace(unique_id=str(100 + number), prompt=prompt)
        run(clip(1))
    assert len(nodes.streams._renderers) == 4


def test_svg():
    out = nodes.LowPolySVG.execute(standin.Tensor(clip(2)), **FIELDS, seams="underlap").args[0]
    assert [document.read(4) for document in out.data] == [b"<svg", b"<svg"]


def test_svg_has_the_class_of_newer_comfyui(monkeypatch):
    newer = type("SVG", (standin.SVG,), {})
    monkeypatch.setattr(nodes.io.SVG, "Type", newer)
    out = nodes.LowPolySVG.execute(standin.Tensor(clip(1)), **FIELDS, seams="none").args[0]
    assert type(out) is newer and len(out.data) == 1


def test_a_preset_is_handed_on():
    text = "outline=white\n--outline-width = 2\n\n"
    look = nodes.LowPolyPreset.execute("bold", text).args[0]
    assert look == {"outline": "white", "outline_width": "2", "preset": "bold"}
    out, _ = run(clip(1), look=look, points=0, quality="as the preset")
    expected = polyreel.render(clip(1)[0], preset="bold", outline="white", outline_width=2)
    assert np.array_equal(out[0], expected)
    assert nodes.LowPolyPreset.validate_inputs(text) is True
    assert "did you mean 'points'" in nodes.LowPolyPreset.validate_inputs("pionts=4")


def test_options_that_another_node_gives_are_checked_when_it_has_run():
    """ComfyUI validates a linked input as None."""
    assert nodes.LowPolyPreset.validate_inputs(None) is True
    with pytest.raises(TypeError, match="did you mean 'points'"):
        nodes.LowPolyPreset.execute("default", "pionts=4")


def test_an_error_names_the_picture_of_the_batch():
    frames = clip(3)
    frames[1, 5, 5, 0] = np.nan
    with pytest.raises(ValueError, match="picture 2 of 3: .*NaN"):
        run(frames)
    with pytest.raises(ValueError, match="picture 2 of 3: .*NaN"):
        nodes.LowPolySVG.execute(standin.Tensor(frames), **FIELDS, seams="none")


def test_a_mask_without_values_is_refused():
    with pytest.raises(ValueError, match="mask is empty"):
        run(clip(1), mask=standin.Tensor(np.zeros((0, 48, 64), np.float32)))
    with pytest.raises(ValueError, match="mask holds NaN"):
        run(clip(1), mask=standin.Tensor(np.full((1, 48, 64), np.nan, np.float32)))


@pytest.fixture
def video(tmp_path):
    for i, frame in enumerate(clip(12)):
        Image.fromarray((frame * 255).astype(np.uint8)).save(tmp_path / f"{i:02}.png")
    name = tmp_path / "a.mp4"
    sound = ["-f", "lavfi", "-i", "sine=duration=0.48"]
    command = ["ffmpeg", "-v", "error", "-i", tmp_path / "%02d.png", *sound, "-shortest", "-pix_fmt", "yuv420p", name]
    subprocess.run(command, check=True, timeout=120)
    return name


@pytest.mark.parametrize("in_memory", [False, True])
def test_a_video_goes_from_file_to_file(video, in_memory):
    given = BytesIO(video.read_bytes()) if in_memory else str(video)
    out = nodes.LowPolyVideo.execute(standin.VideoFromFile(given), **FIELDS, crf=20).args[0].file
    info = polyreel.probe(out)
    assert info["frames"] == 12 and "aac" in info["audio"]
    assert [file.name for file in Path(standin.state.temp).iterdir()] == [Path(out).name]
    assert standin.state.reports[-1]["value"] == 12


def test_a_video_of_frames_is_saved_by_comfyui_first(video):
    """Create Video hands over frames, whose stream ComfyUI 0.3.64 cannot make: "Could not determine output format"."""
    made = standin.VideoFromComponents(video.read_bytes())
    out = nodes.LowPolyVideo.execute(made, **FIELDS, crf=20).args[0].file
    info = polyreel.probe(out)
    assert info["frames"] == 12 and "aac" in info["audio"]
    assert [file.name for file in Path(standin.state.temp).iterdir()] == [Path(out).name]


@pytest.mark.parametrize("window, frames", [((0.12, 0.2), 5), ((0.2, 0.0), 7), ((0.0, 0.24), 6)])
def test_of_a_trimmed_video_only_the_part_is_rendered(video, window, frames):
    """Newer ComfyUI trims a video by a window, and its stream source is the whole file."""
    trimmed = standin.VideoFromFile(str(video))
    trimmed.get_active_trim_window = lambda: window
    out = nodes.LowPolyVideo.execute(trimmed, **FIELDS, crf=20).args[0].file
    assert polyreel.probe(out)["frames"] == frames


def test_a_video_with_edits_of_its_frames_is_saved_by_comfyui_first(video):
    """Newer ComfyUI crops and resizes a video where it is saved, and its stream source is the file before that."""
    edited = standin.VideoFromFile("before-the-edits.mp4")
    edited.has_pending_frame_edits = lambda: True
    edited.save_to = lambda path: Path(path).write_bytes(video.read_bytes())
    out = nodes.LowPolyVideo.execute(edited, **FIELDS, crf=20).args[0].file
    assert polyreel.probe(out)["frames"] == 12
    assert [file.name for file in Path(standin.state.temp).iterdir()] == [Path(out).name]


def test_an_interrupted_video_leaves_nothing(video):
    standin.state.interrupt_at = 2
    with pytest.raises(standin.Interrupted):
        nodes.LowPolyVideo.execute(standin.VideoFromFile(str(video)), **FIELDS, crf=20)
    assert not list(Path(standin.state.temp).iterdir())


@pytest.mark.parametrize("file", sorted((FOLDER / "workflows").glob("*.json")), ids=lambda file: file.stem)
def test_workflows_fit_the_nodes(file):
    prompt = json.loads(file.read_text())
    own = {f"Polyreel{name}": getattr(nodes, name) for name in ["LowPoly", "LowPolyVideo", "LowPolySVG", "LowPolyPreset"]}
    used = [node for node in prompt.values() if node["class_type"] in own]
    assert used
    for node in used:
        entries = {entry.given["id"]: entry.given for entry in own[node["class_type"]].define_schema().given["inputs"]}
        assert set(node["inputs"]) <= set(entries)
        assert {name for name, entry in entries.items() if not entry.get("optional")} <= set(node["inputs"])
