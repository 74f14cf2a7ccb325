#!/bin/bash
#SBATCH --job-name=polyreel
#SBATCH --requeue
#SBATCH --open-mode=append
# A film in parts as an array of SLURM jobs, and a job that joins them:
#
#   polyreel plan film.mp4 -o film.plan.json
#   farm/slurm.sh film.plan.json lowpoly.mp4 [options of sbatch, such as --cpus-per-task=4]
#
# The folder of the plan and the film must be seen by all nodes. A job that was lost is queued again; to run those
# that failed, run the same command: parts that are complete are left alone.
set -euo pipefail
polyreel=${POLYREEL:-polyreel}

if [[ -n ${SLURM_ARRAY_TASK_ID:-} ]]; then
    exec "$polyreel" render --plan "$1" --chunk env:SLURM_ARRAY_TASK_ID --threads "${SLURM_CPUS_PER_TASK:-2}"
fi
if [[ $# -lt 2 ]]; then
    echo "usage: $0 PLAN.json OUTPUT [options of sbatch]" >&2
    exit 2
fi
plan=$(realpath "$1") output=$(realpath "$2")
shift 2
last=$(($(grep -c '^{"chunk":' "$plan") - 1))
array=$(sbatch --parsable --array="0-$last" "$@" "$0" "$plan" "$output")
sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes "$@" --job-name=polyreel-join \
    --wrap="$(printf '%q ' "$polyreel" join "$plan" -o "$output" -y)"
