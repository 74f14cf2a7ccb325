"""What the package promises. The program's own pictures are the reference where POLYREEL names it."""

import ast
import gc
import multiprocessing
import os
import pathlib
import pickle
import runpy
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import polyreel

PROGRAM = os.environ.get("POLYREEL")


def picture(shift=0, channels=3, width=96, height=64):
    y, x = np.mgrid[0:height, 0:width]
    bar = ((x + 3 * shift) % 40 < 14).astype(np.uint8)
    out = np.stack([bar * 180 + 40, (2 * y + 20).astype(np.uint8), (x + y).astype(np.uint8)], axis=-1).astype(np.uint8)
    if channels == 4:
        out = np.concatenate([out, np.where(y < 8, 0, 255).astype(np.uint8)[..., None]], axis=-1)
    return np.ascontiguousarray(out)


def frames(count):
    return [picture(i) for i in range(count)]


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("dtype", [np.uint8, np.float16, np.float32, np.float64])
def test_the_same_kind_comes_back(channels, dtype):
    source = picture(channels=channels)
    given = source if dtype == np.uint8 else (source / 255).astype(dtype)
    out = polyreel.render(given, points=80)
    assert out.shape == given.shape and out.dtype == given.dtype
    expected = polyreel.render(source, points=80)
    got = out if dtype == np.uint8 else np.round(out.astype(np.float64) * 255).astype(np.uint8)
    assert np.array_equal(got, expected)


def test_strange_arrays_are_read_rightly():
    source = picture()
    expected = polyreel.render(source, points=80)
    flipped = np.ascontiguousarray(source[::-1, ::-1])[::-1, ::-1]
    assert flipped.strides[0] < 0
    assert np.array_equal(polyreel.render(flipped, points=80), expected)
    wide = np.zeros((64, 192, 3), np.uint8)
    wide[:, ::2] = source
    assert np.array_equal(polyreel.render(wide[:, ::2], points=80), expected)
    source.setflags(write=False)
    assert np.array_equal(polyreel.render(source, points=80), expected)
    swapped = (source / 255).astype(">f4")
    assert polyreel.render(swapped, points=80).dtype == swapped.dtype


@pytest.mark.parametrize(
    ("given", "error"),
    [
        (np.zeros((8, 8), np.uint8), ValueError),
        (np.zeros((8, 8, 2), np.uint8), ValueError),
        (np.zeros((8, 8, 3), np.int32), TypeError),
        (np.full((8, 8, 3), np.nan, np.float32), ValueError),
        (np.zeros((0, 8, 3), np.uint8), polyreel.Error),
        ("picture.png", TypeError),
    ],
)
def test_what_is_no_picture_is_refused(given, error):
    with pytest.raises(error):
        polyreel.render(given)


def test_floats_of_255_are_a_mistake():
    with pytest.raises(ValueError, match="divide by 255"):
        polyreel.render(picture().astype(np.float32))
    overshot = (picture() / 255).astype(np.float32)
    overshot[0, 0] = 1.04
    assert polyreel.render(overshot, points=40).max() <= 1


