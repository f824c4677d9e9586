//! Pictures, which a notebook shows.

use std::path::PathBuf;

use pyo3::prelude::*;
use rsrs_render::picture_file::PictureFile;

use crate::error::raised;

/// A picture as SVG, which a notebook shows.
#[pyclass(name = "Picture", module = "rsrs", frozen)]
pub struct Picture {
    svg: String,
}

impl Picture {
    pub fn new(svg: String) -> Self {
        Self { svg }
    }
}

#[pymethods]
impl Picture {
    /// The picture as text.
    #[getter]
    pub fn svg(&self) -> &str {
        &self.svg
    }
    /// Writes it into a file, whose name ends in .svg, .png or .pdf.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| PictureFile::new(&path)?.write(&self.svg));
        written.map_err(raised)
    }
    fn _repr_svg_(&self) -> &str {
        &self.svg
    }
    fn __repr__(&self) -> String {
        format!("Picture(SVG of {} kB; show it in a notebook, or save it)", self.svg.len() / 1000)
    }
}
