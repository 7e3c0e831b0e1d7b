//! Files, as plans.

use magician::Error;
use magician_program::artwork::Sheet;
use magician_program::formats::Dialect;
use magician_program::raster::{Engrave, Size, Tone, Trace};
use magician_program::{
    Content, Diagnostic, Format, Frame, Parsed, Placement, Plan, Power, Prepared, ReadOptions,
    Setup, Surface, Work, read,
};
use pyo3::prelude::*;

use super::{PyPlan, Source, surface, tool};
use crate::errors;

/// The sentence for an unknown height of the paper.
pub(crate) const SURFACE_ARGUMENT: &str = "work surface height unknown: give load() surface=Z, the z of the arm's pose when its tool \
     touches it; nothing was sent";

/// How a file is to be done; what is left open is as the file says, or usual.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Wanted {
    format: Option<String>,
    title: Option<String>,
    tool: Option<String>,
    surface: Option<(f64, [f64; 2])>,
    sheet: Option<(f64, f64, f64, Option<[f64; 2]>)>,
    start: Option<[f64; 3]>,
    place: bool,
    raw: bool,
    pen_z: Option<f64>,
    at: Option<[f64; 2]>,
    scale: f64,
    rotate: f64,
    fit: bool,
    turn: bool,
    mirror: bool,
    clip_page: bool,
    resample: Option<f64>,
    white: Option<String>,
    by: [f64; 3],
    speed: Option<f64>,
    travel_speed: Option<f64>,
    lift: Option<f64>,
    order: bool,
    tolerance: Option<f64>,
    dialect: Option<String>,
    s_max: Option<f64>,
    work: Option<String>,
    width: Option<f64>,
    height: Option<f64>,
    threshold: Option<u8>,
    power: Option<[f64; 2]>,
    tone: Option<String>,
    invert: bool,
    both_directions: bool,
    spacing: Option<f64>,
    overscan: Option<f64>,
    gamma: Option<f64>,
}

impl Wanted {
    /// # Errors
    /// What cannot be meant, in a sentence.
    fn setup(&self, format: Format) -> Result<Setup, String> {
        let mut setup = Setup::default();
        setup.tool = self.tool.as_deref().map(str::parse).transpose()?;
        setup.surface = surface(self.surface);
        setup.sheet = self.sheet.map(|(x, y, rotation, size)| Sheet {
            corner: [x, y],
            rotation,
            surface: setup.surface.unwrap_or(Surface::VIRTUAL),
            size,
        });
        setup.default_surface = Some(Surface::VIRTUAL);
        let mut placement = Placement::default();
        placement.frame = match (self.place, self.raw) {
            (true, true) => return Err("give place or raw, not both".to_owned()),
            (true, false) => Frame::Own,
            (false, true) => Frame::Arm,
            (false, false) => Frame::Default,
        };
        placement.pen_z = self.pen_z;
        (placement.at, placement.by) = (self.at, self.by);
        (placement.scale, placement.rotate) = (above_zero("scale", self.scale)?, self.rotate);
        (placement.fit, placement.turn) = (self.fit, self.turn);
        placement.mirror = self.mirror;
        setup.placement = placement;
        let positive =
            |name, value: Option<f64>| value.map(|value| above_zero(name, value)).transpose();
        setup.pen.lift = positive("lift", self.lift)?.unwrap_or(setup.pen.lift);
        let travel = positive("travel_speed", self.travel_speed)?;
        setup.pen.travel = travel.map_or(setup.pen.travel, |speed| speed as f32);
        setup.speed = positive("speed", self.speed)?.map(|speed| speed as f32);
        if let Some([least, most]) = self.power {
            setup.power = Some(Power::new(least, most)?);
        }
        setup.order = self.order;
        setup.size = match (self.width, self.height) {
            (None, None) => Size::Natural,
            (Some(width), None) => Size::Width(above_zero("width", width)?),
            (None, Some(height)) => Size::Height(above_zero("height", height)?),
            (Some(_), Some(_)) => return Err("give width or height: the other follows".to_owned()),
        };
        setup.work = match (self.work.as_deref(), format) {
            (None, Format::Image) | (Some("engrave"), _) => Work::Engrave(self.engrave()?),
            (None, _) => Work::Default,
            (Some("draw"), _) => {
                let mut trace = Trace::default();
                trace.level = self.threshold.unwrap_or(trace.level);
                trace.tolerance = self.tolerance.unwrap_or(trace.tolerance);
                Work::Draw(trace)
            }
            (Some(other), _) => {
                return Err(format!("work is \"draw\" or \"engrave\", not \"{other}\""));
            }
        };
        Ok(setup)
    }

