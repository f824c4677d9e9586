#!/usr/bin/env bash
# Measures what a fleet and its bags cost, and prints it as Markdown:
#
#     benches/fleet.sh [MEGABYTES]
#
# MEGABYTES is the size of the bags (1000 if it is not given). Everything that speaks DDS does so in a
# network of its own; the robots stop when a machine that is busy with something else starves them.
set -euo pipefail
cd "$(dirname "$0")/.."

megabytes=${1:-1000}
target=${CARGO_TARGET_DIR:-target}
cargo build --release --quiet -p rsrs
cargo build --release --quiet -p rsrs_robot_node --example latency
cargo build --release --quiet -p rsrs_sim_node --example scale
cargo build --release --quiet -p rsrs_bags --example bag_throughput
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# What a program printed, under the line that runs it.
quote() {
    echo '```text'
    echo "$1"
    echo '```'
    echo
}

model=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | head -n 1)
echo "$(nproc) cores of $model, $(rustc --version | cut -d' ' -f1-2)"
echo
echo 'From a detection to the wheels, on one host:'
echo
quote "$("$target/release/examples/latency" 30)"

echo 'One simulator with many robots, everybody else in another process:'
echo
for scale in '100 real_time 30' '300 lockstep 30'; do
    # shellcheck disable=SC2086 # three arguments
    quote "$("$target/release/examples/scale" $scale 2>/dev/null)"
done

# An experiment with a hundred simulated robots.
cp -r launch_configs/profiles launch_configs/fleets launch_configs/experiments "$folder"
experiment=$folder/experiments/flockbot_milling.yaml
sed -i -e 's/robots: 9}/robots: 100}/' -e 's/radius_m: .*}/radius_m: 2.8}/' \
    -e 's/duration_s: .*/duration_s: 20/' "$experiment"
{
    sed '/^robots:/q' launch_configs/fleets/nine_virtual.yaml
    for robot in {1..100}; do echo "  robot_$robot: {enabled: true, type: flockbot}"; done
} >"$folder/fleets/nine_virtual.yaml"

echo '`rsrs run` with a hundred simulated robots, recorded with all their topics:'
echo
quote "$("$target/release/rsrs" run "$experiment" -o "$folder/run" --format json 2>/dev/null |
    grep -E '"(ending|n_messages|n_lost|preflight_s|parameters_s|real_time_factor)"')"

echo "Bags of $megabytes MB:"
echo
quote "$("$target/release/examples/bag_throughput" "$folder/bags" "$megabytes")"
