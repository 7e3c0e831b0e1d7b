//! Plans from arrays of points.
//!
//! Each row becomes a separate move, or a vertex of a continuous path. Rows of NaN are gaps,
//! which separate paths. A path is approached from above and left upwards.

use magician::{Error, build};
use magician_program::{Action, Diagnostic, Origin, Plan, Travel};
use pyo3::prelude::*;

use super::{PyPlan, Source, surface, tool};
use crate::errors;

/// Options for the conversion.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct PointOptions {
    title: String,
    tool: Option<String>,
    surface: Option<(f64, [f64; 2])>,
    /// `path`, `joints`, `line` or `jump`.
    by: String,
    /// Rotation for points without one, deg.
    r: f64,
    /// Height above its ends at which a path is approached and left, mm.
    lift: f64,
    /// Speed along a path, mm/s.
    speed: Option<f64>,
    /// Acceleration along a path, mm/s2.
    acceleration: f64,
    /// Laser power, percent.
    power: Option<f64>,
}

#[pymethods]
impl PyPlan {
    /// Creates a plan from rows of 3 or 4 numbers, with a power per row unless `powers` is empty.
    #[staticmethod]
    fn of_points(
        py: Python<'_>,
        points: &[u8],
        columns: usize,
        powers: &[u8],
        options: PointOptions,
    ) -> PyResult<Self> {
        let bad = |problem: Diagnostic| super::raise(py, None, &problem);
        let tool = tool(py, options.tool.as_deref())?;
        let by = travel(&options.by).ok_or_else(|| {
            let text = format!(
                "unknown by `{}`: it is path, line, joints or jump",
                options.by
            );
            errors::raise(py, &Error::invalid(text))
        })?;
        let plan = py.detach(|| {
            let rows = rows(points, columns, &options)?;
            let powers = floats(powers);
            check_powers(&rows, &powers, &options)?;
            let mut plan = Plan::new(options.title.clone());
            (plan.tool, plan.surface) = (tool, surface(options.surface));
            match by {
                Some(by) => moves(&mut plan, &rows, by)?,
                None => paths(&mut plan, &rows, &powers, &options)?,
            }
            Ok(plan)
        });
        let source = Source {
            rows: true,
            ..Source::default()
        };
        Ok(Self::of(plan.map_err(bad)?, source))
    }
}

/// Parses a kind of travel. `Some(None)` is a continuous path, `None` an unknown name.
fn travel(name: &str) -> Option<Option<Travel>> {
    Some(match name {
        "path" => None,
        "joints" => Some(Travel::Joints),
        "line" => Some(Travel::Line),
        "jump" => Some(Travel::Jump),
        _ => return None,
    })
}

/// Decodes numbers from the bytes of an array.
pub(crate) fn floats(bytes: &[u8]) -> Vec<f64> {
    let items = bytes.as_chunks::<8>().0.iter();
    items.map(|item| f64::from_ne_bytes(*item)).collect()
}

/// Converts rows to positions. `None` for a gap.
fn rows(
    points: &[u8],
    columns: usize,
    options: &PointOptions,
) -> Result<Vec<Option<[f32; 4]>>, Diagnostic> {
    let numbers = floats(points);
    let row = |(nth, row): (usize, &[f64])| {
        if row.iter().all(|number| number.is_nan()) {
            return Ok(None);
        }
        let mut point = [0.0, 0.0, 0.0, options.r as f32];
        for (value, number) in point.iter_mut().zip(row) {
            *value = *number as f32;
        }
        match point.iter().position(|value| !value.is_finite()) {
            None => Ok(Some(point)),
            Some(at) => {
                let name = ["x", "y", "z", "r"].get(at).copied().unwrap_or_default();
                let found = row.get(at).copied().unwrap_or(f64::NAN);
                Err(Diagnostic::of_file(format!(
                    "row {nth}: {name} is {found}, which is not a position"
                )))
            }
        }
    };
    numbers
        .chunks_exact(columns.max(1))
        .enumerate()
        .map(row)
        .collect()
}

/// Origin of a row.
fn origin(nth: usize) -> Origin {
    Origin {
        line: u32::try_from(nth.saturating_add(1)).unwrap_or(u32::MAX),
        ..Origin::NONE
    }
}

