//! Size and place of an image to engrave.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::placed::ROUNDED;
use super::{Laid, Setup};
use crate::artwork::{Layout, Marking, rotated};
use crate::raster::{Engrave, Grid};
use crate::{Diagnostic, DiagnosticCode, Raster, Tool};

/// Rounding error of a speed stored as a 32-bit float, mm/s.
const SPEED_ROUNDING: f64 = 1e-5;

impl Setup {
    /// Plan that engraves an image.
    pub(super) fn engraved(
        &self,
        image: &Raster,
        engrave: Engrave,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<Laid, Diagnostic> {
        let mut engrave = self.engraving(engrave);
        let steady = engrave.steady_speed();
        if self.said_laser_speed().is_none() {
            engrave.speed = engrave.speed.min(steady);
        } else if engrave.speed > steady + SPEED_ROUNDING {
            notes.push(uneven(&engrave, steady));
        }
        let surface = self.needed_surface()?;
        let natural = image.size(self.size)?;
        let size = natural.map(|side| side * self.placement.scale);
        let tool = self.tool_for(Tool::Laser);
        let grid = self.grid(size, &engrave, tool)?;
        let mut plan = engrave.plan(image, &grid, surface)?;
        plan.tool = Some(tool);
        let [width, _] = grid.size();
        Ok(Laid {
            plan: self.pushed(plan, &mut Vec::new())?,
            scale: width / natural[0],
            misfit: None,
        })
    }

    /// Place of an image: as requested, on the sheet, or where there is room.
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
        let taken = taken(&layout, size);
        let share = room.map_or(1.0, |room| {
            let shares = [0, 1].map(|axis: usize| room[axis] / taken[axis]);
            shares.into_iter().fold(1.0, f64::min)
        });
        let size = size.map(|side| share * side);
        if !layout.fit
            && let Some((at, turn)) = said_place(&layout, size)?
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
fn uneven(engrave: &Engrave, steady: f64) -> Diagnostic {
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

/// Requested middle and rotation of an image. On a sheet its lower left corner is on that of the
/// sheet.
fn said_place(layout: &Layout, size: [f64; 2]) -> Result<Option<([f64; 2], f64)>, Diagnostic> {
    let Some(sheet) = layout.sheet else {
        return Ok(layout.at.map(|at| (at, layout.rotate)));
    };
    let turn = layout.rotate + sheet.rotation;
    if let Some(at) = layout.at {
        return Ok(Some((at, turn)));
    }
    let taken = taken(layout, size);
    if let Some(room) = sheet.size
        && taken
            .iter()
            .zip(room)
            .any(|(side, room)| side - ROUNDED > room)
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
fn taken(layout: &Layout, [width, height]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = libm::sincos(layout.rotate.to_radians());
    [[cos, sin], [sin, cos]].map(|[x, y]| width * x.abs() + height * y.abs())
}
