//! The pictures of a validation: the reach under each command, and the sensor.

use std::path::Path;

use anyhow::Context;
use rsrs_core::capability::border_m;
use rsrs_core::trials::trial::DrivenTrial;
use rsrs_core::trials::validation::Tube;
use rsrs_view::reachable_set::{self, ReachPicture, TubeMembership};
use rsrs_view::sensor::{self, SensorPicture};

use super::Case;
use super::file::ValidationReport;
use super::text::commands;
use crate::picture_file::{PageStyle, write_svg_and_png};

/// Draws the tubes as `reach_1`, `reach_2` …, and the sensor where detections are known; as SVG and
/// PNG. Of drives whose command changed, which may be many, those outside are drawn.
///
/// # Errors
///
/// If the folder cannot be made or written.
pub fn write(
    folder: &Path,
    case: &Case,
    answer: &ValidationReport,
    style: PageStyle,
) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (index, tube) in answer.validation.tubes.iter().enumerate() {
        let trials = &answer.validation.trials;
        let leaves = trials.iter().any(|place| place.tube == index && !place.exits.is_empty());
        if tube.command.is_none() && !leaves {
            continue;
        }
        let svg = tube_svg(case, answer, (index, tube), style)?;
        write_svg_and_png(folder, &format!("reach_{}", index + 1), &svg, style)?;
    }
    if let Some(map) = &case.sensor {
        let robot = &case.conditions[0].robot;
        let measured = case.origin.map_or("measured", |_| "trials, simulated");
        let svg = sensor::svg(&SensorPicture {
            map,
            simulated_m: &border_m(&robot.region),
            radius_m: robot.radius_m,
            title: format!("Sensor of {}", case.source.profile.name),
            subtitle: format!(
                "{measured}: detects {:.2}, false positives {:.3}; simulated: {:.2}, {:.3}",
                map.true_positive.value,
                map.false_positive.value,
                robot.true_positive,
                robot.false_positive
            ),
            theme: style.theme,
        })?;
        write_svg_and_png(folder, "sensor", &svg, style)?;
    }
    Ok(())
}

fn tube_svg(
    case: &Case,
    answer: &ValidationReport,
    (index, tube): (usize, &Tube),
    style: PageStyle,
) -> anyhow::Result<String> {
    let places = case.trials.iter().zip(&answer.validation.trials);
    let trials: Vec<(&DrivenTrial, TubeMembership)> = places
        .filter(|(_, place)| place.tube == index)
        .map(|(trial, place)| {
            (
                trial,
                if place.exits.is_empty() {
                    TubeMembership::Inside
                } else {
                    TubeMembership::Outside
                },
            )
        })
        .collect();
    Ok(reachable_set::svg(&ReachPicture {
        tube,
        trials: &trials,
        title: format!(
            "Simulated reach of {} and {}",
            case.source.profile.name,
            case.origin.map_or_else(
                || "real trials".to_owned(),
                |origin| format!("trials of {}", origin.whose())
            )
        ),
        subtitle: format!(
            "{}; the regions hold {:.0} % of the simulated robots",
            commands(&answer.validation, index),
            answer.validation.share * 100.0
        ),
        theme: style.theme,
    })?)
}
