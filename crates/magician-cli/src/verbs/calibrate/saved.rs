//! Shows and forgets saved calibrations.

use clap::ValueEnum;
use magician_program::artwork::Sheet;
use serde::Serialize;

use super::answer::sheet_lines;
use crate::columns::Columns;
use crate::config::Config;
use crate::context::Context;
use crate::failure::Failure;
use crate::mounted::mounted_tool;

/// Calibration that can be deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Part {
    Sheet,
    Surface,
    Tool,
}

impl Part {
    const ALL: [Self; 3] = [Self::Sheet, Self::Surface, Self::Tool];

    fn name(self) -> &'static str {
        match self {
            Self::Sheet => "sheet",
            Self::Surface => "surface",
            Self::Tool => "tool",
        }
    }
}

#[derive(Serialize)]
struct SavedCalibrations {
    sheet: Option<Sheet>,
    surface: Option<f64>,
    tool: Option<String>,
}

#[derive(Serialize)]
struct Forgotten {
    forgotten: Vec<&'static str>,
}

pub(super) fn show(context: &mut Context) -> Result<(), Failure> {
    let config = Config::load()?;
    let known = SavedCalibrations {
        sheet: config.table("sheet")?,
        surface: config.surface()?.map(|surface| surface.height),
        tool: mounted_tool(&config)?.map(|tool| tool.to_string()),
    };
    context.show(&known, |out| {
        let mut columns = Columns::default();
        match &known.sheet {
            Some(sheet) => {
                for [name, value] in sheet_lines(sheet, None) {
                    columns.row(["sheet", &name, &value]);
                }
            }
            None => columns.row(["sheet", "not calibrated", "`magician calibrate sheet`"]),
        }
        match (known.surface, known.sheet) {
            (Some(height), None) => {
                columns.row(["surface", "height", &format!("z {height:.2} mm")])
            }
            (Some(height), Some(_)) => {
                let value = format!("z {height:.2} mm; the sheet's height takes precedence");
                columns.row(["surface", "height", &value]);
            }
            (None, _) => columns.row(["surface", "not calibrated", "`magician calibrate surface`"]),
        }
        match &known.tool {
            Some(tool) => columns.row(["tool", "bias", tool]),
            None => columns.row([
                "tool",
                "not set",
                "`magician calibrate tool`; drawings use the pen",
            ]),
        }
        columns.write(out)
    })
}

pub(super) fn forget(part: Option<Part>, context: &mut Context) -> Result<(), Failure> {
    let parts = part.map_or(Part::ALL.to_vec(), |part| vec![part]);
    let mut config = Config::load()?;
    let mut forgotten = Vec::new();
    for part in parts {
        if config.unset(part.name())? {
            forgotten.push(part.name());
        }
    }
    let forgotten = Forgotten { forgotten };
    context.show(&forgotten, |out| match forgotten.forgotten.as_slice() {
        [] => out.line("nothing was calibrated"),
        names => out.line(format_args!("deleted: {}", names.join(", "))),
    })
}
