//! How fast every robot was at every command: the paper's `fig:distribution`.

use rsrs_core::trials::fit::SpeedFit;

use crate::chart::{BELOW_PX, Chart, legend, stroke_mark};
use crate::header::{MARGIN_PX, header};
use crate::palette::{BLUE, INK, QUIET_INK, VERMILION};
use crate::scale::ends;
use crate::svg::{Element, line_of_text, number, through};
use crate::text::{Weight, width_px};
use crate::theme::Theme;

const PAGE_PX: f64 = 640.0;
const ROW_PX: f64 = 34.0;
const NAME_PX: f64 = 11.5;

/// Speeds of robots and the text about them.
#[derive(Clone, Debug)]
pub struct DistributionPicture<'a> {
    /// Every robot at every command, as a fit has them.
    pub speeds: &'a [SpeedFit],
    /// The trials behind them.
    pub trials: &'a [DrivenSpeed],
    /// Where it is looked at.
    pub theme: Theme,
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// How fast one robot was in one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenSpeed {
    /// The robot.
    pub robot: String,
    /// The command, in metres per second.
    pub commanded_m_s: f64,
    /// The mean speed of the trial, in metres per second; finite.
    pub measured_m_s: f64,
}

/// Why there is no picture of distributions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DistributionPictureError {
    /// There is nothing to draw.
    #[error("no speeds, expected those of 1 robot or more")]
    Empty,
    /// A speed is no number.
    #[error("{robot} at {commanded_m_s} m/s has a mean of {mean_m_s} m/s, expected finite numbers")]
    NotFinite {
        /// The robot.
        robot: String,
        /// The command, in metres per second.
        commanded_m_s: f64,
        /// Its mean, in metres per second.
        mean_m_s: f64,
    },
}

/// Draws the normal distribution of every robot's speed, a panel for each command.
///
/// Every curve is as high as its row, because robots whose trials hardly differ would hide all
/// others. A robot with one trial gets a stroke. A dot is a trial.
///
/// # Source
///
/// `fig:distribution`, §IV step 1.
pub fn svg(picture: &DistributionPicture) -> Result<String, DistributionPictureError> {
    check(picture)?;
    let room_px = PAGE_PX - 2.0 * MARGIN_PX;
    let (texts, header_px) =
        header(picture.theme, &picture.title, &[&picture.subtitle], MARGIN_PX, room_px);
    let names_px = picture
        .speeds
        .iter()
        .map(|speed| width_px(&speed.robot, NAME_PX, Weight::Regular))
        .fold(0.0, f64::max)
        .min(180.0);
    let left_px = MARGIN_PX + names_px + 10.0;
    let mut top_px = header_px + 14.0;
    let mut panels = Vec::new();
    for rows in panels_of(picture.speeds) {
        let chart = chart(&rows, picture.trials, (left_px, top_px));
        panels.push(panel(&rows, picture.trials, chart));
        top_px = chart.bottom_px() + BELOW_PX + 16.0;
    }
    let entries = [
        (Element::circle((11.0, 0.0), 2.4).with("fill", INK), "a trial"),
        (stroke_mark(BLUE, 1.8), "normal distribution of the trials, each as high as its row"),
        (stroke_mark(VERMILION, 1.8).with("stroke-dasharray", "5 3"), "commanded"),
    ]
    .map(|(mark, text)| (mark, text.to_owned()));
    let (legend, bottom_px) =
        legend(&entries, (left_px, top_px - 16.0), PAGE_PX - MARGIN_PX - left_px);
    let page = Element::picture(PAGE_PX, bottom_px + 12.0, &picture.title)
        .described(&picture.theme.description([picture.subtitle.as_str()], ""))
        .children(texts)
        .children(panels)
        .children(legend);
    Ok(format!("{page}\n"))
}

fn check(picture: &DistributionPicture) -> Result<(), DistributionPictureError> {
    if picture.speeds.is_empty() {
        return Err(DistributionPictureError::Empty);
    }
    for speed in picture.speeds {
        let numbers = [speed.commanded_m_s, speed.mean_m_s, speed.sd_m_s.unwrap_or(0.0)];
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(DistributionPictureError::NotFinite {
                robot: speed.robot.clone(),
                commanded_m_s: speed.commanded_m_s,
                mean_m_s: speed.mean_m_s,
            });
        }
    }
    Ok(())
}

