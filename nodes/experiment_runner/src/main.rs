//! `experiment_runner`, for `ros2 run` and launch files.

fn main() -> anyhow::Result<()> {
    rsrs_experiment_runner::main(&std::env::args().skip(1).collect::<Vec<_>>())
}
