//! What the commands print with `--format json` as Python's dictionaries and lists, and the keys of files
//! as Python's values.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use rsrs_core::quantity::{Axis, Cell};
use serde::Serialize;

use crate::error::{our_mistake, refused};

/// As Python's own `json` reads it.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(our_mistake)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// The keys of a file as its text.
pub fn keys_as_text(keys: &Bound<'_, PyDict>) -> PyResult<String> {
    let text = keys.py().import("rsrs._keys")?.call_method1("text", (keys,));
    text.map_err(|error| refused(error.value(keys.py())))?.extract()
}

/// An axis by its name.
pub fn axis(key: &str) -> PyResult<Axis> {
    key.parse().map_err(refused)
}

/// A cell, as a dictionary of values by axis or as on the command line: `"speed_m_s=0.15,robots=9"`.
pub fn cell(value: &Bound<'_, PyAny>) -> PyResult<Cell> {
    if let Ok(text) = value.cast::<PyString>() {
        return text.to_str()?.parse().map_err(refused);
    }
    let dict = value.cast::<PyDict>().map_err(|_| {
        refused("a cell is a dictionary of values by axis, or text such as \"speed_m_s=0.15\"")
    })?;
    let values = dict.iter().map(|(key, value)| {
        let key: String = key.extract()?;
        let number = value
            .extract()
            .map_err(|_| refused(format!("{key}: expected a number, found {value}")));
        Ok((axis(&key)?, number?))
    });
    Cell::new(values.collect::<PyResult<Vec<(Axis, f64)>>>()?).map_err(refused)
}
