//! Pictures, and what pen and laser have left.

use std::hash::{DefaultHasher, Hash, Hasher};

use magician::Error;
use magician::sim::world::{Drawing, Stroke, StrokeKind};
use magician_program::preview;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::errors;
use crate::program::{floats, numbers};

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
    #[new]
    fn of(svg: String) -> Self {
        Self::new(svg)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (String,)) {
        (slf.get_type().into_any(), (slf.get().svg.clone(),))
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyDict>) -> Py<Self> {
        slf
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.svg == other.svg
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.svg.hash(&mut hasher);
        hasher.finish()
    }

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

/// A stroke: whether it is burnt, its power, its points as bytes.
type StrokeParts<'py> = (bool, f64, Bound<'py, PyBytes>);

impl Ink {
    fn parts<'py>(py: Python<'py>, stroke: &Stroke) -> StrokeParts<'py> {
        let points = numbers(py, stroke.points.as_flattened());
        (stroke.kind == StrokeKind::Burn, stroke.power, points)
    }
}

#[pymethods]
impl Ink {
    /// A drawing of these strokes.
    #[new]
    fn of(strokes: Vec<(bool, f64, Vec<u8>)>) -> Self {
        let strokes = strokes.into_iter().map(|(burnt, power, points)| Stroke {
            kind: match burnt {
                true => StrokeKind::Burn,
                false => StrokeKind::Ink,
            },
            power,
            points: floats(&points).as_chunks::<2>().0.to_vec(),
        });
        Self::new(Drawing::from(strokes.collect::<Vec<_>>()))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (Vec<StrokeParts<'py>>,)) {
        let strokes = slf.get().drawing.strokes().iter();
        let strokes = strokes.map(|stroke| Self::parts(slf.py(), stroke));
        (slf.get_type().into_any(), (strokes.collect(),))
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyDict>) -> Py<Self> {
        slf
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.drawing.strokes() == other.drawing.strokes()
    }

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

    /// One of its strokes.
    fn stroke<'py>(&self, py: Python<'py>, at: usize) -> PyResult<StrokeParts<'py>> {
        let stroke = self.drawing.strokes().get(at);
        let stroke = stroke.ok_or_else(|| PyIndexError::new_err("there is no such stroke"))?;
        Ok(Self::parts(py, stroke))
    }
}