def test_options_by_the_names_of_the_command_line():
    with pytest.raises(TypeError, match="did you mean 'points'"):
        polyreel.render(picture(), pionts=80)
    with pytest.raises(TypeError, match="render_file alone"):
        polyreel.render(picture(), max_size=80)
    with pytest.raises(polyreel.UsageError, match="coherence is 2"):
        polyreel.Renderer(coherence=2.0)
    with pytest.raises(polyreel.UsageError, match="there is no preset 'blod'"):
        polyreel.Renderer(preset="blod")
    with pytest.raises(polyreel.UsageError, match="cannot be used with"):
        polyreel.Renderer(quality="best", refine=3)
    with pytest.raises(polyreel.UsageError, match="draft, normal, best"):
        polyreel.Renderer(quality="finest")
    with pytest.raises(TypeError, match="points cannot be a bool"):
        polyreel.Renderer(points=True)
    with pytest.raises(TypeError, match="points cannot be a dict"):
        polyreel.Renderer(points={})
    same = polyreel.render(picture(), points=60)
    for options in [{"points": "60"}, {"points": np.int64(60)}, {"outline": False}, {"outline": None}, {"wash": 0.0}]:
        assert np.array_equal(polyreel.render(picture(), **{"points": 60, **options}), same), options
    other = [
        {"points": "2%"}, {"preset": "bold", "points": None}, {"outline": True}, {"quality": "draft"},
        {"outline": "white", "outline_width": 2}, {"outline": (250, 10, 10)}, {"seed": np.int64(7)},
        {"error": "psnr:20"}, {"wash": np.float32(0.5)}, {"thresholds": (0.5, 0.2, 0.1), "method": "hrlp"},
    ]
    for options in other:
        out = polyreel.render(picture(), **{"points": 60, **options})
        assert out.shape == (64, 96, 3) and not np.array_equal(out, same), options
    assert "outline_width" in polyreel.options(look=True) and "bold" in polyreel.presets()
    assert "max_size" in polyreel.options() and "max_size" not in polyreel.options(look=True)


def fields(text):
    """The fields of each class in a file of types, without their descriptions."""
    classes = [node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    return {
        node.name: {f.target.id: ast.unparse(f.annotation) for f in node.body if isinstance(f, ast.AnnAssign)}
        for node in classes
    }


def test_the_types_of_options_are_those_of_the_program():
    # Else: python scripts/write_options.py
    script = runpy.run_path(str(pathlib.Path(__file__).parents[1] / "scripts" / "write_options.py"))
    assert fields(script["TARGET"].read_text(encoding="utf-8")) == fields(script["text"]())


def test_a_stream_is_one_stream():
    source = frames(12)
    one = polyreel.Renderer(points=80)
    expected = [one.render(frame) for frame in source]
    assert one.stats["kept"] + one.stats["moved"] > 0 and not one.stats["cut"]
    got = list(polyreel.Renderer(points=80).stream(iter(source)))
    assert len(got) == 12 and all(np.array_equal(a, b) for a, b in zip(got, expected))
    batch = polyreel.render_batch(np.stack(source), points=80)
    assert np.array_equal(batch, np.stack(expected))
    moved = np.stack(source).transpose(0, 3, 1, 2)
    assert np.array_equal(polyreel.render_batch(moved, layout="BCHW", points=80), batch.transpose(0, 3, 1, 2))
    pieces = polyreel.Renderer(points=80)
    joined = [polyreel.render_batch(np.stack(source[at : at + 5]), renderer=pieces) for at in range(0, 12, 5)]
    assert np.array_equal(np.concatenate(joined), np.stack(expected))
    one.reset()
    assert one.stats is None and np.array_equal(one.render(source[0]), expected[0])


def test_retune_keeps_the_stream():
    renderer = polyreel.Renderer(points=80)
    renderer.render(picture(0))
    renderer.retune(saturation=0.0)
    grey = renderer.render(picture(0))
    assert renderer.stats["kept"] > 0 and np.ptp(grey.astype(int), axis=-1).max() <= 1


def test_a_stream_tells_how_its_frames_came_to_be():
    renderer = polyreel.Renderer(points=80)
    seen = [(renderer.stats["kept"] + renderer.stats["moved"], renderer.stats["seeds"]) for _ in renderer.stream(frames(6))]
    one = polyreel.Renderer(points=80)
    expected = []
    for frame in frames(6):
        one.render(frame)
        expected.append((one.stats["kept"] + one.stats["moved"], one.stats["seeds"]))
    assert seen == expected and renderer.stats["milliseconds"] > 0


def test_retune_reaches_a_stream():
    renderer = polyreel.Renderer(points=80)
    out = []
    for picture_ in renderer.stream(frames(40)):
        out.append(np.ptp(picture_.astype(int), axis=-1).max())
        renderer.retune(saturation=0.0)
    assert out[0] > 50 and out[-1] <= 1


def test_a_size_that_changes():
    renderer = polyreel.Renderer(points=40)
    renderer.render(picture())
    assert renderer.render(picture(width=50)).shape == (64, 50, 3)
    with pytest.raises(polyreel.Error, match="one size"):
        list(polyreel.Renderer(points=40).stream([picture(), picture(width=50)]))


def test_no_frames_at_all():
    assert list(polyreel.Renderer().stream([])) == []
    assert polyreel.render_batch(np.zeros((0, 8, 8, 3), np.uint8)).shape == (0, 8, 8, 3)


def test_an_exception_of_the_iterator_comes_out():
    def broken():
        yield picture()
        raise OSError("the camera is gone")

    with pytest.raises(OSError, match="camera"):
        list(polyreel.Renderer(points=40).stream(broken()))


def test_progress_may_cancel():
    calls = []

    def progress(done, total):
        calls.append((done, total))
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        polyreel.render_batch(np.stack(frames(8)), points=40, progress=progress)
    assert calls == [(1, 8), (2, 8), (3, 8)]


def test_threads_take_turns():
    renderer = polyreel.Renderer(points=40)
    failures = []

    def work():
        try:
            for frame in frames(5):
                renderer.render(frame)
        except Exception as error:  # noqa: BLE001
            failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join(60) for thread in threads]
    assert not failures and not any(thread.is_alive() for thread in threads)


