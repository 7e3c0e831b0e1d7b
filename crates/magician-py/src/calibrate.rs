//! The sheet and the tool's tip from points that were touched.

use magician::ToolBias;
use magician_program::Tip;
use magician_program::artwork::Sheet;
use pyo3::prelude::*;

use crate::program;

/// A sheet: its corner, its rotation, height and slope of its surface, its size.
type SheetParts = (Pair, f64, f64, Pair, Option<Pair>);
/// Two numbers, as a tuple of Python's.
type Pair = (f64, f64);

/// The sheet whose lower left, lower right and upper left corner were touched.
#[pyfunction]
pub(crate) fn touched_sheet(py: Python<'_>, corners: [[f64; 3]; 3]) -> PyResult<SheetParts> {
    let sheet = Sheet::touched(corners).map_err(|problem| program::raise(py, None, &problem))?;
    let surface = sheet.surface;
    Ok((
        sheet.corner.into(),
        sheet.rotation,
        surface.height,
        surface.slope.into(),
        sheet.size.map(Pair::from),
    ))
}

/// The tip that touched one point twice, turned in between: its offset, and the bias to set.
#[pyfunction]
pub(crate) fn touched_tip(
    py: Python<'_>,
    touches: [[f64; 3]; 2],
    bias: [f64; 3],
) -> PyResult<(Pair, (f64, f64, f64))> {
    let [x, y, z] = bias;
    let tip = Tip::touched(touches, ToolBias::new(x, y, z));
    let tip = tip.map_err(|problem| program::raise(py, None, &problem))?;
    Ok((tip.offset.into(), (tip.bias.x, tip.bias.y, tip.bias.z)))
}
