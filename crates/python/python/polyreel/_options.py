"""The options of the command line as types. Written by scripts/write_options.py; do not edit."""

from __future__ import annotations

from os import PathLike
from typing import Literal, TypedDict

Colour = str | bool | tuple[int, int, int] | tuple[int, int, int, int]
Text = str | int | float | PathLike[str] | tuple[float, ...] | tuple[str, ...]
Path = str | PathLike[str]


class LookOptions(TypedDict, total=False):
    """What decides how a picture looks."""

    preset: Text | None
    """Begin with the settings of a preset (see 'polyreel presets') or of a preset file; options given with it win
    [default: none]"""
    study: Text | None
    """Begin with the settings of an earlier system: gai-2015, zhang-2016, qian-2016, uasmith-2017, ma-2017,
    ng-2017, lawonn-2018, pic2polyart-2021, laske-2024, joseph-entropy-2024, joseph-region-2024, or the paper's
    hrlp, help, hslp; options given with it win [default: none]"""
    method: Literal["hrlp", "help", "hslp", "rlp", "entropy", "pic2polyart", "ranked", "thinning", "stippling"] | None
    """How feature points and seeds are found [default: hrlp]"""
    points: Text | None
    """Seeds of a frame: a count (2000), a count that is the same at any size but for sprites, which have fewer
    (1200@1MP), a share of its pixels (1.5%), or auto: as many as the picture asks for, by how its error falls,
    followed slowly over the frames of a shot; with --error the fewest, to 2 %, that reach it on the first frame
    [default: 1200@1MP]"""
    seed: int | None
    """Decides all chance: the same seed gives the same bytes [default: 0]"""
    coherence: float | None
    """How firmly a frame holds to the one before, 0 (each frame alone) to 1 (least flicker) [default: 0.4]"""
    quality: Literal["auto", "draft", "normal", "best"] | None
    """How much work goes into refinement: none, most of the gain, all of it; auto is best for a still, normal for
    a film [default: auto]"""
    refine: int | None
    """Steps of refinement in place of --quality: of a still, and of each frame of an animation, the first of a
    shot getting a few more [default: as --quality]"""
    error: Text | None
    """Refine a still, and the first frame of a shot, until it is as like its source as this, in place of a number
    of steps: psnr:30 or 30dB (over RGB), ssim:0.8 (of the luma, window of 7x7); where that is out of reach, a
    warning is given [default: none]"""
    regularity: float | None
    """How much well-shaped triangles count against the error, 0 (not at all) to 1 (only they do) [default: 0.5]"""
    min_facet: Text | None
    """Side of the smallest facets, in pixels or as a share of the picture's shorter side (2%), as of equilateral
    triangles: refinement keeps to it, but for a few in a hundred [default: none]"""
    max_facet: Text | None
    """Side of the largest facets [default: none]"""
    edges: Literal["smooth", "hard"] | None
    """How triangles meet: smooth, a step spread over two pixels, or hard; GIFs always have hard edges [default:
    smooth]"""
    outline: Colour | None
    """Draw the edges of the mesh, in black or in COLOUR (white, #802040, or darker or lighter: tints of the facets
    beside it); the other options of the outline draw them, too [default: none]"""
    outline_width: Text | None
    """Width of the outline: pixels (2, 2px), or a share of the picture's shorter side (0.3%) [default: 1]"""
    outline_contrast: int | None
    """Draw the outline the stronger the more colours differ, half as strong where they do by N of 255; 0 draws all
    of it alike [default: 0]"""
    outline_opacity: float | None
    """How opaque the outline is, 0 to 1 [default: 1]"""
    outline_tint: float | None
    """How much of the outline's colour is that of the facets beside it, 0 to 1: --outline=white --outline-tint 0.6
    is a lighter tint of each [default: 0]"""
    saturation: float | None
    """How strong colours are, 0 (grey) to 4 [default: 1]"""
    wash: float | None
    """How far colours are washed out as by water, 0 (not at all) to 1 (white); black stays [default: 0]"""
    fill: Literal["mean", "median", "centroid", "linear", "gouraud", "none"] | None
    """What triangles are filled with: their mean or median colour, that at their centroid, a plane of colour
    (linear), colours that go on over edges (gouraud), or none: lines on transparency [default: mean]"""
    contrast: float | None
    """How far light and dark lie apart, 0 to 4, in steps that look equal [default: 1]"""
    chroma: float | None
    """As --saturation, but lightness and hue stay: skin does not burn [default: 1]"""
    duotone: Text | None
    """Print in two tones: colours in place of black and white (navy,#ffe8c0) [default: none]"""
    palette: Text | None
    """The colours that the picture may have: a number of them, learned from the first frame and kept; a list
    (#102030,gold,white); or a file of them, .gpl or .hex [default: none]"""
    shape: Literal["triangles", "polygons", "voronoi"] | None
    """What is filled and outlined together: triangles, polygons (panes of like colour), or the cells of a Voronoi
    diagram [default: triangles]"""
    focus: Text | None
    """Where the picture gets more and smaller facets: faces, or saliency, found in every frame; X,Y,R, a place and
    a radius (50%,40%,20%, or pixels); or MASK, a picture that is light there [default: none]"""
    smoothing: int | None
    """How often a frame is smoothed before its colours are clustered, 0 to 8 (in the paper 0) [default: 2]"""
    clusters: int | None
    """Colour clusters of the regions, 2 to 64 [default: 8]"""
    interval: int | None
    """Every how many pixels of a region's boundary one is a feature point, 1 to 64 [default: 3]"""
    interior: float | None
    """Share of the pixels inside regions that are feature points, 0 to 1 [default: 0.001]"""
    hex_density: float | None
    """Area of a grid cell as a share of the frame's, in place of --points [default: solved from --points]"""
    max_points: int | None
    """Points that the densest cells keep, 1 to 64 [default: 4]"""
    default_points: int | None
    """Points that the sparsest cells keep, 0 to --max-points [default: 1]"""
    thresholds: Text | None
    """Feature points per pixel above which a cell counts as of high, medium, low density [default: 0.2,0.1,0.02]"""
    features: Literal["sobel", "laplacian", "canny", "slic", "regions", "entropy", "saliency", "edge-drawing", "contours", "salient-edges"] | None
    """Where feature points come from, for any method [default: the method's own]"""
    prefilter: Literal["blur", "sharpen", "bilateral"] | None
    """What a frame goes through before features are looked for: a blur, sharpening, or the bilateral filter
    [default: none]"""
    scatter: float | None
    """Share of the seeds that lie anywhere, at random, 0 to 1 [default: 0]"""
    candidates: float | None
    """Share of the pixels that a map (entropy, saliency, sobel, laplacian) or slic makes feature points, up to 1
    [default: 0.054]"""
    min_points: int | None
    """Points that every cell gets before the rest is shared out by value (help, hslp), 0 to 64 [default: 1]"""
    percentiles: Text | None
    """Percentiles of the cells' mean value that tell high, medium and low cells (help, hslp) [default: 75,25]"""
    entropy_radius: int | None
    """Radius of the disk of the entropy, 1 to 32 [default: 5]"""
    diffusion_iterations: int | None
    """Steps of the anisotropic diffusion before the entropy, 0 to 1000 [default: 10]"""
    diffusion_kappa: float | None
    """Differences of luma above which the diffusion takes them for edges, up to 1000 [default: 50]"""
    diffusion_gamma: float | None
    """Length of a step of the diffusion, up to 0.25 [default: 0.25]"""