def test_renderers_can_be_pickled_without_their_frames():
    renderer = pickle.loads(pickle.dumps(polyreel.Renderer(points=40)))
    assert np.array_equal(renderer.render(picture()), polyreel.Renderer(points=40).render(picture()))


def test_two_threads_cannot_pull_one_stream():
    began, go = threading.Event(), threading.Event()

    def slow():
        yield picture(0)
        began.set()
        go.wait(60)
        yield picture(1)

    native = polyreel.Renderer(points=40)._native.stream(slow())
    thread = threading.Thread(target=lambda: list(native))
    thread.start()
    began.wait(60)
    with pytest.raises(RuntimeError, match="borrowed"):
        next(native)
    go.set()
    thread.join(60)
    assert not thread.is_alive()


def interrupt_in(seconds):
    # A shell starts what runs in its background with the signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    return timer


def test_ctrl_c_ends_a_long_still():
    large = np.random.default_rng(1).integers(0, 256, (1200, 1600, 3), np.uint8)
    renderer = polyreel.Renderer(points=20000, refine=1000)
    began = time.monotonic()
    interrupt_in(0.5)
    with pytest.raises(KeyboardInterrupt):
        renderer.render(large)
    assert time.monotonic() - began < 60
    renderer.retune(refine=0)
    assert renderer.render(picture()).shape == (64, 96, 3)


def test_ctrl_c_ends_a_stream():
    def endless():
        number = 0
        while True:
            yield picture(number, width=640, height=480)
            number += 1

    interrupt_in(0.5)
    with pytest.raises(KeyboardInterrupt):
        for _ in polyreel.Renderer(points=400).stream(endless()):
            pass


def in_child(queue):
    queue.put(polyreel.render(picture(), points=40).sum())
    queue.put(sum(int(out.sum()) for out in polyreel.Renderer(points=40).stream(frames(4))))


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes(method):
    expected = [polyreel.render(picture(), points=40).sum()]
    expected.append(sum(int(out.sum()) for out in polyreel.Renderer(points=40).stream(frames(4))))
    context = multiprocessing.get_context(method)
    queue = context.Queue()
    child = context.Process(target=in_child, args=(queue,))
    child.start()
    assert [queue.get(timeout=120), queue.get(timeout=120)] == expected
    child.join(60)
    assert child.exitcode == 0


