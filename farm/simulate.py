#!/usr/bin/env python3
"""How the wall time of a film falls with machines, and where that ends.

    farm/simulate.py [PLAN.json ...] -o docs/films.svg

Chunks are formed as `polyreel plan` forms them, and given to machines as engines do: the longest first, the next to
whoever is free. A film is a plan, or one of 100 minutes whose shots have log-normal lengths with a standard deviation
of 1.2 times their mean, as Barry Salt found in films: a mean of 4 s today, of 2 s in action films, of 9 s in the
1940s. Times are those of docs/films.md; all can be set. The result is the same every time.
"""
import argparse
import heapq
import json
import math
import random

MACHINES = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512]


def log_normal(minutes, mean, rate, seed=1):
    """Frames of shots that last `mean` seconds on average."""
    chance, frames = random.Random(seed), []
    sigma = math.sqrt(math.log(1 + 1.2**2))
    mu = math.log(mean) - sigma * sigma / 2
    while sum(frames) < minutes * 60 * rate:
        frames.append(max(1, round(chance.lognormvariate(mu, sigma) * rate)))
    return frames


def chunks(shots, most, split):
    """As in src/film/survey.rs."""
    made, warm = [], 0
    for shot in shots:
        if split and shot > most:
            pieces = math.ceil(shot / most)
            made += [most] + [most + split] * (pieces - 2) + [shot - most * (pieces - 1) + split]
            warm = 0
            continue
        if made and warm and warm + shot <= most:
            made[-1] += shot
            warm += shot
        else:
            made.append(shot)
            warm = shot
    return made


def wall(parts, machines, args, frames):
    """Seconds to plan, render and join."""
    free = [0.0] * machines
    for part in sorted(parts, reverse=True):
        heapq.heappush(free, heapq.heappop(free) + args.start + part / args.fps)
    # All machines read the film through one storage, each from the key frame before its part.
    read = (frames + len(parts) * args.lead) * args.frame_bytes / args.storage
    return frames / args.plan_fps, max(max(free), read), frames / args.join_fps


def curve(name, shots, args, split=0):
    frames, parts = sum(shots), chunks(shots, args.max_frames, split)
    rows = []
    for machines in MACHINES:
        plan, render, join = wall(parts, machines, args, frames)
        rows.append((machines, plan, render, join))
    alone = frames / args.fps
    longest = max(parts)
    print(f"{name}: {frames} frames, {len(shots)} shots, {len(parts)} chunks, the longest of {longest} frames; "
          f"one machine without parts {alone / 60:.1f} min")
    for machines, plan, render, join in rows:
        total = plan + render + join
        print(f"  {machines:4} machines: {total / 60:7.1f} min = plan {plan / 60:.1f} + render {render / 60:.1f} "
              f"+ join {join / 60:.1f}; {alone / total:5.1f} times as fast, the render alone {alone / render:.1f}")
    return name, alone, rows


def plot(curves, path):
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "films"
    from matplotlib import pyplot
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 4.2))
    for name, alone, rows in curves:
        machines = [row[0] for row in rows]
        left.plot(machines, [alone / row[2] for row in rows], label=name)
        right.plot(machines, [alone / sum(row[1:]) for row in rows], label=name)
    for axes, title in ((left, "render alone"), (right, "plan, render and join")):
        axes.plot(MACHINES, MACHINES, color="0.7", linestyle=":", label="as many times as machines")
        axes.set(xscale="log", yscale="log", xlabel="machines", ylabel="times as fast as one", title=title)
        axes.set_xticks([1, 4, 16, 64, 256], [1, 4, 16, 64, 256])
        axes.set_yticks([1, 4, 16, 64, 256], [1, 4, 16, 64, 256])
        axes.minorticks_off()
        axes.grid(alpha=0.3)
    left.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plans", nargs="*", help="plans of films, whose shots are taken")
    parser.add_argument("-o", "--output", help="the plot, as SVG")
    parser.add_argument("--max-frames", type=int, default=240)
    parser.add_argument("--warm-up", type=int, default=8)
    parser.add_argument("--fps", type=float, default=40, help="frames a second that a machine renders")
    parser.add_argument("--plan-fps", type=float, default=250, help="that the plan looks through")
    parser.add_argument("--join-fps", type=float, default=120, help="that the join paints and encodes")
    parser.add_argument("--start", type=float, default=0.8, help="seconds to start a chunk and to find its place")
    parser.add_argument("--frame-bytes", type=float, default=20e3, help="bytes of a frame of the film")
    parser.add_argument("--lead", type=float, default=100, help="frames read before a chunk begins")
    parser.add_argument("--storage", type=float, default=100e6, help="bytes a second that the storage gives to all")
    args = parser.parse_args()
    films = []
    for path in args.plans:
        with open(path) as file:
            films.append((path, [shot["frames"] for shot in json.load(file)["shots"]], 0))
    if not films:
        slow = log_normal(100, 9, 24)
        films = [("shots of 2 s (action)", log_normal(100, 2, 24), 0), ("shots of 4 s (today)", log_normal(100, 4, 24), 0),
                 ("shots of 9 s (1940s)", slow, 0), ("shots of 9 s, long ones split", slow, args.warm_up),
                 ("one shot of 100 min", [144000], 0)]
    curves = [curve(name, shots, args, split) for name, shots, split in films]
    if args.output:
        plot(curves, args.output)


if __name__ == "__main__":
    main()
