//! The curves of the answers on a robot.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::numerals::{count, percent};
use rsrs_pipeline::answer::{Answers, Quantity};
use rsrs_view::curves::{Curve, CurvesPicture, svg};

use crate::picture_file::{Length, PageStyle};
use crate::wording::quantity::{as_on_an_axis, of_cell, span_on_an_axis, without_unit};

/// Draws the curves of all answers on one page, as SVG.
pub fn of_answers(answers: &Answers, style: PageStyle) -> anyhow::Result<String> {
    let quantities = answers.questions.iter().flat_map(|answer| &answer.quantities);
    let best = &answers.best;
    let behaviour = best.behaviour;
    let curves: Vec<Curve> = quantities.map(|quantity| of_quantity(behaviour, quantity)).collect();
    let mill = behaviour.verb().plain;
    let title = if best.viable {
        format!("What {} needs to {mill}", best.robot)
    } else {
        format!("Why {} does not {mill}", best.robot)
    };
    let subtitle = format!(
        "{}: {} of {} fresh runs of {} s {mill} (lower bound {}). Each curve moves one quantity, all else \
         as recommended, and shows the world in which fewer runs {mill}: robots made worse or as measured.",
        of_cell(&best.cell),
        percent(best.b_s),
        count(best.n_replicates),
        answers.duration_s,
        percent(best.b_s_low)
    );
    let wanted = Some((best.wanted, format!("wanted: {}", percent(best.wanted))));
    let subtitles = vec![subtitle];
    let marked = "recommended, or what the robot has";
    Ok(svg(&CurvesPicture {
        title,
        subtitles,
        details: String::new(),
        curves,
        marked,
        wanted,
        theme: style.theme,
        width_px: style.width.map(Length::px),
    })?)
}

fn of_quantity(behaviour: Behaviour, found: &Quantity) -> Curve {
    let Quantity { axis, recommended, range, curve, .. } = found;
    let recommended_text = as_on_an_axis(*axis, *recommended);
    let heading = match range {
        Some(range) => {
            let span = span_on_an_axis(*axis, range.low, range.high);
            // The unit once, so that the heading is no wider than its panel.
            format!("{} {} ({span})", axis.name(), without_unit(&recommended_text))
        }
        None => format!("{} {recommended_text}: too rarely", axis.name()),
    };
    Curve {
        heading,
        axis: *axis,
        behaviour,
        points: curve.iter().map(|point| (point.value, point.milling())).collect(),
        range: range.map(|range| [range.low, range.high]),
        marked: Some(*recommended),
        boundaries: Vec::new(),
        compared: None,
        real: Vec::new(),
    }
}
