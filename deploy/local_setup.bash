# Lets `ros2 run rsrs robot_node` and `ros2 launch rsrs …` find the prefix in which this file is:
#     source /usr/share/rsrs/local_setup.bash
rsrs_prefix=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
case ":${AMENT_PREFIX_PATH:-}:" in
    *":$rsrs_prefix:"*) ;;
    *) export AMENT_PREFIX_PATH="$rsrs_prefix${AMENT_PREFIX_PATH:+:$AMENT_PREFIX_PATH}" ;;
esac
unset rsrs_prefix
