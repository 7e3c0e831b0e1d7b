//! Pictures, and what pen and laser have left.

use magician::Error;
use magician::sim::world::{self, Drawing, StrokeKind};
use magician_program::preview::{PictureError, fitting, to_png};
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

#[pymethods]
impl Picture {
    #[getter]
    fn svg(&self) -> &str {
        &self.svg
    }

    fn png<'py>(&self, py: Python<'py>, scale: f64) -> PyResult<Bound<'py, PyBytes>> {
        let too_large = |error: &_| matches!(error, PictureError::Size(_));
        let png = py.detach(|| fitting(scale, too_large, |scale| to_png(&self.svg, scale)));
        let png = png.map_err(|error| errors::raise(py, &error.into()))?;
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
        let too_large = |error: &_| matches!(error, world::PictureError::Size { .. });
        let png = py.detach(|| fitting(scale, too_large, |scale| self.drawing.to_png(scale)));
        let invalid = |error: world::PictureError| Error::invalid(error.to_string());
        let png = png.map_err(|error| errors::raise(py, &invalid(error)))?;
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
