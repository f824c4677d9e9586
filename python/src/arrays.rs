//! Arrays of numpy: from what a caller has, and to what a caller gets.

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use rsrs_core::conditions::limits::CommandRange;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::quantity::Bounds;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use crate::error::{our_mistake, refused};

/// Whatever numpy makes an array of, as one of doubles.
fn numbers<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let py = value.py();
    let dtype = [("dtype", "float64")].into_py_dict(py)?;
    let array = py.import("numpy")?.call_method("asarray", (value,), Some(&dtype));
    let array = array.map_err(|error| {
        let is_ours =
            error.is_instance_of::<PyTypeError>(py) || error.is_instance_of::<PyValueError>(py);
        if is_ours {
            refused(format!("{name}: expected an array of numbers; {}", error.value(py)))
        } else {
            error
        }
    })?;
    array.extract::<PyReadonlyArrayDyn<'py, f64>>()
}

/// A shape as numpy writes it.
fn shape(dimensions: &[usize]) -> String {
    match dimensions {
        [one] => format!("({one},)"),
        _ => format!(
            "({})",
            dimensions.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        ),
    }
}

/// Poses of shape `(T, N, 3)`, and commands of a shape that broadcasts to `(T, N, 2)`, as a trajectory.
pub fn trajectory(
    poses: &Bound<'_, PyAny>,
    commands: Option<&Bound<'_, PyAny>>,
    period_s: f64,
) -> PyResult<Trajectory> {
    let array = numbers(poses, "poses")?;
    let &[n_samples, n_robots, 3] = array.shape() else {
        return Err(refused(format!(
            "poses have shape {}, expected (T, N, 3): samples, robots, and x_m, y_m, heading_rad",
            shape(array.shape())
        )));
    };
    let view = array.as_array();
    let lanes = view.lanes(numpy::ndarray::Axis(2)).into_iter();
    let poses: Vec<Pose> =
        lanes.map(|pose| Pose { x_m: pose[0], y_m: pose[1], heading_rad: pose[2] }).collect();
    let Some(commands) = commands else {
        return Ok(Trajectory::of_poses(period_s, n_robots, poses));
    };
    let given = numbers(commands, "commands")?;
    let expected = [n_samples, n_robots, 2];
    let given = given.as_array();
    let view = given.broadcast(&expected[..]).ok_or_else(|| {
        refused(format!(
            "commands have shape {}, expected {} or one that broadcasts to it: samples, robots, and \
             speed_m_s, turn_rate_rad_s",
            shape(given.shape()),
            shape(&expected)
        ))
    })?;
    let lanes = view.lanes(numpy::ndarray::Axis(2)).into_iter();
    let commands = lanes.map(|it| Command { speed_m_s: it[0], turn_rate_rad_s: it[1] }).collect();
    Ok(Trajectory { poses, commands, ..Trajectory::new(period_s, n_robots) })
}

/// What a controller returned, of a shape that broadcasts to `(n_robots, 2)`, as commands.
pub fn commands(
    answer: &Bound<'_, PyAny>,
    n_robots: usize,
    commands: &mut Vec<Command>,
) -> PyResult<()> {
    let given = numbers(answer, "what the controller returned")?;
    let given = given.as_array();
    let view = given.broadcast(&[n_robots, 2][..]).ok_or_else(|| {
        let found = shape(given.shape());
        refused(format!(
            "the controller returned commands of shape {found}, expected ({n_robots}, 2)"
        ))
    })?;
    if let Some(wrong) = view.iter().find(|number| !Bounds::SIGNED.contains(**number)) {
        let expected = Bounds::SIGNED;
        return Err(refused(format!(
            "the controller returned {wrong}, expected numbers {expected}"
        )));
    }
    let rows = view.lanes(numpy::ndarray::Axis(1)).into_iter();
    commands.extend(rows.map(|it| Command { speed_m_s: it[0], turn_rate_rad_s: it[1] }));
    Ok(())
}

/// Commands of a shape that broadcasts to that of worlds and robots, moved into their range.
pub fn commands_of_worlds(
    given: &Bound<'_, PyAny>,
    expected: [usize; 3],
    range: CommandRange,
    commands: &mut Vec<Command>,
) -> PyResult<()> {
    let given = numbers(given, "commands")?;
    let given = given.as_array();
    let view = given.broadcast(&expected[..]).ok_or_else(|| {
        let found = shape(given.shape());
        refused(format!("commands have shape {found}, expected {}", shape(&expected)))
    })?;
    let push = |speed_m_s: f64, turn_rate_rad_s: f64, commands: &mut Vec<Command>| {
        commands.push(range.nearest(Command { speed_m_s, turn_rate_rad_s }));
        speed_m_s.is_nan() || turn_rate_rad_s.is_nan()
    };
    let mut has_nan = false;
    match view.as_slice() {
        Some(flat) => {
            for it in flat.as_chunks::<2>().0 {
                has_nan |= push(it[0], it[1], commands);
            }
        }
        None => {
            for it in view.lanes(numpy::ndarray::Axis(2)) {
                has_nan |= push(it[0], it[1], commands);
            }
        }
    }
    if has_nan { Err(refused("a command is not a number")) } else { Ok(()) }
}

/// Numbers in the order of a shape, as an array that cannot be written to.
pub fn array3(
    py: Python<'_>,
    shape: (usize, usize, usize),
    flat: Vec<f64>,
) -> PyResult<Py<PyArray3<f64>>> {
    let array = Array3::from_shape_vec(shape, flat).map_err(our_mistake)?.into_pyarray(py);
    array.call_method1("setflags", (false,))?;
    Ok(array.unbind())
}

/// The same for detections.
pub fn array2(
    py: Python<'_>,
    shape: (usize, usize),
    flat: Vec<bool>,
) -> PyResult<Py<PyArray2<bool>>> {
    let array = Array2::from_shape_vec(shape, flat).map_err(our_mistake)?.into_pyarray(py);
    array.call_method1("setflags", (false,))?;
    Ok(array.unbind())
}
