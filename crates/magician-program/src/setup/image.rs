//! Size and place of an image to engrave.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::placed::SHEET_TOLERANCE;
use super::{LaidPlan, Setup};
use crate::artwork::{Layout, Marking, rotated};
use crate::raster::{Engrave, Grid};
use crate::{Diagnostic, DiagnosticCode, Raster, Tool};

/// Rounding error of a speed stored as a 32-bit float, mm/s.
const SPEED_ROUNDING: f64 = 1e-5;

impl Setup {
    /// Plan that engraves an image.
    pub(super) fn engrave_image(
        &self,
        image: &Raster,
        engrave: Engrave,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<LaidPlan, Diagnostic> {
        let mut engrave = self.with_given_speed(engrave);
        let steady = engrave.steady_speed();
        if self.given_laser_speed().is_none() {
            engrave.speed = engrave.speed.min(steady);
        } else if engrave.speed > steady + SPEED_ROUNDING {
            notes.push(uneven_note(&engrave, steady));
        }
        let surface = self.needed_surface()?;
        let natural = image.size(self.size)?;
        let size = natural.map(|side| side * self.placement.scale);
        let tool = self.tool_for(Tool::Laser);
        let grid = self.grid(size, &engrave, tool)?;
        let mut plan = engrave.plan(image, &grid, surface)?;
        plan.tool = Some(tool);
        let [width, _] = grid.size();
        Ok(LaidPlan {
            plan: self.with_offset(plan, &mut Vec::new())?,
            scale: width / natural[0],
            misfit: None,
        })
    }

    /// Place of an image: the requested place, else on the sheet, else where the reach has room.
    pub(super) fn grid(
        &self,
        size: [f64; 2],
        engrave: &Engrave,
        tool: Tool,
    ) -> Result<Grid, Diagnostic> {
        let mut layout = Layout {
            scale: 1.0,
            ..self.layout()?
        };
        // The burnt area stays within the page; the overscan may exceed it.
        let room = layout.room.take().filter(|_| layout.fit);
        let taken = occupied_size(&layout, size);
        let share = room.map_or(1.0, |room| {
            let shares = [0, 1].map(|axis: usize| room[axis] / taken[axis]);
            shares.into_iter().fold(1.0, f64::min)
        });
        let size = size.map(|side| share * side);
        if !layout.fit
            && let Some((at, turn)) = given_place(&layout, size)?
        {
            return Ok(Grid::centred(size, at, turn, layout.mirror));
        }
        let marking = Marking {
            tool,
            lift: engrave.lift,
            ..Marking::laser(0.0)
        };
        engrave.placed(size, |frame| {
            let placed = frame.placed(&layout, &marking)?;
            Ok((placed.artwork, placed.scale))
        })
    }
}

/// Note that the speed is above the highest at which every pixel burns evenly, mm/s.
fn uneven_note(engrave: &Engrave, steady: f64) -> Diagnostic {
    let slower = ((steady + SPEED_ROUNDING) * 1000.0).floor() / 1000.0;
    let message = message!(
        "at {speed} mm/s pixels of {spacing} mm are burnt unevenly: the arm holds at most {slower} mm/s where each differs from the next",
        speed = engrave.speed,
        spacing = engrave.spacing,
        slower
    );
    Diagnostic::of_file(message)
        .coded(DiagnosticCode::Speed)
        .remedy(
            (Setting::Speed, SettingValue::Number(slower)),
            "burns them evenly",
        )
}

/// Requested middle and rotation of an image. On a sheet, the lower left corners of image and sheet
/// coincide.
fn given_place(layout: &Layout, size: [f64; 2]) -> Result<Option<([f64; 2], f64)>, Diagnostic> {
    let Some(sheet) = layout.sheet else {
        return Ok(layout.at.map(|at| (at, layout.rotate)));
    };
    let turn = layout.rotate + sheet.rotation;
    if let Some(at) = layout.at {
        return Ok(Some((at, turn)));
    }
    let taken = occupied_size(layout, size);
    if let Some(room) = sheet.size
        && taken
            .iter()
            .zip(room)
            .any(|(side, room)| side - SHEET_TOLERANCE > room)
    {
        let shown = |[width, height]: [f64; 2]| format!("{width:.1} x {height:.1} mm");
        let message = message!(
            "the image is {taken}, and the sheet {room}",
            taken = shown(taken),
            room = shown(room)
        );
        return Err(Diagnostic::of_file(message)
            .remedy(
                (Setting::Width, SettingValue::Any("MM")),
                "makes it smaller",
            )
            .remedy(
                (Setting::Fit, SettingValue::On),
                "makes it as small as need be",
            ));
    }
    let half = rotated(taken.map(|side| side / 2.0), sheet.rotation);
    let at = [0, 1].map(|axis| sheet.corner[axis] + half[axis]);
    Ok(Some((at, turn)))
}

/// Width and height that a rotated image occupies along the sheet.
fn occupied_size(layout: &Layout, [width, height]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = libm::sincos(layout.rotate.to_radians());
    [[cos, sin], [sin, cos]].map(|[x, y]| width * x.abs() + height * y.abs())
}
