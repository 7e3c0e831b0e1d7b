//! Forward and inverse kinematics and reach, for whole arrays, with the interpreter's lock
//! released.

use magician::{ArmModel, Error, Geometry, JointAngles, ToolBias};
use magician_motion::Pose;
use magician_program::{Reach, Surface};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::program::floats;

/// Row of an array: a pose, or four joint angles.
type Row = [f64; 4];

/// Rows as bytes, and one byte per row: 1 if the arm can reach it.
type RowsAndReach<'py> = (Bound<'py, PyBytes>, Bound<'py, PyBytes>);

fn geometry([x, y, z]: [f64; 3]) -> Geometry {
    Geometry::magician(ToolBias::new(x, y, z))
}

/// Reads rows of up to four columns. A missing fourth gets the value `last`.
fn rows(bytes: &[u8], columns: usize, last: f64) -> Vec<Row> {
    let numbers = floats(bytes);
    let row = |row: &[f64]| {
        let mut whole = [0.0, 0.0, 0.0, last];
        for (value, number) in whole.iter_mut().zip(row) {
            *value = *number;
        }
        whole
    };
    // `chunks_exact` panics for 0 columns.
    numbers.chunks_exact(columns.max(1)).map(row).collect()
}

/// Applies `judge` to each row: the result, and true if the arm can reach it.
fn apply_to_rows<'py>(
    py: Python<'py>,
    rows: Vec<Row>,
    judge: impl Fn(Row) -> (Row, bool) + Send + Sync,
) -> RowsAndReach<'py> {
    let (values, reached) = py.detach(|| {
        let mut values = Vec::with_capacity(rows.len().saturating_mul(32));
        let mut reached = Vec::with_capacity(rows.len());
        for row in rows {
            let (row, is_reached) = judge(row);
            // Adding 0.0 turns -0.0 into 0.0.
            values.extend(row.iter().flat_map(|value| (value + 0.0).to_ne_bytes()));
            reached.push(u8::from(is_reached));
        }
        (values, reached)
    });
    (PyBytes::new(py, &values), PyBytes::new(py, &reached))
}

/// Computes poses from rows of joint angles, also beyond the joint limits. Rows with an angle that
/// is not finite become NaN.
#[pyfunction]
pub(crate) fn forward<'py>(py: Python<'py>, joints: &[u8], tool: [f64; 3]) -> RowsAndReach<'py> {
    let (geometry, limits) = (geometry(tool), ArmModel::MAGICIAN.limits);
    apply_to_rows(py, rows(joints, 4, 0.0), |row| {
        let joints = JointAngles::from(row);
        if joints.is_finite() {
            let pose = geometry.forward(&joints).to_array();
            (pose, limits.check(&joints).is_ok())
        } else {
            ([f64::NAN; 4], false)
        }
    })
}

/// Computes joint angles from rows of x, y, z and optionally r. Unreachable rows become NaN.
#[pyfunction]
pub(crate) fn inverse<'py>(
    py: Python<'py>,
    poses: &[u8],
    columns: usize,
    r: f64,
    tool: [f64; 3],
) -> RowsAndReach<'py> {
    let (geometry, limits) = (geometry(tool), ArmModel::MAGICIAN.limits);
    apply_to_rows(py, rows(poses, columns, r), |row| {
        match geometry.inverse_within(&Pose::from(row), &limits) {
            Ok(joints) => (joints.to_array(), true),
            Err(_) => ([f64::NAN; 4], false),
        }
    })
}

/// Computes the joint angles of one pose.
///
/// # Errors
/// `magician.errors.UnreachableError` with the limit in the way and both values.
#[pyfunction]
pub(crate) fn inverse_of(py: Python<'_>, pose: Row, tool: [f64; 3]) -> PyResult<Row> {
    let limits = ArmModel::MAGICIAN.limits;
    let joints = geometry(tool).inverse_within(&Pose::from(pose), &limits);
    let joints = joints.map_err(|error| errors::raise(py, &Error::from(error)))?;
    Ok(joints.to_array().map(|angle| angle + 0.0))
}

/// Computes the boundary of the reach of the tool tip at a height, as closed polygons: rows of x
/// and y.
#[pyfunction]
pub(crate) fn reach(py: Python<'_>, z: f64, r: f64, tool: [f64; 3]) -> Vec<Bound<'_, PyBytes>> {
    let [x, y, height] = tool;
    let rings = py.detach(|| {
        let reach = Reach::new(ToolBias::new(x, y, height), Surface::level(z), 0.0);
        reach.rotated_to(r).outline()
    });
    let bytes = |ring: Vec<[f64; 2]>| -> Vec<u8> {
        let numbers = ring.into_iter().flatten();
        numbers.flat_map(f64::to_ne_bytes).collect()
    };
    let rings = rings.into_iter().map(bytes);
    rings.map(|ring| PyBytes::new(py, &ring)).collect()
}