@pytest.mark.parametrize(
    "code",
    [
        "stream = polyreel.Renderer(points=40).stream(itertools.cycle([picture]))\nnext(stream)",
        "threading.Thread(target=polyreel.render, args=(picture,), kwargs={'refine': 1000}, daemon=True).start()",
        "stream = polyreel.Renderer(points=40).stream(itertools.cycle([picture]))\nnext(stream)\nsys.exit(0)",
    ],
)
def test_the_interpreter_may_end_at_any_time(code):
    head = "import itertools, sys, threading, numpy, polyreel\npicture = numpy.zeros((300, 400, 3), 'u1')\n"
    subprocess.run([sys.executable, "-c", head + code], check=True, timeout=120)


def test_errors_can_be_pickled():
    with pytest.raises(polyreel.UsageError) as raised:
        polyreel.Renderer(coherence=2.0)
    again = pickle.loads(pickle.dumps(raised.value))
    assert type(again) is polyreel.UsageError and str(again) == str(raised.value)


def test_a_mesh_is_arrays(tmp_path):
    mesh = polyreel.triangulate(picture(), points=40)
    assert mesh.size == (96, 64) and mesh.vertices.shape == (44, 2) and mesh.vertices.dtype == np.float64
    assert mesh.triangles.shape[1] == 3 and mesh.triangles.max() < 44
    assert mesh.colors.shape == (len(mesh.triangles), 4) and len(mesh.ids) == 44
    assert mesh.vertices is mesh.vertices and not mesh.vertices.flags.writeable
    corners = mesh.vertices[mesh.triangles]
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]).sum() / 2
    assert area == pytest.approx(96 * 64)
    assert mesh.svg().startswith("<svg") and "<title>a &amp; b</title>" in mesh.svg("a & b")
    with pytest.raises(polyreel.UsageError, match="underlap, stroke, none"):
        mesh.svg(seams="glue")
    for name in ["a.svg", "a.usda", "a.polyreel", "a.png"]:
        mesh.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100
    assert (tmp_path / "a.svg").read_text() == mesh.svg()
    with pytest.raises(polyreel.OutputError, match="exists already"):
        mesh.save(tmp_path / "a.svg")
    mesh.save(tmp_path / "a.png", scale=2, overwrite=True)
    assert polyreel.probe(tmp_path / "a.png")["size"] == {"width": 192, "height": 128}
    assert "44 vertices" in repr(mesh)


def test_pil_images_come_back_as_images():
    Image = pytest.importorskip("PIL.Image")
    out = polyreel.render(Image.fromarray(picture()), points=40)
    assert out.mode == "RGB" and np.array_equal(np.asarray(out), polyreel.render(picture(), points=40))
    assert polyreel.render(Image.fromarray(picture(channels=4)), points=40).mode == "RGBA"
    assert polyreel.render(Image.fromarray(picture()).convert("P"), points=40).mode == "RGB"


def test_many_renderers_leak_nothing():
    def resident():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * 4096

    small = picture(width=32, height=24)

    def round_trip(count):
        for _ in range(count):
            polyreel.Renderer(points=10).render(small)

    round_trip(200)
    gc.collect()
    before = resident()
    round_trip(1000)
    gc.collect()
    assert resident() - before < 20e6


def save_frames(folder, count, channels=3, width=96):
    Image = pytest.importorskip("PIL.Image")
    for i in range(count):
        Image.fromarray(picture(i, channels, width)).save(folder / f"in_{i}.png")


def test_files(tmp_path):
    save_frames(tmp_path, 4)
    calls, looks = [], []
    done = polyreel.render_file(
        tmp_path / "in_%d.png", tmp_path / "out.gif", points=60, progress=lambda *at: calls.append(at),
        preview=looks.append,
    )
    assert done["frames"] == 4 and done["size"] == (96, 64) and calls == [(i, 4) for i in range(1, 5)]
    assert looks[0].shape == (64, 96, 3)
    info = polyreel.probe(tmp_path / "out.gif")
    assert info["frames"] == 4 and info["size"] == {"width": 96, "height": 64}
    with pytest.raises(polyreel.OutputError, match="exists already"):
        polyreel.render_file(tmp_path / "in_0.png", tmp_path / "out.gif")
    with pytest.raises(polyreel.InputError, match="none.png"):
        polyreel.render_file(tmp_path / "none.png", tmp_path / "out.png")
    with pytest.raises(TypeError, match="did you mean 'overwrite'"):
        polyreel.render_file(tmp_path / "in_0.png", tmp_path / "o.png", overwrit=True)
    with pytest.raises(polyreel.UsageError, match="is not a time"):
        polyreel.render_file(tmp_path / "in_%d.png", tmp_path / "p.gif", start="soon")


