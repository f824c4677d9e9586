//! One contact sheet: a row of six pictures for each episode.

use std::fmt::Write;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::judge::window::{BLOCK_S, WINDOW_S, samples_in};

/// Episodes of a sheet.
pub const ROWS: usize = 10;
const PANEL_PX: f64 = 165.0;
const LEFT_PX: f64 = 30.0;
const PANELS: usize = 6;
/// Width of a sheet, in pixels.
pub const WIDTH_PX: f64 = LEFT_PX + PANELS as f64 * PANEL_PX;

/// Draws a sheet.
pub fn svg(episodes: &[(Trajectory, Conditions)], sheet: usize) -> String {
    let height_px = episodes.len() as f64 * PANEL_PX;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH_PX}\" height=\"{height_px}\" \
         viewBox=\"0 0 {WIDTH_PX} {height_px}\"><title>sheet {sheet}</title>\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
    );
    for (row, (trajectory, conditions)) in episodes.iter().enumerate() {
        let top_px = row as f64 * PANEL_PX;
        write!(
            svg,
            "<text x=\"4\" y=\"{}\" font-size=\"20\" font-family=\"DejaVu Sans\">{row}</text>",
            top_px + PANEL_PX / 2.0
        )
        .expect("a string takes any text");
        draw_row(&mut svg, top_px, trajectory, conditions.robot.radius_m);
    }
    svg + "</svg>"
}

fn draw_row(svg: &mut String, top_px: f64, trajectory: &Trajectory, radius_m: f64) {
    let n_window = samples_in(WINDOW_S, trajectory.period_s);
    let n_block = samples_in(BLOCK_S, trajectory.period_s);
    let start = trajectory.n_samples() - n_window;
    let poses = || (start..trajectory.n_samples()).flat_map(|sample| trajectory.poses_at(sample));
    let span = |of: fn(&rsrs_core::robot::unicycle::Pose) -> f64| {
        let low = poses().map(of).fold(f64::INFINITY, f64::min);
        (low, poses().map(of).fold(f64::NEG_INFINITY, f64::max))
    };
    let (x, y) = (span(|pose| pose.x_m), span(|pose| pose.y_m));
    let side_m = (x.1 - x.0).max(y.1 - y.0).max(0.8) + 4.0 * radius_m;
    let scale = (PANEL_PX - 6.0) / side_m;
    for panel in 0..PANELS {
        let left_px = LEFT_PX + panel as f64 * PANEL_PX;
        let at = |x_m: f64, y_m: f64| {
            (
                left_px + PANEL_PX / 2.0 + (x_m - f64::midpoint(x.0, x.1)) * scale,
                top_px + PANEL_PX / 2.0 - (y_m - f64::midpoint(y.0, y.1)) * scale,
            )
        };
        write!(
            svg,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#bbbbbb\"/>",
            left_px + 1.0,
            top_px + 1.0,
            PANEL_PX - 2.0,
            PANEL_PX - 2.0
        )
        .expect("a string takes any text");
        let samples = start + panel * n_block
            ..(start + (panel + 1) * n_block + 1).min(trajectory.n_samples());
        for robot in 0..trajectory.n_robots {
            let hue = 360 * robot / trajectory.n_robots;
            let mut points = String::new();
            for sample in samples.clone().step_by(3).chain([samples.end - 1]) {
                let pose = trajectory.poses_at(sample)[robot];
                let (x_px, y_px) = at(pose.x_m, pose.y_m);
                write!(points, "{x_px:.1},{y_px:.1} ").expect("a string takes any text");
            }
            let pose = trajectory.poses_at(samples.end - 1)[robot];
            let (x_px, y_px) = at(pose.x_m, pose.y_m);
            let (sine, cosine) = libm::sincos(pose.heading_rad);
            let body_px = radius_m * scale;
            write!(
                svg,
                "<polyline points=\"{points}\" fill=\"none\" stroke=\"hsl({hue},70%,45%)\" \
                 stroke-width=\"1\"/><circle cx=\"{x_px:.1}\" cy=\"{y_px:.1}\" r=\"{body_px:.1}\" \
                 fill=\"hsl({hue},70%,75%)\" stroke=\"#222222\" stroke-width=\"0.7\"/>\
                 <line x1=\"{x_px:.1}\" y1=\"{y_px:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" \
                 stroke=\"#000000\" stroke-width=\"1.2\"/>",
                x_px + 1.8 * body_px * cosine,
                y_px - 1.8 * body_px * sine
            )
            .expect("a string takes any text");
        }
    }
}
