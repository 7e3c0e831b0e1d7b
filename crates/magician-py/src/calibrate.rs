//! Calibration of sheet and tool tip from touched points, stored in the settings file.

use magician::{Error, ToolBias};
use magician_job::settings::{SettingsError, SettingsFile, quoted};
use magician_job::surface_of;
use magician_program::artwork::Sheet;
use magician_program::{Tip, Tool, rounded_height};
use pyo3::prelude::*;

use crate::{errors, program};

/// Corner, rotation, height of the surface, slope of the surface, and size of a sheet.
type SheetParts = (Pair, f64, f64, Pair, Option<Pair>);
/// Two numbers, a tuple in Python.
type Pair = (f64, f64);
/// Stored settings: sheet, height and slope of the surface, and tool.
type StoredSettings = (Option<SheetParts>, Option<(f64, Pair)>, Option<String>);

/// Computes the sheet from its touched lower left, lower right and upper left corners.
#[pyfunction]
pub(crate) fn sheet_from_touches(py: Python<'_>, corners: [[f64; 3]; 3]) -> PyResult<SheetParts> {
    let sheet = Sheet::touched(corners).map_err(|problem| program::raise(py, None, &problem))?;
    Ok(sheet_parts(&sheet))
}

fn sheet_parts(sheet: &Sheet) -> SheetParts {
    let surface = sheet.surface;
    (
        sheet.corner.into(),
        sheet.rotation,
        surface.height,
        surface.slope.into(),
        sheet.size.map(Pair::from),
    )
}

/// Computes the tool tip from two touches of one point, between which the tool was rotated. Returns
/// the offset of the tip and the new bias.
#[pyfunction]
pub(crate) fn tip_from_touches(
    py: Python<'_>,
    touches: [[f64; 3]; 2],
    bias: [f64; 3],
) -> PyResult<(Pair, (f64, f64, f64))> {
    let [x, y, z] = bias;
    let tip = Tip::touched(touches, ToolBias::new(x, y, z));
    let tip = tip.map_err(|problem| program::raise(py, None, &problem))?;
    Ok((tip.offset.into(), (tip.bias.x, tip.bias.y, tip.bias.z)))
}

/// Converts an error of the settings file.
fn settings_error(py: Python<'_>, error: &SettingsError) -> PyErr {
    errors::raise(py, &Error::invalid(error.to_string()))
}

/// Applies an edit to the settings file. Returns the path of the file, or `None` if the system has
/// no place for it.
fn edit_settings(
    py: Python<'_>,
    edit: impl Fn(&SettingsFile) -> Option<SettingsFile> + Send + Sync,
) -> PyResult<Option<String>> {
    let outcome = py.detach(|| {
        let mut file = SettingsFile::load()?;
        let edited = edit(&file);
        file.change(edited)?;
        Ok(file.path().map(|path| path.display().to_string()))
    });
    outcome.map_err(|error| settings_error(py, &error))
}

/// Saves a sheet given by its touched corners.
#[pyfunction]
pub(crate) fn save_sheet(py: Python<'_>, corners: [[f64; 3]; 3]) -> PyResult<Option<String>> {
    let sheet = Sheet::touched(corners).map_err(|problem| program::raise(py, None, &problem))?;
    edit_settings(py, |file| file.with_table("sheet", &sheet.rounded()))
}

/// Saves the height of a level surface.
#[pyfunction]
pub(crate) fn save_surface(py: Python<'_>, height: f64) -> PyResult<Option<String>> {
    let height = rounded_height(height).to_string();
    edit_settings(py, |file| file.with("surface", &height))
}

/// Saves the tool tip given by two touches of one point.
#[pyfunction]
pub(crate) fn save_tip(
    py: Python<'_>,
    touches: [[f64; 3]; 2],
    bias: [f64; 3],
) -> PyResult<Option<String>> {
    let [x, y, z] = bias;
    let tip = Tip::touched(touches, ToolBias::new(x, y, z));
    let tip = tip.map_err(|problem| program::raise(py, None, &problem))?;
    let [x, y, z] = tip.rounded_bias();
    let tool = quoted(&format!("{x},{y},{z}"));
    edit_settings(py, |file| file.with("tool", &tool))
}

/// Returns the calibration in the settings file. `MAGICIAN_TOOL` overrides its tool.
#[pyfunction]
pub(crate) fn stored_settings(py: Python<'_>) -> PyResult<StoredSettings> {
    let read = || -> Result<_, SettingsError> {
        let file = SettingsFile::load()?;
        let sheet = file.value::<Sheet>("sheet")?;
        let tool = file.value::<String>("tool")?;
        Ok((sheet, surface_of(&file)?, tool))
    };
    let (sheet, surface, tool) = py
        .detach(read)
        .map_err(|error| settings_error(py, &error))?;
    let tool = tool_of(py, tool)?.map(|tool| tool.to_string());
    let surface = surface.map(|surface| (surface.height, surface.slope.into()));
    Ok((sheet.map(|sheet| sheet_parts(&sheet)), surface, tool))
}

/// Default tool from the environment or the settings file. `None` if neither has one.
pub(crate) fn default_tool(py: Python<'_>) -> PyResult<Option<Tool>> {
    let read = || SettingsFile::load()?.value::<String>("tool");
    let tool = py
        .detach(read)
        .map_err(|error| settings_error(py, &error))?;
    tool_of(py, tool)
}

/// Parses the default tool. `MAGICIAN_TOOL` overrides the one of the settings file.
fn tool_of(py: Python<'_>, tool: Option<String>) -> PyResult<Option<Tool>> {
    let environment = std::env::var("MAGICIAN_TOOL").ok();
    let tool = environment.filter(|tool| !tool.is_empty()).or(tool);
    let tool = tool.map(|tool| tool.parse::<Tool>());
    tool.transpose().map_err(|why| {
        let message = format!("the tool of the settings: {why}");
        errors::raise(py, &Error::invalid(message))
    })
}
