#!/usr/bin/env bash
# Counts the kernel's instructions per agent-step, for nine Flockbots, and prints a Markdown table:
#
#     benches/instructions.sh
#
# Needs valgrind, which does not support AVX-512. Counts are differences between two runs of different
# length, so what a program does once is not in them; they do not depend on the load.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
cargo build --release --quiet -p rsrs_benches --example instructions

# Instructions of a run: unit, part, replicates, duration in seconds.
count() {
    local out
    out=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null \
        "$target/release/examples/instructions" "$@" 2>&1)
    awk '/Collected/ { print $4 }' <<<"$out"
}

# Steps of a run of 150 s and of one of 300 s.
short=1153 long=2307 robots=9

echo '| unit | part | per step of a run | per step, whole replicates |'
echo '|---|---|---:|---:|'
for unit in portable avx2; do
    for part in step judge; do
        few=$(count $unit $part 80 300)
        many=$(count $unit $part 160 300)
        brief=$(count $unit $part 160 150)
        awk -v unit=$unit -v part=$part -v few="$few" -v many="$many" -v brief="$brief" \
            -v short=$short -v long=$long -v robots=$robots 'BEGIN {
                printf "| %s | %s | %.1f | %.1f |\n", unit, part,
                    (many - brief) / (160 * robots * (long - short)),
                    (many - few) / (80 * robots * long)
            }'
    done
done
