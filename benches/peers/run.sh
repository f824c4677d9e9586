#!/bin/sh
# Runs this simulator and its peers on the same task in the same run, and prints the machine, their
# rates and ratios, and how long a whole diagram takes, as Markdown:
#
#     benches/peers/run.sh [ROUNDS]
#
# Needs cargo, a crate registry, and a Python of 3.12 or newer with a package index (swarmsim needs
# it); PYTHON names one. VMAS brings PyTorch, whose wheels for Linux bring CUDA: 3 GB, of which nothing is
# used here. Rounds are interleaved, so that a slow minute of the machine hits all.
set -eu

rounds=${1:-3}
here=$(cd "$(dirname "$0")" && pwd)
target=${CARGO_TARGET_DIR:-$here/../../target}
mkdir -p "$target"
target=$(cd "$target" && pwd)

is_new_enough() { "$1" -c 'import sys, venv; sys.exit(sys.version_info < (3, 12))' 2>/dev/null; }

python=
for candidate in "${PYTHON:-}" python3.14 python3.13 python3.12 python3 \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/*/bin/python; do
    if [ -n "$candidate" ] && is_new_enough "$candidate"; then python=$candidate; break; fi
done
if [ -z "$python" ]; then
    echo "error: no Python 3.12 or newer found; name one with PYTHON=..." >&2
    exit 1
fi

venv=$target/.venv-peers
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check \
    'numpy>=2' 'swarmsim==1.2.5' 'vmas==1.5.2' gymnasium pettingzoo 'maturin>=1.9,<2'
export SDL_VIDEODRIVER=dummy PYGAME_HIDE_SUPPORT_PROMPT=1
# One core for each: NumPy's linear algebra would otherwise start threads.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

cd "$here/../.."
CARGO_TARGET_DIR=$target cargo build --release --quiet -p rsrs_benches --example throughput
CARGO_TARGET_DIR=$target/peers cargo build --release --quiet \
    --manifest-path "$here/krabmaga/Cargo.toml"
rm -rf "$target/peers/wheels"
"$venv/bin/maturin" build --release --locked --quiet --manifest-path python/Cargo.toml --out "$target/peers/wheels"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps \
    "$target"/peers/wheels/*.whl

# Isolated, so that nothing that lies beside a script or in the environment can pass for a library
# of the same name.
run_python() { "$venv/bin/python" -I "$@"; }

sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | sort | uniq -c |
    awk '{ n = $1; $1 = ""; printf "%d cores of%s, %s\n\n", n, $0, rustc }' \
        rustc="$(rustc --version | cut -d' ' -f1-2)"

round=0
while [ "$round" -lt "$rounds" ]; do
    "$target/release/examples/throughput"
    "$target/peers/release/krabmaga_mill" 9
    run_python "$here/numpy_batch.py" 9
    run_python "$here/vector_env.py" launch_configs/profiles/flockbot.yaml
    run_python "$here/vmas_mill.py" | grep '^VMAS .*,'
    # swarmsim prints other lines, too.
    run_python "$here/swarmsim_mill.py" 9 | grep '^swarmsim .*,'
    round=$((round + 1))
done >"$target/peers/rates.csv"
run_python "$here/table.py" <"$target/peers/rates.csv"
echo
"$here/../diagram.sh" "$rounds"
