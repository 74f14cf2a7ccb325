"""Bytes are those of the command line, of every option: the program of this wheel is the reference, in a process of
its own (or the one that POLYREEL names)."""

import os
import subprocess
import sys

import numpy as np
import pytest
from test_polyreel import picture, save_frames

import polyreel

Image = pytest.importorskip("PIL.Image")
PROGRAM = [os.environ["POLYREEL"]] if "POLYREEL" in os.environ else [sys.executable, "-m", "polyreel"]

#: A value for each option of the look that has an effect on a small picture.
LOOKS = {
    "preset": "bold", "method": "help", "points": 70, "seed": 3, "coherence": 0.9, "quality": "best", "refine": 2,
    "error": "psnr:24", "regularity": 0.9, "edges": "hard", "outline": "#804020", "outline_width": 3,
    "outline_contrast": 30, "saturation": 1.6, "wash": 0.4, "smoothing": 0, "clusters": 4, "interval": 1,
    "interior": 0.2, "hex_density": 0.01, "max_points": 9, "default_points": 0, "thresholds": (0.5, 0.2, 0.1),
    "features": "sobel", "candidates": 0.2, "min_points": 3, "percentiles": (60, 20), "entropy_radius": 3,
    "diffusion_iterations": 3, "diffusion_kappa": 20.0, "diffusion_gamma": 0.1,
    "fill": "linear", "contrast": 1.5, "chroma": 1.4, "duotone": "navy,#ffe8c0", "palette": 5, "shape": "polygons",
    "focus": "50%,40%,20%",
}
#: What else an option needs to have an effect.
WITH = {
    "outline_width": {"outline": True}, "outline_contrast": {"outline": True}, "features": {"points": 60},
    "candidates": {"method": "help"}, "min_points": {"method": "help"}, "percentiles": {"method": "help"},
    "entropy_radius": {"method": "help"}, "diffusion_iterations": {"method": "help"},
    "diffusion_kappa": {"method": "help"}, "diffusion_gamma": {"method": "help"},
}


def arguments(options):
    for name, value in options.items():
        text = ",".join(map(str, value)) if isinstance(value, tuple) else str(value)
        name = "--" + name.replace("_", "-")
        yield name if value is True else f"{name}={text}"


def program(*words):
    subprocess.run([*PROGRAM, *map(str, words)], check=True, timeout=300)


def value_of(name):
    """A value for option ``name``: the one above, or for a new option one that its kind can have."""
    if name in LOOKS:
        return LOOKS[name]
    _, _, kind, choices, _ = next(option for option in polyreel._polyreel.described() if option[0] == name)
    if choices:
        return choices[-1]
    return {"flag": True, "int": 5, "float": 0.7, "colour": "#804020"}.get(kind)


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clip")
    save_frames(folder, 3)
    return folder


@pytest.mark.parametrize("name", polyreel.options(look=True))
def test_a_clip_has_the_bytes_of_the_command_line(clip, tmp_path, name):
    value = value_of(name)
    if value is None:
        pytest.skip("give a value for this option in LOOKS")
    options = {**WITH.get(name, {}), name: value}
    program("render", clip / "in_%d.png", "-o", tmp_path / "out_%d.png", "-q", *arguments(options))
    files = sorted(tmp_path.glob("out_*.png"))
    renderer = polyreel.Renderer(**options)
    assert len(files) == 3
    for i, file in enumerate(files):
        expected = np.asarray(Image.open(file).convert("RGB"))
        assert np.array_equal(renderer.render(picture(i)), expected), (options, i)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("preset", [None, *polyreel.presets()])
def test_a_still_has_the_bytes_of_the_command_line(tmp_path, channels, preset):
    source = picture(2, channels)
    Image.fromarray(source).save(tmp_path / "in.png")
    options = {} if preset is None else {"preset": preset}
    program("render", tmp_path / "in.png", "-o", tmp_path / "out.png", "-q", *arguments(options))
    program("render", tmp_path / "in.png", "-o", tmp_path / "out.svg", "-q", *arguments(options))
    expected = Image.open(tmp_path / "out.png").convert("RGBA" if channels == 4 else "RGB")
    assert np.array_equal(polyreel.render(source, **options), np.asarray(expected))
    assert polyreel.triangulate(source, **options).svg("in") == (tmp_path / "out.svg").read_text()


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("out.y4m", {}),
        ("out.gif", {"points": 60, "loop": True}),
        ("out.polyreel", {"points": 60}),
        ("out.usda", {"points": 60}),
        ("out.y4m", {"scale": 2, "start": 0.04, "outline": "white", "preset": "fine"}),
        ("out.y4m", {"max_size": 50, "fps": "24000/1001", "frames": 2, "threads": 1}),
        ("out.png", {"frames": 1, "background": (10, 20, 30)}),
    ],
)
def test_a_file_has_the_bytes_of_the_command_line(clip, tmp_path, name, options):
    program("render", clip / "in_%d.png", "-o", tmp_path / name, "-q", *arguments({
        **options, **({"background": "#0a141e"} if "background" in options else {})
    }))
    (tmp_path / "python").mkdir()
    polyreel.render_file(clip / "in_%d.png", tmp_path / "python" / name, **options)
    assert (tmp_path / "python" / name).read_bytes() == (tmp_path / name).read_bytes()