/// Speeds by command, ascending.
fn panels_of(speeds: &[SpeedFit]) -> Vec<Vec<&SpeedFit>> {
    let mut commands: Vec<f64> = speeds.iter().map(|speed| speed.commanded_m_s).collect();
    commands.sort_by(f64::total_cmp);
    commands.dedup_by(|left, right| left.total_cmp(right).is_eq());
    let at = |command: &f64| {
        speeds.iter().filter(|speed| speed.commanded_m_s.total_cmp(command).is_eq()).collect()
    };
    commands.iter().map(at).collect()
}

fn chart(rows: &[&SpeedFit], trials: &[DrivenSpeed], (left_px, top_px): (f64, f64)) -> Chart {
    let places = rows.iter().flat_map(|speed| {
        let away_m_s = 3.2 * speed.sd_m_s.unwrap_or(0.0);
        let driven = trials.iter().filter(|trial| is_its(trial, speed));
        let driven = driven.map(|trial| trial.measured_m_s);
        let curve = [speed.mean_m_s - away_m_s, speed.mean_m_s + away_m_s, speed.commanded_m_s];
        curve.into_iter().chain(driven).collect::<Vec<f64>>()
    });
    let [low, high] = ends(places);
    let spare = (0.04 * (high - low)).max(0.001 * high.abs()).max(1e-6);
    Chart {
        left_px,
        top_px,
        width_px: PAGE_PX - MARGIN_PX - left_px,
        height_px: ROW_PX * rows.len() as f64 + 6.0,
        x: [low - spare, high + spare],
        y: [0.0, rows.len() as f64],
    }
}

/// Whether a trial is one of a robot at a command.
fn is_its(trial: &DrivenSpeed, speed: &SpeedFit) -> bool {
    trial.robot == speed.robot && trial.commanded_m_s.total_cmp(&speed.commanded_m_s).is_eq()
}

fn panel(rows: &[&SpeedFit], trials: &[DrivenSpeed], chart: Chart) -> Element {
    let commanded = rows[0].commanded_m_s;
    let command = Element::path(&format!(
        "M{} {}V{}",
        number(chart.x_px(commanded)),
        number(chart.top_px),
        number(chart.bottom_px())
    ))
    .stroked(VERMILION, 1.5)
    .with("stroke-dasharray", "5 3");
    let curves = rows.iter().enumerate().flat_map(|(row, speed)| {
        let base_px = chart.top_px + ROW_PX * (row as f64 + 1.0);
        let dots = trials.iter().filter(|trial| is_its(trial, speed)).map(move |trial| {
            Element::circle((chart.x_px(trial.measured_m_s), base_px - 4.0), 2.4)
                .filled(INK, "0.75")
        });
        [curve(chart, base_px, speed), name(chart, base_px, speed)].into_iter().chain(dots)
    });
    Element::new("g")
        .child(command)
        .children(curves)
        .child(chart.frame(&format!("measured speed (m/s), commanded {commanded} m/s")))
}

fn curve(chart: Chart, base_px: f64, speed: &SpeedFit) -> Element {
    let high_px = ROW_PX - 8.0;
    let mean = speed.mean_m_s;
    let path = match speed.sd_m_s {
        Some(sd) if chart.x_px(mean + sd) - chart.x_px(mean) > 0.3 => {
            through((-32..=32).map(|step| {
                let z = f64::from(step) / 10.0;
                (chart.x_px(mean + z * sd), base_px - high_px * libm::exp(-z * z / 2.0))
            }))
        }
        _ => format!("M{} {}v{}", number(chart.x_px(mean)), number(base_px), number(-high_px)),
    };
    let sd = speed
        .sd_m_s
        .map_or("one trial".to_owned(), |sd_m_s| format!("standard deviation {sd_m_s:.5} m/s"));
    let tooltip = format!("{}: mean {mean:.5} m/s, {sd}, {} trials", speed.robot, speed.n_trials);
    Element::path(&path).filled(BLUE, "0.15").stroked(BLUE, 1.8).titled(&tooltip)
}

fn name(chart: Chart, base_px: f64, speed: &SpeedFit) -> Element {
    let gain = format!("gain {:.2}", speed.gain);
    let robot = line_of_text(chart.left_px - 8.0, base_px - 11.0, &speed.robot)
        .with("text-anchor", "end")
        .with("fill", INK);
    let gain = line_of_text(chart.left_px - 8.0, base_px + 2.0, &gain)
        .with("text-anchor", "end")
        .with("fill", QUIET_INK);
    Element::new("g").at("font-size", NAME_PX).child(robot).child(gain)
}
