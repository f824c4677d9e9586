#!/usr/bin/env bash
# Prints the section of docs/BENCHMARKS.md on what DDS Security costs, in about a minute; the machine
# should have nothing else to do.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo run --quiet --release -p rsrs_ros --features security --example secured_costs -- "${1:-10}"