@pytest.mark.parametrize("failing", ["progress", "preview"])
def test_a_cancelled_file_leaves_nothing(tmp_path, failing):
    save_frames(tmp_path, 12)
    before = sorted(tmp_path.iterdir())

    def fails(*_):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        polyreel.render_file(tmp_path / "in_%d.png", tmp_path / "out.gif", **{failing: fails})
    assert sorted(tmp_path.iterdir()) == before


def test_the_program_is_installed(tmp_path):
    save_frames(tmp_path, 1)
    run = [sys.executable, "-m", "polyreel", "render", tmp_path / "in_0.png", "-o", tmp_path / "out.png", "-q"]
    subprocess.run([*run, "--points", "40"], check=True, timeout=120)
    Image = pytest.importorskip("PIL.Image")
    out = np.asarray(Image.open(tmp_path / "out.png").convert("RGB"))
    assert np.array_equal(out, polyreel.render(picture(), points=40))
    wrong = subprocess.run([*run, "--pionts", "40"], capture_output=True, text=True, timeout=120)
    assert wrong.returncode == 2 and "--points" in wrong.stderr


def test_the_page_draws_without_gradio():
    from polyreel import app

    drawn, files = app.draw(picture(), "bold", 60, 1.2, False, True)
    assert drawn == files[0] and [os.path.splitext(file)[1] for file in files] == [".png", ".svg"]
    assert app.draw(None, "low-poly", 0, 1.0, False, False) == (None, [])


def test_the_page_leaves_the_preset_what_is_left_alone():
    from polyreel import app

    Image = pytest.importorskip("PIL.Image")
    rgba = np.dstack([picture(), np.full((64, 96, 1), 255, np.uint8)])
    rgba[:20, :20, 3] = 0
    drawn, _ = app.draw(rgba, "stained-glass", 0, 1.0, False, True)
    assert np.array_equal(np.asarray(Image.open(drawn)), polyreel.render(rgba, preset="stained-glass"))


def test_torch_tensors_come_back_as_tensors():
    torch = pytest.importorskip("torch")
    source = torch.from_numpy(picture())
    expected = polyreel.render(picture(), points=40)
    out = polyreel.render(source, points=40)
    assert isinstance(out, torch.Tensor) and out.dtype == torch.uint8 and np.array_equal(out.numpy(), expected)
    for dtype in [torch.float32, torch.float64, torch.float16, torch.bfloat16]:
        out = polyreel.render((source / 255).to(dtype).requires_grad_(), points=40)
        assert out.dtype == dtype and out.shape == source.shape and not out.requires_grad
    clip = torch.stack([torch.from_numpy(frame) for frame in frames(3)]).permute(0, 3, 1, 2) / 255
    out = polyreel.render_batch(clip, layout="BCHW", points=40)
    assert out.shape == clip.shape and out.dtype == clip.dtype
    with pytest.raises(TypeError, match="meta: move it"):
        polyreel.render(torch.empty((8, 8, 3), device="meta"))


def test_dlpack_and_array_are_read():
    class Array:
        def __array__(self, dtype=None, copy=None):
            return picture()

    class Capsule:
        def __init__(self):
            self.inner = picture()

        def __dlpack__(self, **options):
            return self.inner.__dlpack__(**options)

        def __dlpack_device__(self):
            return self.inner.__dlpack_device__()

    expected = polyreel.render(picture(), points=40)
    assert np.array_equal(polyreel.render(Array(), points=40), expected)
    assert np.array_equal(polyreel.render(Capsule(), points=40), expected)
