#!/bin/bash
# A film in parts by GNU parallel, on this machine or on those of --sshlogin:
#
#   polyreel plan film.mp4 -o film.plan.json
#   farm/parallel.sh film.plan.json lowpoly.mp4 [options of parallel, such as --sshloginfile hosts]
#
# Every chunk is tried three times. Run again, it goes on: what the log of jobs says has failed, or has not been
# tried, is rendered.
set -euo pipefail
if [[ $# -lt 2 ]]; then
    echo "usage: $0 PLAN.json OUTPUT [options of parallel]" >&2
    exit 2
fi
plan=$(realpath "$1") output=$2
shift 2
polyreel=${POLYREEL:-polyreel}

# A log of jobs of another plan says nothing.
[[ ! $plan -nt $plan.jobs ]] || rm -f "$plan.jobs"
last=$(($(grep -c '^{"chunk":' "$plan") - 1))
seq 0 "$last" | parallel --joblog "$plan.jobs" --resume-failed --retries 3 --workdir "$(dirname "$plan")" "$@" \
    "$polyreel" render --quiet --threads "${THREADS:-1}" --plan "$plan" --chunk '{}'
exec "$polyreel" join "$plan" -o "$output" -y