class FileOptions(LookOptions, total=False):
    """What ``polyreel.render_file`` takes besides."""

    start: Text | None
    """Leave out what comes before TIME: 1.5, 500ms, 1:30 [default: from the beginning]"""
    end: Text | None
    """Leave out what comes at TIME or later [default: to the end]"""
    frames: int | None
    """Read at most N frames [default: all]"""
    fps: Text | None
    """Frames per second of a sequence of pictures: 12, 29.97, 24000/1001 [default: 25]"""
    max_size: int | None
    """Shrink frames until their longest side has at most PX pixels [default: their own size]"""
    max_memory: int | None
    """Memory that decoding may take: larger pictures are refused; 512M, 4G, or bytes [default: 1G]"""
    allow_truncated: bool | None
    """Keep what can be read of an input that breaks off or is damaged [default: fail]"""
    ffmpeg: Path | None
    """The ffmpeg program that reads and writes video [default: the one on the search path]"""
    overwrite: bool | None
    """Replace an output that is there already"""
    background: Colour | None
    """What shows through transparent pixels in formats that have none, JPEG for one [default: white]"""
    format: Text | None
    """Format of the output, whatever its name: of pictures that go to a folder png, svg, jpg, webp, bmp, tiff; of
    a video an extension (ts, mkv) or a muxer of ffmpeg (mpegts) [default: by the name; in a folder png]"""
    lossy: Text | None
    """Quality of JPEG, and of WebP in place of lossless, 1 to 100 [default: JPEG 90, WebP lossless]"""
    scale: float | None
    """Draw from the mesh at S times the size: 2 is twice as wide, and crisp [default: 1]"""
    sound: Path | None
    """Take the sound from FILE [default: from the input]"""
    svg_seams: Literal["underlap", "stroke", "none"] | None
    """What keeps the ground from showing between the facets of an SVG: facets that reach under each other, a thin
    line around each, or nothing"""
    vertex_grid: Text | None
    """Vertices of .polyreel and .html stand on a grid of N lines a pixel, a power of two: 256 loses nothing, 4
    takes a fifth fewer bytes"""
    colour_error: Text | None
    """Colours of .polyreel and .html may be off by N of 255, 0 to 16: 2 takes a third fewer bytes of a clip"""
    codec: Text | None
    """The codec: h264, h265, vp8, vp9, av1, prores, or an encoder of ffmpeg by its name [default: h264, in .webm
    vp9]"""
    crf: int | None
    """Constant quality in the codec's own measure, smaller is better [default: 18 for h264, what looks alike for
    others]"""
    encoder_preset: Text | None
    """Effort, by x264's names: ultrafast to placebo [default: the encoder's own]"""
    no_audio: bool | None
    """Leave the sound out [default: copied if the container takes it, else encoded again]"""
    no_metadata: bool | None
    """Leave out title, date, chapters, timecode, and languages and titles of tracks [default: kept]"""
    hdr: bool | None
    """Keep HDR as HDR: HEVC or AV1 of 10 bits, with its tags [default: its tones become SDR]"""
    ffmpeg_args: Text | None
    """More options for ffmpeg's output, in one word: '-tune animation -b:a 96k' [default: none]"""
    threads: Text | None
    """Threads that work inside a frame; the bytes are the same for any number [default: one a core; at most 256]"""
    budget: Text | None
    """Time for each frame, 16ms, 0.5s, or auto: as long as a frame of the source is shown. Detail is chosen so
    that every stage keeps within it; spare time goes to refinement, up to --refine [default: none]"""
    replay: Path | None
    """Give every frame the detail that it had in the run of this report: the same bytes again, from the same input
    and options"""
    loop: bool | None
    """Let the end lead into the beginning, for GIFs and clips that play round and round: the input is rendered
    twice, and what is written is the second time, which goes on from the mesh that the first ended with. Files
    only"""
    report: Path | None
    """Write what was done, in sum and for every frame, as JSON; replaces an older report"""
