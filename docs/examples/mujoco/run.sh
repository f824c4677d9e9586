#!/usr/bin/env bash
# From nine robots in MuJoCo that nobody has measured to a verdict, with the commands of rsrs only.
#
#   docs/examples/mujoco/run.sh FOLDER [SEED]
#
# FOLDER is made, and holds all that comes out. SEED draws other robots. `rsrs` has to be in PATH, and
# python3 with venv. All of it runs in a network namespace of its own, so that no packet reaches
# robots of yours; RSRS_MUJOCO_INTERFACE names an interface (or address) to use instead.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=${1:?"usage: run.sh FOLDER [SEED]"}
seed=${2:-1}
# Within these the robots are safe, as whoever has built them states.
speed=0.1,0.3
turn_rate=0.4,2.0
radius=0.07
range=0.9

main() {
    if [[ -z "${RSRS_MUJOCO_INSIDE:-}" ]]; then
        prepare
        enter_network
    fi
    cd "$folder"
    export PATH="$PWD/venv/bin:$PATH" ROS_LOG_DIR="$PWD/logs"
    trap end_children EXIT
    start_robots
    measure
    predict
    run_experiments
    conclude
    end_robots
    exit "$verdict"
}

# What needs the network of this computer: packages. The files are copied, so that they can be changed.
prepare() {
    rsrs --version
    mkdir "$folder"
    cp "$here"/*.py "$here"/*.yaml "$folder"
    python3 -m venv "$folder/venv"
    "$folder/venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements.txt"
}

# Goes on in a network namespace in which there is nothing but this script's processes.
enter_network() {
    export RSRS_MUJOCO_INSIDE=1 RSRS_INTERFACE="${RSRS_MUJOCO_INTERFACE:-127.0.0.1}"
    if [[ -n "${RSRS_MUJOCO_INTERFACE:-}" ]]; then
        return
    fi
    unset ROS_AUTOMATIC_DISCOVERY_RANGE ROS_STATIC_PEERS ROS_LOCALHOST_ONLY
    exec unshare --map-root-user --net -- sh -c \
        'ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' \
        "$here/run.sh" "$folder" "$seed"
}

# Shows a command, and runs it.
does() {
    printf '\n[%3d:%02d] $ %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "${*@Q}"
    "$@"
}

children=()
end_children() {
    for child in "${children[@]}"; do
        kill "$child" 2>/dev/null && wait "$child" || true
    done
}

start_robots() {
    python fleet.py fleet.yaml fleet.sock --seed "$seed" >robots.log 2>&1 &
    robots=$!
    children+=("$robots")
    until [[ -S fleet.sock ]]; do
        kill -0 "$robots" 2>/dev/null || { cat robots.log >&2; exit 1; }
        sleep 0.1
    done
}

# What the robots of the second kind have in front of their wheels, each on its own computer.
start_gates() {
    gates=()
    for robot in robot_{6..9}; do
        rsrs node robot --robots "$robot" "$@" -p ros.cmd_vel_type:=twist >"gate_$robot.log" 2>&1 &
        gates+=("$!")
    done
    children+=("${gates[@]}")
    for robot in robot_{6..9}; do
        until grep -q "ready, with a ros driver" "gate_$robot.log"; do sleep 0.1; done
    done
}

# Step 1: trials of three robots, and a profile with an interval on every number. There is no profile yet
# that a fleet file could give to a gate, and `measure drive` is the controller.
measure() {
    start_gates --driver ros --without-controller --ros-args -p period:=0.1 -p detection_threshold:=0.95
    does rsrs measure plan fleet.yaml --robots 3 --speed "$speed" --turn-rate "$turn_rate" \
        --commands 1 --track 0.8 --precision 0.1 --range "$range" --distances 6 --bearings 5 \
        --rate-precision 0.15 -o trials
    # On a busy machine a trial may break off; the same command goes on with the rows that are left.
    for attempt in 1 2 3; do
        does rsrs measure drive fleet.yaml --plan trials --backend fleet \
            --place-command "python place.py fleet.sock" && break
        [[ "$attempt" != 3 ]] || exit 1
    done
    kill "${gates[@]}"
    wait "${gates[@]}" || true
    does rsrs measure fit --plan trials --name mujoco --radius "$radius" -o mujoco.yaml --pictures pictures
}

# Steps 2 and 3: whether the trials lie within reach of the simulated robots, and where these mill. The
# profile was fitted to the same trials: an in-sample check, which shows no more than that nothing is amiss.
predict() {
    does rsrs sweep sweep.yaml -o results
    does rsrs validate results --trajectories trials/bags/{speed,turn,arcs}_* --detection trials/detection.csv ||
        echo "The simulated robot is not worse in all of it; the runs decide."
    does rsrs choose results -o results/choice.json
    does rsrs diagram results -o diagram.png
}

# Step 4: three runs of the chosen cell, each from other starts.
run_experiments() {
    # Their controllers keep to the fastest commands that were tried, as the profile states.
    local limits
    limits=($(python -c 'import yaml; it = yaml.safe_load(open("mujoco.yaml"))["actuation"]
print(it["speed"]["limits_m_s"][1], it["turn"]["limits_rad_s"][1])'))
    rsrs node controller --robots "$(echo robot_{1..5} | tr " " ,)" --ros-args -p lease:=controller \
        -p cmd_vel_type:=twist -p "speed_max:=${limits[0]}" -p "turn_rate_max:=${limits[1]}" \
        >controllers.log 2>&1 &
    children+=("$!")
    # Those behind a gate have a controller of their own in the same process.
    start_gates --config fleet.yaml --ros-args
    for run in 1 2 3; do
        does rsrs place experiment.yaml --seed "$run" -o "start_$run.png"
        does rsrs run experiment.yaml --seed "$run" --backend fleet \
            --place-command "python place.py fleet.sock" -o "run_$run"
        does rsrs label "run_$run"
    done
}

conclude() {
    verdict=0
    does rsrs compare results --bags run_1 run_2 run_3 || verdict=$?
    does rsrs report results --bags run_1 run_2 run_3 -o report.html || verdict=$?
    does rsrs film run_1 -o run_1.gif
}

# Whether the machine kept up with the time on the wall: without that, nothing above counts.
end_robots() {
    kill "$robots"
    wait "$robots" || verdict=1
    printf '\n[%3d:%02d] MuJoCo: %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$(tail -n 1 robots.log)"
}

main
