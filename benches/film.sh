#!/usr/bin/env bash
# Prints what docs/BENCHMARKS.md says of films: one run of 300 s of nine Flockbots, filmed as GIF and
# as animated PNG.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --quiet --release
rsrs="$PWD/target/release/rsrs"
launch_configs="$PWD/launch_configs"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cp "$launch_configs/profiles/flockbot.yaml" .
cat > sweep.yaml <<'SWEEP'
profile: flockbot.yaml
axes:
  speed_m_s: [0.15]
  turn_rate_rad_s: [0.75]
fixed: {robots: 9, placement_radius_m: 0.825, arena_m: 15}
replicates: 1
duration_s: 300
seed: 1
SWEEP
"$rsrs" sweep sweep.yaml -o out > sweep.log 2>&1
"$rsrs" episode out --cell speed_m_s=0.15,turn_rate_rad_s=0.75 --replicate 0 -o run > episode.log
TIMEFORMAT="%R s on the wall, %U s of CPU time"
for film in run.gif run.png; do
    echo -n "$film: "
    { time "$rsrs" film run -o "$film" > film.log 2>&1; } 2>&1
    echo "  $(stat -c %s "$film") bytes"
done
