#!/usr/bin/env python3
"""A film in parts on a Ray cluster, all of whose nodes have `pip install polyreel ray` and see the film.

    farm/ray_film.py film.mp4 lowpoly.mp4 --address auto --store s3://bucket/film -- --preset bold --crf 20

What comes after -- are options of `polyreel plan`. Without --store, parts go to the folder parts/ beside the plan, which
all nodes share. polyreel.distributed.render_film does the work.
"""
import argparse
import sys

from polyreel.distributed import render_film

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("film")
parser.add_argument("output")
parser.add_argument("options", nargs="*")
parser.add_argument("--plan", help="where the plan is, or goes to [default: OUTPUT.plan.json]")
parser.add_argument("--address", help="the cluster [default: this machine]")
parser.add_argument("--store", help="where parts go, as fsspec names it")
parser.add_argument("--cpus", type=int, default=1, help="of a chunk [default: 1]")
args = parser.parse_args()
render_film(
    args.film,
    args.output,
    options=args.options,
    plan=args.plan,
    address=args.address,
    store=args.store,
    cpus=args.cpus,
    progress=lambda there, of: print(f"{there} of {of} chunks are there", file=sys.stderr),
)
