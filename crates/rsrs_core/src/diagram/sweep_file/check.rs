//! Whether a sweep file makes a sweep: all that can be checked without the profile.

use super::{
    MOST_CELLS, MOST_REPLICATES, SEED_LIMIT, SweepFile, SweepFileError, SweepProblem, in_file,
};
use crate::conditions::MOST_DURATION_S;
use crate::conditions::controller_table::ControllerSource;
use crate::conditions::start_file::StartPlacement;
use crate::out_of_range::OutOfRange;
use crate::quantity::{Axis, Cell};
use crate::robot::profile::RobotProfile;

impl SweepFile {
    /// Checks all that can be checked without the profile.
    pub fn check(&self, file: &str) -> Result<(), SweepFileError> {
        self.check_contents().map_err(in_file(file))
    }

    fn check_contents(&self) -> Result<(), SweepProblem> {
        if self.axes.0.is_empty() == self.cells.is_none() {
            return Err(SweepProblem::GridOrList);
        }
        for (axis, values) in &self.axes.0 {
            check_axis(*axis, &values.0)?;
        }
        let n_cells: f64 = self.axes.0.iter().map(|(_, values)| values.0.len() as f64).product();
        if n_cells > MOST_CELLS as f64 {
            return Err(SweepProblem::TooManyCells(n_cells));
        }
        if let Some(cells) = &self.cells {
            check_cells(cells)?;
        }
        self.check_fixed()?;
        self.check_axes(None)?;
        self.check_numbers()
    }

    /// What is fixed has one value, and is not swept as well.
    fn check_fixed(&self) -> Result<(), SweepProblem> {
        let refuse = |axis, problem| Err(SweepProblem::Twice { axis, problem });
        let swept = self.swept_axes();
        for (position, (axis, value)) in self.fixed.values.iter().enumerate() {
            if self.fixed.values[..position].iter().any(|(other, _)| other == axis) {
                return refuse(*axis, "fixed twice");
            }
            if swept.contains(axis) {
                return refuse(*axis, "swept and fixed, expected one of both");
            }
            axis.check_unit(*value)?;
        }
        let has_radius = swept.contains(&Axis::PlacementRadius)
            || self.fixed.values.iter().any(|(axis, _)| *axis == Axis::PlacementRadius);
        match self.placement {
            Some(StartPlacement::Pair { .. }) => Err(SweepProblem::Pair),
            Some(_) if has_radius => {
                refuse(Axis::PlacementRadius, "given beside `placement`, expected one of both")
            }
            _ => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), SweepProblem> {
        let out_of_range = |name, found, expected: &'static str| {
            Err(OutOfRange { name, found, expected: expected.into() }.into())
        };
        if !(1..=MOST_REPLICATES).contains(&self.replicates) {
            return out_of_range("replicates", self.replicates as f64, "1 to 10^12");
        }
        check_run(self.duration_s, self.seed)?;
        let Some(adaptive) = self.adaptive else {
            return Ok(());
        };
        if !(adaptive.width > 0.0 && adaptive.width < 1.0) {
            return out_of_range("adaptive.width", adaptive.width, "a share between 0 and 1");
        }
        let most = adaptive.most_replicates;
        if !(self.replicates..=MOST_REPLICATES).contains(&most) {
            let expected = "at least `replicates`, and at most 10^12";
            return out_of_range("adaptive.most_replicates", most as f64, expected);
        }
        Ok(())
    }
}

/// Whether a run can last so long, in seconds, and have this seed.
///
/// # Errors
///
/// What is wrong, by its key in a file.
pub fn check_run(duration_s: f64, seed: u64) -> Result<(), OutOfRange> {
    if !(duration_s > 0.0 && duration_s <= MOST_DURATION_S) {
        let expected = "a time above 0 s, and a week at most".into();
        return Err(OutOfRange { name: "duration_s", found: duration_s, expected });
    }
    if seed >= SEED_LIMIT {
        let expected = "a whole number below 2^63".into();
        return Err(OutOfRange { name: "seed", found: seed as f64, expected });
    }
    Ok(())
}

fn check_axis(axis: Axis, values: &[f64]) -> Result<(), SweepProblem> {
    if values.is_empty() {
        return Err(SweepProblem::Empty(axis.key().to_owned()));
    }
    let refuse = |found, problem| Err(SweepProblem::Value { axis, found, problem });
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if let Some(found) = sorted.iter().find(|value| !value.is_finite()) {
        return refuse(*found, "is not a finite number");
    }
    // Zeros of both signs are one value.
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] >= pair[1]) {
        return refuse(pair[0], "occurs twice");
    }
    Ok(values.iter().try_for_each(|value| axis.check_unit(*value))?)
}

fn check_cells(cells: &[Cell]) -> Result<(), SweepProblem> {
    let empty = |key: &str| SweepProblem::Empty(key.to_owned());
    let first = cells.first().ok_or_else(|| empty("cells"))?;
    let axes = first.axes();
    if axes.is_empty() {
        return Err(empty("cells[0]"));
    }
    if cells.len() > MOST_CELLS {
        return Err(SweepProblem::TooManyCells(cells.len() as f64));
    }
    let refuse = |cell: &Cell, problem| Err(SweepProblem::Cells { cell: cell.clone(), problem });
    if let Some(cell) = cells.iter().find(|cell| cell.axes() != axes) {
        return refuse(cell, "does not give the axes of the first cell, in its order");
    }
    let mut sorted: Vec<(Vec<f64>, &Cell)> =
        cells.iter().map(|cell| (cell.iter().map(|(_, value)| value).collect(), cell)).collect();
    sorted.sort_by(|(left, _), (right, _)| left.partial_cmp(right).expect("cells are finite"));
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => refuse(pair[0].1, "occurs twice"),
        None => Ok(()),
    }
}

impl SweepFile {
    /// Whether the axes are those of the controller, once its table has been read, and its rows are for what these
    /// robots report, if they are known.
    pub(super) fn check_axes(&self, robot: Option<&RobotProfile>) -> Result<(), SweepProblem> {
        if let Some(ControllerSource::File(_)) = self.controller {
            return Ok(());
        }
        let table = self.table();
        if let Some(table) = table {
            table.check()?;
            robot.map_or(Ok(()), |robot| table.check_rows(&robot.reading_names()))?;
        }
        let fixed = self.fixed.values.iter().map(|(axis, _)| *axis);
        let mut axes = self.swept_axes().into_iter().chain(fixed);
        Ok(axes.try_for_each(|axis| crate::conditions::check_axis(axis, table))?)
    }
}
