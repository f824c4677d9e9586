//! The two-dimensional slice of a phase diagram that a picture shows.

use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::help::Help;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::quantity::{Axis, Cell};

/// The cells of a picture: the diagram where all other axes are fixed.
#[derive(Clone, Debug)]
pub struct Slice {
    /// The axis drawn to the right.
    pub x: Axis,
    /// The axis drawn upwards; none for a diagram of one axis.
    pub y: Option<Axis>,
    /// Values on `x`, ascending; at least one.
    pub x_values: Vec<f64>,
    /// Values on `y`, ascending; the placeholder 0 without a `y`.
    pub y_values: Vec<f64>,
    /// The other axes and their values here.
    pub fixed: Vec<(Axis, f64)>,
    /// What became of each cell, row by row from the lowest `y`; shape `[n_y * n_x]`. `None` where
    /// nothing was swept.
    counts: Vec<Option<PhaseCounts>>,
}

/// Why a diagram has no such slice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SliceError {
    /// There is nothing to draw.
    #[error("the phase diagram has no cells")]
    Empty,
    /// An axis of the picture was not swept.
    #[error("axis {axis} was not swept; swept: {}", keys(swept))]
    AxisNotSwept {
        /// The axis asked for.
        axis: Axis,
        /// The axes there are.
        swept: Vec<Axis>,
    },
    /// A value was asked for on an axis that was not swept.
    #[error("axis {axis} was not swept; swept: {}", keys(swept))]
    FixedAxisNotSwept {
        /// The axis asked for.
        axis: Axis,
        /// The axes there are.
        swept: Vec<Axis>,
    },
    /// An axis has two places in the picture.
    #[error("axis {0} is given twice: a picture shows it along an edge, or at one value")]
    AxisTwice(Axis),
    /// A further axis has several values, and none was chosen.
    #[error(
        "axis {axis} has {} values, and a picture shows one: {}",
        values.len(),
        list(values)
    )]
    ValueMissing {
        /// The axis.
        axis: Axis,
        /// Its values, ascending.
        values: Vec<f64>,
    },
    /// A further axis never has the value asked for.
    #[error("{axis}={found} was not swept; nearest swept value: {axis}={nearest}")]
    ValueNotSwept {
        /// The axis.
        axis: Axis,
        /// The value asked for, in the axis's unit.
        found: f64,
        /// The closest swept value, in the axis's unit.
        nearest: f64,
    },
    /// Each value was swept, but never all of them together.
    #[error("no cell was swept at {}", at.iter().map(|(axis, value)| format!("{axis}={value}")).collect::<Vec<_>>().join(","))]
    NothingThere {
        /// The values asked for.
        at: Vec<(Axis, f64)>,
    },
}

impl Help for SliceError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Empty => Some("finish the sweep first: `rsrs sweep SWEEP -o DIR`".to_owned()),
            Self::AxisNotSwept { swept, .. } => match swept.as_slice() {
                [x, y, ..] => Some(format!("draw `--x {x} --y {y}`")),
                [x] => Some(format!("draw `--x {x}`")),
                [] => None,
            },
            Self::FixedAxisNotSwept { axis, .. } => Some(format!("leave {axis} out of `--at`")),
            Self::ValueMissing { axis, values } => values
                .first()
                .map(|value| format!("choose one, for instance `--at {axis}={value}`")),
            Self::ValueNotSwept { axis, nearest, .. } => {
                Some(format!("draw the nearest slice with `--at {axis}={nearest}`"))
            }
            Self::AxisTwice { .. } | Self::NothingThere { .. } => None,
        }
    }
}

fn keys(axes: &[Axis]) -> String {
    axes.iter().map(|axis| axis.key()).collect::<Vec<_>>().join(", ")
}

