//! `robot_node`, for `ros2 run` and launch files.

fn main() -> anyhow::Result<()> {
    rsrs_robot_node::main(&std::env::args().skip(1).collect::<Vec<_>>())
}
