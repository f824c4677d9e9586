//! The two wheels of a robot, given on the command line.

use rsrs_core::quantity::Axis;
use rsrs_core::robot::wheels::Wheels;
use rsrs_pipeline::init::{check_number, check_wheel_base};

use crate::failure::check_flag;

/// Both or neither.
#[derive(clap::Args)]
pub struct WheelArguments {
    /// Distance of its two wheels, in metres, if it drives on two: a turn while driving asks more of
    /// the outer one, and commands beyond its speed are refused.
    #[arg(long, value_name = "M", requires = "wheel_speed")]
    pub wheel_base: Option<f64>,
    /// Fastest speed of a wheel over the floor, in metres per second.
    #[arg(long, value_name = "M_PER_S", requires = "wheel_base")]
    pub wheel_speed: Option<f64>,
}

impl WheelArguments {
    pub fn wheels(&self) -> anyhow::Result<Option<Wheels>> {
        let (Some(base_m), Some(speed_max_m_s)) = (self.wheel_base, self.wheel_speed) else {
            return Ok(None);
        };
        check_flag("--wheel-base", check_wheel_base(base_m))?;
        check_flag("--wheel-speed", check_number(Axis::Speed, speed_max_m_s))?;
        Ok(Some(Wheels { base_m, speed_max_m_s }))
    }
}