/// Checks powers: 0 to 100 percent, and only for paths.
fn check_powers(
    rows: &[Option<[f32; 4]>],
    powers: &[f64],
    options: &PointOptions,
) -> Result<(), Diagnostic> {
    if options.by != "path" && (options.power.is_some() || !powers.is_empty()) {
        let text = format!("power is for by=\"path\", not for by=\"{}\"", options.by);
        return Err(Diagnostic::of_file(text));
    }
    let is_none = |power: &f64| !(0.0..=100.0).contains(power);
    let mut powers = rows.iter().zip(powers).enumerate();
    match powers.find(|(_, (row, power))| row.is_some() && is_none(power)) {
        None => Ok(()),
        Some((nth, (_, power))) => Err(Diagnostic::of_file(format!(
            "row {nth}: power is {power} %; it is a number from 0 to 100"
        ))),
    }
}

/// Appends a move for each row.
fn moves(plan: &mut Plan, rows: &[Option<[f32; 4]>], by: Travel) -> Result<(), Diagnostic> {
    for (nth, row) in rows.iter().enumerate() {
        let Some(to) = *row else {
            let text = format!("row {nth} has no numbers; gaps are for paths");
            return Err(Diagnostic::of_file(text));
        };
        plan.push(Action::Move { to, by }, origin(nth));
    }
    Ok(())
}

/// Appends continuous paths, one for each run of rows without a gap.
fn paths(
    plan: &mut Plan,
    rows: &[Option<[f32; 4]>],
    powers: &[f64],
    options: &PointOptions,
) -> Result<(), Diagnostic> {
    if let Some(speed) = options.speed {
        plan.push(
            build::path_speed(speed as f32, options.acceleration as f32),
            Origin::NONE,
        );
    }
    let mut begun = None;
    for (nth, row) in rows.iter().enumerate() {
        match (*row, begun) {
            (None, Some((last, r))) => {
                leave(plan, last, r, options, nth - 1);
                begun = None;
            }
            (None, None) => {}
            (Some([x, y, z, r]), None) => {
                approach(plan, [x, y, z], r, options, nth);
                begun = Some(([x, y, z], r));
            }
            (Some([x, y, z, r]), Some((last, first))) => {
                if r != first {
                    let text = format!(
                        "row {nth}: r is {r}, and {first} where this path begins; a continuous path does not turn the tool: \
                         keep r the same, or use by=\"line\""
                    );
                    return Err(Diagnostic::of_file(text));
                }
                let to = [x, y, z];
                // Skip a segment of zero length: the arm would stop there for nothing.
                if to != last {
                    plan.push(
                        segment(to, powers.get(nth).copied().or(options.power)),
                        origin(nth),
                    );
                }
                begun = Some((to, first));
            }
        }
    }
    if let Some((last, r)) = begun {
        leave(plan, last, r, options, rows.len() - 1);
    }
    Ok(())
}

fn segment(to: [f32; 3], power: Option<f64>) -> Action {
    match power {
        Some(power) => Action::Burn {
            to,
            power: power as f32,
        },
        None => Action::Path { to },
    }
}

/// Appends the approach to a path: first by joints to a point above its start, because the arm may
/// come from anywhere.
fn approach(plan: &mut Plan, [x, y, z]: [f32; 3], r: f32, options: &PointOptions, nth: usize) {
    let lift = options.lift as f32;
    let by = Travel::Joints;
    if lift > 0.0 {
        let to = [x, y, z + lift, r];
        plan.push(Action::Move { to, by }, origin(nth));
    }
    let by = if lift > 0.0 { Travel::Line } else { by };
    plan.push(
        Action::Move {
            to: [x, y, z, r],
            by,
        },
        origin(nth),
    );
}

fn leave(plan: &mut Plan, [x, y, z]: [f32; 3], r: f32, options: &PointOptions, nth: usize) {
    let lift = options.lift as f32;
    if lift > 0.0 {
        let by = Travel::Line;
        plan.push(
            Action::Move {
                to: [x, y, z + lift, r],
                by,
            },
            origin(nth),
        );
    }
}