    fn engrave(&self) -> Result<Engrave, String> {
        let mut engrave = Engrave::default();
        engrave.tone = match self.tone.as_deref() {
            None | Some("grey") => Tone::Grey,
            Some("threshold") => Tone::Threshold(self.threshold.unwrap_or(128)),
            Some("dither") => Tone::Dither,
            Some(other) => {
                return Err(format!(
                    "tone is \"grey\", \"threshold\" or \"dither\", not \"{other}\""
                ));
            }
        };
        (engrave.invert, engrave.both_directions) = (self.invert, self.both_directions);
        let positive =
            |name, value: Option<f64>| value.map(|value| above_zero(name, value)).transpose();
        engrave.spacing = positive("spacing", self.spacing)?.unwrap_or(engrave.spacing);
        engrave.overscan = positive("overscan", self.overscan)?.or(engrave.overscan);
        engrave.gamma = positive("gamma", self.gamma)?.unwrap_or(engrave.gamma);
        Ok(engrave)
    }

    fn options(&self, title: String, setup: &Setup) -> Result<ReadOptions, String> {
        let mut options = ReadOptions::default();
        options.title = title;
        if let Some(tolerance) = self.tolerance {
            options.tolerance = above_zero("tolerance", tolerance)?;
        }
        setup.prepare(&mut options.gcode, surface(self.surface));
        options.gcode.start = self.start;
        options.gcode.dialect = match self.dialect.as_deref() {
            None => Dialect::Detect,
            Some("pen") => Dialect::Pen,
            Some("laser") => Dialect::Laser,
            Some("servo") => Dialect::Servo,
            Some(other) => {
                return Err(format!(
                    "dialect is \"pen\", \"laser\" or \"servo\", not \"{other}\""
                ));
            }
        };
        options.gcode.s_max = self.s_max;
        options.clip_page = self.clip_page;
        options.resample = self.resample;
        if let Some(white) = &self.white {
            options.white = white.parse()?;
        }
        Ok(options)
    }
}

fn above_zero(name: &str, value: f64) -> Result<f64, String> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(format!("{name} is a number above 0, not {value}")),
    }
}

/// What a file is, by what was said, its name, or what is in it.
fn format_of(name: &str, bytes: &[u8], said: Option<&str>) -> Result<Format, String> {
    match said {
        Some(said) => said.parse(),
        None => Format::of(name, bytes).ok_or_else(|| {
            let names = Format::ALL.map(Format::name).join(", ");
            format!("unrecognised file type; give format=, one of {names}")
        }),
    }
}

#[pymethods]
impl PyPlan {
    /// A plan of what is in a file.
    #[staticmethod]
    fn load(py: Python<'_>, name: &str, bytes: &[u8], wanted: Wanted) -> PyResult<Self> {
        let refused = |text: String| errors::raise(py, &Error::invalid(format!("{name}: {text}")));
        // A tool that is none is told of by its argument.
        tool(py, wanted.tool.as_deref())?;
        let format = format_of(name, bytes, wanted.format.as_deref()).map_err(refused)?;
        let setup = wanted.setup(format).map_err(refused)?;
        let title = wanted
            .title
            .clone()
            .unwrap_or_else(|| Format::title(name).to_owned());
        let options = wanted.options(title, &setup).map_err(refused)?;
        let placed = format == Format::Gcode && setup.places();
        let made = py.detach(|| made(format, bytes, &options, &setup));
        let (made, taught) = made.map_err(|problem| super::raise(py, Some(name), &problem))?;
        let source = Source {
            name: Some(name.to_owned()),
            format: Some(format.name().to_owned()),
            notes: made.notes,
            placed: made
                .placed
                .map(|placed| (placed.scale, placed.turn, placed.at)),
            rows: false,
            assumed: (!taught || placed) && setup.surface.is_none(),
            needs_homed_arm: wanted.work.is_some() || format.needs_homed_arm(),
            lift: wanted.lift,
        };
        Ok(Self::of(made.plan, source))
    }

    /// A plan of the text of a plan file.
    #[staticmethod]
    fn of_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let plan = py.detach(|| Plan::from_json(text.as_bytes()));
        let plan = plan.map_err(|problem| super::raise(py, None, &problem))?;
        Ok(Self::of(plan, Source::default()))
    }

    /// The formats that are read: name, endings, what it is.
    #[staticmethod]
    fn formats() -> Vec<(&'static str, Vec<&'static str>, &'static str)> {
        let all = Format::ALL.into_iter();
        all.map(|format| {
            (
                format.name(),
                format.endings().to_vec(),
                format.description(),
            )
        })
        .collect()
    }
}

/// Read and laid before the arm; whether it was in the arm's coordinates already.
fn made(
    format: Format,
    bytes: &[u8],
    options: &ReadOptions,
    setup: &Setup,
) -> Result<(Prepared, bool), Diagnostic> {
    let Parsed { content, notes } = read(format, bytes, options)?;
    let taught = matches!(content, Content::Plan(_));
    let mut made = setup.plan(format, content)?.fitting()?;
    made.notes.splice(0..0, notes);
    Ok((made, taught))
}