fn list(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// Whether two values name the same cell: equal up to the rounding of a printed number.
pub fn is_same(left: f64, right: f64) -> bool {
    (left - right).abs() <= 1e-9 * left.abs().max(right.abs())
}

impl Slice {
    /// Cuts the slice at some values of the axes that the picture does not show; an axis with one
    /// value needs none.
    pub fn new(
        diagram: &PhaseDiagram,
        x: Axis,
        y: Option<Axis>,
        at: &[(Axis, f64)],
    ) -> Result<Self, SliceError> {
        check_axes(diagram, x, y, at)?;
        let fixed = fixed_axes(diagram, x, y, at)?;

        let is_here = |cell: &Cell| {
            fixed.iter().all(|(axis, value)| cell.get(*axis).is_some_and(|v| is_same(v, *value)))
        };
        let cells: Vec<_> =
            diagram.cells.iter().filter(|entry| is_here(&entry.cell)).cloned().collect();
        if cells.is_empty() {
            return Err(SliceError::NothingThere { at: fixed });
        }
        let here = PhaseDiagram { axes: diagram.axes.clone(), cells };
        let x_values = here.values(x);
        let y_values = y.map_or_else(|| vec![0.0], |y| here.values(y));

        let mut counts = vec![None; x_values.len() * y_values.len()];
        for entry in &here.cells {
            let column = index_of(&x_values, entry.cell.get(x));
            let row = y.map_or(Some(0), |y| index_of(&y_values, entry.cell.get(y)));
            if let (Some(column), Some(row)) = (column, row) {
                counts[row * x_values.len() + column] = Some(entry.counts);
            }
        }
        Ok(Self { x, y, x_values, y_values, fixed, counts })
    }

    /// What became of one cell; `None` if it was not swept.
    pub fn counts(&self, column: usize, row: usize) -> Option<PhaseCounts> {
        self.counts[row * self.x_values.len() + column]
    }

    /// Whether some cell of the grid was not swept, or has no replicate yet.
    pub fn has_holes(&self) -> bool {
        self.counts.iter().any(|counts| counts.is_none_or(|counts| counts.total() == 0))
    }

    /// Where a cell lies in the picture: its values on `x` and `y`. `None` if it belongs to another
    /// slice, or lacks one of them.
    pub fn place(&self, cell: &Cell) -> Option<(f64, f64)> {
        let is_elsewhere = self
            .fixed
            .iter()
            .any(|(axis, value)| cell.get(*axis).is_some_and(|other| !is_same(other, *value)));
        if is_elsewhere {
            return None;
        }
        let x = cell.get(self.x)?;
        let y = self.y.map_or(Some(0.0), |y| cell.get(y))?;
        Some((x, y))
    }

    /// Column, row and index of each cell of a diagram that the slice shows.
    pub fn places(&self, diagram: &PhaseDiagram) -> Vec<(usize, usize, usize)> {
        let place = |(index, entry): (usize, &DiagramCell)| {
            let (x, y) = self.place(&entry.cell)?;
            let row = if self.y.is_some() { index_of(&self.y_values, Some(y))? } else { 0 };
            Some((index_of(&self.x_values, Some(x))?, row, index))
        };
        diagram.cells.iter().enumerate().filter_map(place).collect()
    }
}

fn check_axes(
    diagram: &PhaseDiagram,
    x: Axis,
    y: Option<Axis>,
    at: &[(Axis, f64)],
) -> Result<(), SliceError> {
    if diagram.cells.is_empty() {
        return Err(SliceError::Empty);
    }
    let mut places: Vec<Axis> = Vec::new();
    let is_swept = |axis: &Axis| diagram.axes.contains(axis);
    let drawn = || [Some(x), y].into_iter().flatten();
    let fixed = || at.iter().map(|(axis, _)| *axis);
    let swept = || diagram.axes.clone();
    if let Some(axis) = drawn().find(|axis| !is_swept(axis)) {
        return Err(SliceError::AxisNotSwept { axis, swept: swept() });
    }
    if let Some(axis) = fixed().find(|axis| !is_swept(axis)) {
        return Err(SliceError::FixedAxisNotSwept { axis, swept: swept() });
    }
    for axis in drawn().chain(fixed()) {
        if places.contains(&axis) {
            return Err(SliceError::AxisTwice(axis));
        }
        places.push(axis);
    }
    Ok(())
}

fn fixed_axes(
    diagram: &PhaseDiagram,
    x: Axis,
    y: Option<Axis>,
    at: &[(Axis, f64)],
) -> Result<Vec<(Axis, f64)>, SliceError> {
    let others = diagram.axes.iter().filter(|axis| **axis != x && Some(**axis) != y);
    let value_on = |axis: Axis| {
        let values = diagram.values(axis);
        let asked = at.iter().find(|(other, _)| *other == axis).map(|(_, value)| *value);
        match (asked, values.as_slice()) {
            (Some(found), _) => nearest_to(&values, found, axis),
            (None, [only]) => Ok(*only),
            (None, _) => Err(SliceError::ValueMissing { axis, values }),
        }
    };
    others.map(|axis| Ok((*axis, value_on(*axis)?))).collect()
}

fn nearest_to(values: &[f64], found: f64, axis: Axis) -> Result<f64, SliceError> {
    let nearest = values
        .iter()
        .copied()
        .min_by(|left, right| (left - found).abs().total_cmp(&(right - found).abs()))
        .ok_or(SliceError::Empty)?;
    if is_same(nearest, found) {
        Ok(nearest)
    } else {
        Err(SliceError::ValueNotSwept { axis, found, nearest })
    }
}

fn index_of(values: &[f64], value: Option<f64>) -> Option<usize> {
    values.iter().position(|other| Some(other.to_bits()) == value.map(f64::to_bits))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsrs_core::diagram::DiagramCell;
    use rsrs_core::judge::phase::Phase;

    fn diagram(cells: &[&str]) -> PhaseDiagram {
        let cells: Vec<DiagramCell> = cells
            .iter()
            .map(|text| DiagramCell { cell: text.parse().unwrap(), counts: PhaseCounts::default() })
            .collect();
        let axes = cells.first().map(|entry| entry.cell.axes()).unwrap_or_default();
        PhaseDiagram { axes, cells }
    }

    fn three_axes() -> PhaseDiagram {
        diagram(&[
            "speed_m_s=0.1,turn_rate_rad_s=0.5,robots=6",
            "speed_m_s=0.1,turn_rate_rad_s=0.5,robots=9",
            "speed_m_s=0.2,turn_rate_rad_s=1,robots=9",
        ])
    }

    #[test]
    fn a_slice_keeps_only_its_values_and_shows_holes() {
        let slice =
            Slice::new(&three_axes(), Axis::Speed, Some(Axis::TurnRate), &[(Axis::Robots, 9.0)])
                .unwrap();

        assert_eq!((slice.x_values.len(), slice.y_values.len()), (2, 2));
        assert!(slice.counts(0, 0).is_some() && slice.counts(1, 0).is_none());
        assert!(slice.has_holes());
        let place = |text: &str| slice.place(&text.parse().unwrap());
        assert_eq!(place("speed_m_s=0.1,turn_rate_rad_s=0.5,robots=9"), Some((0.1, 0.5)));
        assert_eq!(place("speed_m_s=0.1,turn_rate_rad_s=0.5,robots=6"), None, "of another slice");
        assert_eq!(place("speed_m_s=0.1"), None);
    }

    #[test]
    fn a_cell_without_replicates_is_a_hole() {
        let mut diagram = diagram(&["speed_m_s=0.1"]);
        let has_holes =
            |diagram: &_| Slice::new(diagram, Axis::Speed, None, &[]).unwrap().has_holes();

        assert!(has_holes(&diagram));
        diagram.cells[0].counts.add(Phase::UNFORMED);
        assert!(!has_holes(&diagram));
    }

    #[test]
    fn an_axis_with_one_value_needs_no_choice() {
        let diagram = diagram(&["speed_m_s=0.1,turn_rate_rad_s=0.5,robots=9"]);

        let slice = Slice::new(&diagram, Axis::Speed, None, &[]).unwrap();

        assert_eq!(slice.fixed, [(Axis::TurnRate, 0.5), (Axis::Robots, 9.0)]);
        assert_eq!((slice.y_values, slice.counts.len()), (vec![0.0], 1));
    }

    #[test]
    fn impossible_slices_are_refused_with_what_there_is() {
        let error = |x, y, at: &[(Axis, f64)]| Slice::new(&three_axes(), x, y, at).unwrap_err();
        let (speed, turn_rate) = (Axis::Speed, Some(Axis::TurnRate));

        let missing = error(speed, turn_rate, &[]);
        assert_eq!(missing.to_string(), "axis robots has 2 values, and a picture shows one: 6, 9");
        assert_eq!(missing.help().unwrap(), "choose one, for instance `--at robots=6`");
        assert_eq!(
            error(speed, turn_rate, &[(Axis::Robots, 8.0)]).to_string(),
            "robots=8 was not swept; nearest swept value: robots=9"
        );
        assert_eq!(
            error(Axis::Range, turn_rate, &[]).to_string(),
            "axis range_m was not swept; swept: speed_m_s, turn_rate_rad_s, robots"
        );
        let fixed = error(speed, turn_rate, &[(Axis::Range, 0.75)]);
        assert_eq!(fixed.help().unwrap(), "leave range_m out of `--at`");
        assert_eq!(
            error(speed, Some(speed), &[]).to_string(),
            "axis speed_m_s is given twice: a picture shows it along an edge, or at one value"
        );
        let empty = Slice::new(&diagram(&[]), speed, turn_rate, &[]).unwrap_err();
        assert_eq!(empty, SliceError::Empty);
        let never_met = error(speed, None, &[(Axis::TurnRate, 1.0), (Axis::Robots, 6.0)]);
        assert_eq!(never_met.to_string(), "no cell was swept at turn_rate_rad_s=1,robots=6");
    }

    #[test]
    fn a_value_in_an_error_is_one_that_can_be_asked_for() {
        let diagram = diagram(&[
            "speed_m_s=0.1,undetected_speed_m_s=-0.0777777777777",
            "speed_m_s=0.1,undetected_speed_m_s=0.1",
        ]);
        let missing = Slice::new(&diagram, Axis::Speed, None, &[]).unwrap_err().to_string();

        let (_, values) = missing.rsplit_once(": ").unwrap();

        for value in values.split(", ") {
            let at = [(diagram.axes[1], value.parse().unwrap())];
            assert!(Slice::new(&diagram, Axis::Speed, None, &at).is_ok(), "{value}");
        }
    }
}
