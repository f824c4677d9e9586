//! Lists the robots of a fleet file, and the topics of each that an experiment needs.
//!
//! `cargo run -p rsrs_fleet --example robots_of_a_fleet -- launch_configs/fleets/nine_flockbots.yaml`

#![expect(clippy::print_stdout, reason = "prints its result")]

use rsrs_fleet::fleet_file::FleetFile;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("FLEET.yaml")?;
    let fleet = FleetFile::parse(&path, &std::fs::read_to_string(&path)?)?;
    for robot in fleet.robots.iter().filter(|robot| robot.enabled) {
        let (name, pose) = (&robot.name, robot.pose.key());
        println!("/{name}/detection, /{name}/cmd_vel ({:?}), poses by {pose}", robot.cmd_vel);
    }
    Ok(())
}
