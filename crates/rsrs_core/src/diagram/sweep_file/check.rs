//! Whether a sweep file makes a sweep: all that can be checked without the profile.

use super::{MOST_CELLS, MOST_REPLICATES, OutOfRange, SEED_LIMIT, SweepFile, SweepFileError};
use crate::conditions::MOST_DURATION_S;
use crate::conditions::start_file::StartPlacement;
use crate::quantity::{Axis, Cell};

impl SweepFile {
    /// Checks all that can be checked without the profile.
    pub fn check(&self, file: &str) -> Result<(), SweepFileError> {
        if self.axes.0.is_empty() == self.cells.is_none() {
            return Err(SweepFileError::GridOrList { file: file.to_owned() });
        }
        for (axis, values) in &self.axes.0 {
            check_axis(file, *axis, &values.0)?;
        }
        let n_cells: f64 = self.axes.0.iter().map(|(_, values)| values.0.len() as f64).product();
        if n_cells > MOST_CELLS as f64 {
            return Err(SweepFileError::TooManyCells { file: file.to_owned(), found: n_cells });
        }
        if let Some(cells) = &self.cells {
            check_cells(file, cells)?;
        }
        self.check_fixed(file)?;
        self.check_controller(file, None)?;
        self.check_numbers(file)
    }

    /// What is fixed has one value, and is not swept as well.
    fn check_fixed(&self, file: &str) -> Result<(), SweepFileError> {
        let refuse =
            |axis, problem| Err(SweepFileError::Twice { file: file.to_owned(), axis, problem });
        let swept = self.swept_axes();
        for (position, (axis, value)) in self.fixed.values.iter().enumerate() {
            if self.fixed.values[..position].iter().any(|(other, _)| other == axis) {
                return refuse(*axis, "fixed twice");
            }
            if swept.contains(axis) {
                return refuse(*axis, "swept and fixed, expected one of both");
            }
            check_unit(file, *axis, *value)?;
        }
        let has_radius = swept.contains(&Axis::PlacementRadius)
            || self.fixed.values.iter().any(|(axis, _)| *axis == Axis::PlacementRadius);
        match self.placement {
            Some(StartPlacement::Pair { .. }) => {
                Err(SweepFileError::Pair { file: file.to_owned() })
            }
            Some(_) if has_radius => {
                refuse(Axis::PlacementRadius, "given beside `placement`, expected one of both")
            }
            _ => Ok(()),
        }
    }

    fn check_numbers(&self, file: &str) -> Result<(), SweepFileError> {
        let out_of_range = |key, found, expected| {
            Err(OutOfRange { file: file.to_owned(), key, found, expected }.into())
        };
        if !(1..=MOST_REPLICATES).contains(&self.replicates) {
            return out_of_range("replicates", self.replicates as f64, "1 to 10^12");
        }
        check_run(file, self.duration_s, self.seed)?;
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

/// Refuses a duration or a seed, keys of sweeps and of experiments, that no run can have.
pub fn check_run(file: &str, duration_s: f64, seed: u64) -> Result<(), OutOfRange> {
    let refuse =
        |key, found, expected| Err(OutOfRange { file: file.to_owned(), key, found, expected });
    if !(duration_s > 0.0 && duration_s <= MOST_DURATION_S) {
        return refuse("duration_s", duration_s, "a time above 0 s, and a week at most");
    }
    if seed >= SEED_LIMIT {
        return refuse("seed", seed as f64, "a whole number below 2^63");
    }
    Ok(())
}

fn check_axis(file: &str, axis: Axis, values: &[f64]) -> Result<(), SweepFileError> {
    if values.is_empty() {
        return Err(SweepFileError::Empty { file: file.to_owned(), key: axis.key().to_owned() });
    }
    let refuse =
        |found, problem| Err(SweepFileError::Value { file: file.to_owned(), axis, found, problem });
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if let Some(found) = sorted.iter().find(|value| !value.is_finite()) {
        return refuse(*found, "is not a finite number");
    }
    // Zeros of both signs are one value.
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] >= pair[1]) {
        return refuse(pair[0], "occurs twice");
    }
    values.iter().try_for_each(|value| check_unit(file, axis, *value))
}

fn check_unit(file: &str, axis: Axis, value: f64) -> Result<(), SweepFileError> {
    let refuse = |source| SweepFileError::Unit { file: file.to_owned(), source };
    axis.check_unit(value).map_err(refuse)
}

fn check_cells(file: &str, cells: &[Cell]) -> Result<(), SweepFileError> {
    let empty = |key: &str| SweepFileError::Empty { file: file.to_owned(), key: key.to_owned() };
    let first = cells.first().ok_or_else(|| empty("cells"))?;
    let axes = first.axes();
    if axes.is_empty() {
        return Err(empty("cells[0]"));
    }
    if cells.len() > MOST_CELLS {
        let found = cells.len() as f64;
        return Err(SweepFileError::TooManyCells { file: file.to_owned(), found });
    }
    let refuse = |cell: &Cell, problem| {
        Err(SweepFileError::Cells { file: file.to_owned(), cell: cell.clone(), problem })
    };
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
