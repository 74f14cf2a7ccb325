#!/usr/bin/env python3
"""A film in parts on a Ray cluster.

    polyreel plan film.mp4 -o film.plan.json
    farm/ray_film.py film.plan.json lowpoly.mp4 [--store s3://bucket/film] [--address auto]

Every node needs the program `polyreel` (or --polyreel PATH), and the plan and the film where they were planned. Parts
go to the folder parts/ beside the plan, which all nodes share; or, with --store, to any place that fsspec knows, and
from there to the machine that joins. A chunk whose node died is rendered again elsewhere.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import ray


@ray.remote(max_retries=5, retry_exceptions=[subprocess.CalledProcessError])
def render(polyreel, plan, chunk, threads, parts, store):
    with tempfile.TemporaryDirectory() as scratch:
        folder = scratch if store else parts
        if store:
            copy(store, folder, chunk, up=False)
        command = [polyreel, "render", "--quiet", "--plan", plan, "--chunk", str(chunk), "-o", folder]
        subprocess.run([*command, "--threads", str(threads)], check=True)
        if store:
            copy(store, folder, chunk, up=True)
    return chunk


def copy(store, folder, chunk, up):
    """Copies a part between `store` and `folder`, its report last: without that it does not count."""
    import fsspec

    for name in (f"{chunk:04}.polyreel", f"{chunk:04}.json"):
        there, here = fsspec.core.url_to_fs(f"{store}/{name}"), os.path.join(folder, name)
        if up:
            there[0].makedirs(os.path.dirname(there[1]), exist_ok=True)
            there[0].put_file(here, there[1])
        elif there[0].exists(there[1]):
            there[0].get_file(there[1], here)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan")
    parser.add_argument("output")
    parser.add_argument("--store", help="where parts go, as fsspec names it")
    parser.add_argument("--address", help="the cluster [default: this machine]")
    parser.add_argument("--cpus", type=int, default=1, help="of a chunk, and its threads")
    parser.add_argument("--polyreel", default="polyreel")
    args = parser.parse_args()
    plan = os.path.abspath(args.plan)
    parts = os.path.join(os.path.dirname(plan), "parts")
    with open(plan) as file:
        chunks = json.load(file)["chunks"]
    ray.init(address=args.address, log_to_driver=True)
    task = render.options(num_cpus=args.cpus)
    longest_first = sorted(chunks, key=lambda chunk: -chunk["frames"])
    waiting = [task.remote(args.polyreel, plan, c["chunk"], args.cpus, parts, args.store) for c in longest_first]
    while waiting:
        done, waiting = ray.wait(waiting)
        print(f"chunk {ray.get(done[0])} is there, {len(waiting)} to go", file=sys.stderr)
    with tempfile.TemporaryDirectory() as scratch:
        if args.store:
            for chunk in chunks:
                copy(args.store, scratch, chunk["chunk"], up=False)
        folder = scratch if args.store else parts
        subprocess.run([args.polyreel, "join", plan, "--parts", folder, "-o", args.output, "-y"], check=True)


if __name__ == "__main__":
    main()
