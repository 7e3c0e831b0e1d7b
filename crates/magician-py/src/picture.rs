//! Pictures, and what pen and laser have left.

use magician::Error;
use magician::sim::world::{Drawing, StrokeKind};
use magician_program::preview;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::program::numbers;

/// A picture.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Picture {
    svg: String,
}

impl Picture {
    pub(crate) fn new(svg: String) -> Self {
        Self { svg }
    }
}

/// As often a scale is halved for a picture that would be too large.
const HALVINGS: u32 = 4;

/// The picture at a scale, or smaller if that would be too large.
fn fitting<E: std::fmt::Display>(
    scale: f64,
    draw: impl Fn(f64) -> Result<Vec<u8>, E>,
) -> Result<Vec<u8>, Error> {
    let mut made = draw(scale);
    for halving in 1..=HALVINGS {
        if made.is_ok() {
            break;
        }
        made = draw(scale / f64::from(1 << halving));
    }
    made.map_err(|error| Error::invalid(error.to_string()))
}

#[pymethods]
impl Picture {
    #[getter]
    fn svg(&self) -> &str {
        &self.svg
    }

    fn png<'py>(&self, py: Python<'py>, scale: f64) -> PyResult<Bound<'py, PyBytes>> {
        let png = py.detach(|| fitting(scale, |scale| preview::to_png(&self.svg, scale)));
        let png = png.map_err(|error| errors::raise(py, &error))?;
        Ok(PyBytes::new(py, &png))
    }
}

/// What pen and laser have left.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Ink {
    drawing: Drawing,
}

impl Ink {
    pub(crate) fn new(drawing: Drawing) -> Self {
        Self { drawing }
    }
}

#[pymethods]
impl Ink {
    fn svg(&self, py: Python<'_>) -> String {
        py.detach(|| self.drawing.to_svg())
    }

    fn png<'py>(&self, py: Python<'py>, scale: f64) -> PyResult<Bound<'py, PyBytes>> {
        let png = py.detach(|| fitting(scale, |scale| self.drawing.to_png(scale)));
        let png = png.map_err(|error| errors::raise(py, &error))?;
        Ok(PyBytes::new(py, &png))
    }

    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        self.drawing.bounds()
    }

    fn __len__(&self) -> usize {
        self.drawing.strokes().len()
    }

    /// A stroke: whether it is burnt, its power, its points as bytes.
    fn stroke<'py>(
        &self,
        py: Python<'py>,
        at: usize,
    ) -> PyResult<(bool, f64, Bound<'py, PyBytes>)> {
        let stroke = self.drawing.strokes().get(at);
        let stroke = stroke.ok_or_else(|| PyIndexError::new_err("there is no such stroke"))?;
        let points = numbers(py, stroke.points.as_flattened());
        Ok((stroke.kind == StrokeKind::Burn, stroke.power, points))
    }
}
