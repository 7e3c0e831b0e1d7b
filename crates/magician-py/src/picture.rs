//! Pictures of plans and arms, and drawings that pen and laser have made.

use std::hash::{DefaultHasher, Hash, Hasher};

use magician::commands::{EndEffectorParams, Pose};
use magician::sim::world::{Drawing, Stroke, StrokeKind};
use magician::{Geometry, JointAngles, ToolBias};
use magician_picture::{
    ArmView, DrawingOptions, PictureError, Snapshot, drawing_png, drawing_svg, fitting, to_png,
};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::call::Call;
use crate::core::Core;
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
        let too_large = |error: &_| matches!(error, PictureError::Size(_));
        let png = py.detach(|| fitting(scale, too_large, |scale| to_png(&self.svg, scale)));
        let png = png.map_err(|error| errors::raise(py, &error.into()))?;
        Ok(PyBytes::new(py, &png))
    }
}

#[pymethods]
impl Core {
    /// Draws the arm in its current pose.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let look = async move {
            let pose = arm.get::<Pose>().await?;
            let bias = arm.get::<EndEffectorParams>().await?;
            let mut view = ArmView::default();
            view.title = format!("Arm at {}", arm.name());
            view.joints = pose.joint_angle.map(f64::from).into();
            let [x, y, z] = [bias.x_bias, bias.y_bias, bias.z_bias].map(f64::from);
            view.tool = ToolBias::new(x, y, z);
            view.alarms = arm.alarms().await?;
            let index = arm.queue().current_index().await?;
            view.facts = vec![format!("queue index {} finished", index.0)];
            Ok::<_, magician::Error>(view)
        };
        Ok(Call::start(look, |py, view| {
            let svg = Snapshot::of_arm(&view).to_svg().to_owned();
            Ok(Py::new(py, Picture::new(svg))?.into_any())
        }))
    }
}

/// Draws an arm with the given reported pose.
#[pyfunction]
pub(crate) fn draw_arm(
    py: Python<'_>,
    title: &str,
    pose: [f64; 4],
    joints: [f64; 4],
    alarms: Vec<u8>,
    facts: Vec<String>,
) -> Picture {
    let mut view = ArmView::default();
    view.title = title.to_owned();
    view.joints = joints.into();
    view.tool = tool_bias(&view.joints, pose);
    for code in alarms {
        view.alarms.insert(code);
    }
    view.facts = facts;
    Picture::new(py.detach(|| Snapshot::of_arm(&view).to_svg().to_owned()))
}

/// Computes the tool bias from joint angles and the pose of the tip.
fn tool_bias(joints: &JointAngles, [x, y, z, _]: [f64; 4]) -> ToolBias {
    let wrist = Geometry::default().forward(joints);
    let (sin, cos) = joints.j1.to_radians().sin_cos();
    let [dx, dy] = [x - wrist.x, y - wrist.y];
    ToolBias::new(dx * cos + dy * sin, dy * cos - dx * sin, wrist.z - z)
}

/// Strokes of pen and laser.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Ink {
    drawing: Drawing,
}

impl Ink {
    pub(crate) fn new(drawing: Drawing) -> Self {
        Self { drawing }
    }
}

/// Stroke: true if burnt, power, points as bytes.
type StrokeParts<'py> = (bool, f64, Bound<'py, PyBytes>);

impl Ink {
    fn parts<'py>(py: Python<'py>, stroke: &Stroke) -> StrokeParts<'py> {
        let points = numbers(py, stroke.points.as_flattened());
        (stroke.kind == StrokeKind::Burn, stroke.power, points)
    }
}

#[pymethods]
impl Ink {
    /// Creates a drawing from strokes.
    #[new]
    fn of(strokes: Vec<(bool, f64, Vec<u8>)>) -> Self {
        let strokes = strokes.into_iter().map(|(burnt, power, points)| Stroke {
            kind: if burnt {
                StrokeKind::Burn
            } else {
                StrokeKind::Ink
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

    fn svg(&self, py: Python<'_>, whole: bool) -> String {
        let options = DrawingOptions::default().whole(whole);
        py.detach(|| drawing_svg(&self.drawing, &options))
    }

    fn png<'py>(&self, py: Python<'py>, scale: f64, whole: bool) -> PyResult<Bound<'py, PyBytes>> {
        let too_large = |error: &_| matches!(error, PictureError::Size(_));
        let options = DrawingOptions::default().whole(whole);
        let draw = |scale| drawing_png(&self.drawing, scale, &options);
        let png = py.detach(|| fitting(scale, too_large, draw));
        let png = png.map_err(|error| errors::raise(py, &error.into()))?;
        Ok(PyBytes::new(py, &png))
    }

    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        self.drawing.bounds()
    }

    fn __len__(&self) -> usize {
        self.drawing.strokes().len()
    }

    /// Returns one stroke.
    fn stroke<'py>(&self, py: Python<'py>, at: usize) -> PyResult<StrokeParts<'py>> {
        let stroke = self.drawing.strokes().get(at);
        let stroke = stroke.ok_or_else(|| PyIndexError::new_err("there is no such stroke"))?;
        Ok(Self::parts(py, stroke))
    }
}
