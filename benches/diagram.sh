#!/usr/bin/env bash
# Times a whole phase diagram as the command line makes it, judged and with all its files, on one
# thread and on two, and prints a Markdown table:
#
#     benches/diagram.sh [ROUNDS]
#
# RSRS names a program that is built already; otherwise it is built here.
set -euo pipefail
cd "$(dirname "$0")/.."

rounds=${1:-3}
rsrs=${RSRS:-}
if [[ -z $rsrs ]]; then
    cargo build --release --quiet -p rsrs
    rsrs=${CARGO_TARGET_DIR:-target}/release/rsrs
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

TIMEFORMAT='%R %U'
declare -A least_wall_s least_cpu_s
is_less() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a < b) }'; }

# Rounds are interleaved, and of several the fastest counts: others shared the machine with somebody.
for ((round = 0; round < rounds; round++)); do
    for threads in 1 2; do
        log=$folder/log
        took=$({ time "$rsrs" sweep benches/diagram.yaml -o "$folder/result" \
            --threads "$threads" >"$log" 2>&1; } 2>&1) || { cat "$log" >&2; exit 1; }
        rm -r "$folder/result"
        read -r wall_s cpu_s <<<"$took"
        if is_less "$wall_s" "${least_wall_s[$threads]:-inf}"; then least_wall_s[$threads]=$wall_s; fi
        if is_less "$cpu_s" "${least_cpu_s[$threads]:-inf}"; then least_cpu_s[$threads]=$cpu_s; fi
    done
done

echo '| threads | wall time of the diagram | CPU time | to one thread |'
echo '|---:|---:|---:|---:|'
for threads in 1 2; do
    awk -v threads="$threads" -v wall="${least_wall_s[$threads]}" \
        -v cpu="${least_cpu_s[$threads]}" -v one="${least_wall_s[1]}" \
        'BEGIN { printf "| %d | %.2f s | %.2f s | %.2f × |\n", threads, wall, cpu, one / wall }'
done
