//! Files, as plans.

use magician::{Error, Fence};
use magician_job::presets::Presets;
use magician_program::artwork::Sheet;
use magician_program::{
    Diagnostic, FontChoice, Format, ModeOption, Paper, Plan, Power, Preparation, PrepareRequest,
    SetupDefaults, SetupOptions, StartPosition, Surface, Tool, WorkOption,
};
use pyo3::prelude::*;

use super::{PyPlan, Source, surface, tool};
use crate::{core, errors};

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
    depths: Option<String>,
    at: Option<[f64; 2]>,
    page: Option<String>,
    margin: Option<f64>,
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
    hop: Option<f64>,
    order: bool,
    tolerance: Option<f64>,
    dialect: Option<String>,
    s_max: Option<f64>,
    work: Option<String>,
    width: Option<f64>,
    height: Option<f64>,
    threshold: Option<u8>,
    power: Option<[f64; 2]>,
    mode: Option<String>,
    invert: bool,
    image: Option<String>,
    levels: Option<u8>,
    despeckle: Option<f64>,
    pen_width: Option<f64>,
    crop: Option<[u32; 4]>,
    brightness: Option<f64>,
    contrast: Option<f64>,
    one_way: bool,
    spacing: Option<f64>,
    overscan: Option<f64>,
    gamma: Option<f64>,
    merge: Option<f64>,
    dedupe: Option<bool>,
    simplify: Option<f64>,
    font: Option<String>,
    font_file: Option<Vec<u8>>,
    size: Option<f64>,
    wrap: Option<f64>,
    align: Option<String>,
    line_height: Option<f64>,
    text: Option<String>,
    system_fonts: Option<String>,
    strict_text: bool,
    fill: Option<String>,
    fill_spacing: Option<f64>,
    fill_angle: Option<f64>,
    fill_inset: Option<f64>,
    parts: Option<String>,
    only: Vec<String>,
    passes: Option<u32>,
    /// As JSON, or a file of pens.
    pens: Option<String>,
    pens_file: Option<String>,
    no_pause: bool,
    frame: Option<String>,
    frame_power: Option<f64>,
    preset: Option<String>,
}

impl Wanted {
    /// # Errors
    /// What cannot be meant, in a sentence.
    fn options(&self, format: Format) -> Result<(SetupOptions, Option<Diagnostic>), String> {
        let mut options = SetupOptions::default();
        options.mode = match self.mode.as_deref() {
            _ if self.work.as_deref() == Some("draw") => None,
            None | Some("grey") => None,
            Some("threshold") => Some(ModeOption::Threshold),
            Some("dither") => Some(ModeOption::Dither),
            Some(other) => {
                return Err(format!(
                    "mode is \"grey\", \"threshold\" or \"dither\", not \"{other}\""
                ));
            }
        };
        options.dialect = match self.dialect.as_deref() {
            Some(dialect) => Some(dialect.parse().map_err(|_| {
                format!("dialect is \"pen\", \"laser\" or \"servo\", not \"{dialect}\"")
            })?),
            None => None,
        };
        options.tool = self.tool.as_deref().map(str::parse).transpose()?;
        // What is as usual is not said: a preset may say it.
        let white = self.white.as_deref().filter(|white| *white != "skip");
        options.white = white.map(str::parse).transpose()?;
        (options.s_max, options.resample) = (self.s_max, self.resample);
        (options.place, options.raw) = (self.place, self.raw);
        (options.pen_z, options.start) = (self.pen_z, self.start);
        let depths = self.depths.as_deref().filter(|depths| *depths != "flatten");
        options.depths = depths.map(str::parse).transpose()?;
        (options.at, options.by) = (self.at, Some(self.by).filter(|by| *by != [0.0; 3]));
        let page = self.page.as_deref().map(str::parse::<Paper>);
        options.page = page.transpose().map_err(|wrong| format!("page: {wrong}"))?;
        options.margin = self.margin;
        options.scale = Some(self.scale).filter(|scale| *scale != 1.0);
        options.rotate = Some(self.rotate).filter(|rotate| *rotate != 0.0);
        options.fit = self.fit;
        options.turn = (!self.turn).then_some(false);
        (options.mirror, options.clip_page) = (self.mirror, self.clip_page);
        (options.speed, options.travel_speed) = (self.speed, self.travel_speed);
        (options.lift, options.order) = (self.lift, (!self.order).then_some(false));
        options.hop = self.hop;
        (options.tolerance, options.threshold) = (self.tolerance, self.threshold);
        (options.width, options.height) = (self.width, self.height);
        (options.invert, options.one_way) = (self.invert, self.one_way);
        (options.spacing, options.overscan) = (self.spacing, self.overscan);
        options.gamma = self.gamma;
        options.image = self.image.as_deref().map(str::parse).transpose()?;
        (options.levels, options.despeckle) = (self.levels, self.despeckle);
        (options.pen_width, options.crop) = (self.pen_width, self.crop);
        (options.brightness, options.contrast) = (self.brightness, self.contrast);
        (options.merge, options.simplify) = (self.merge, self.simplify);
        options.dedupe = self.dedupe;
        options.font = match (&self.font, &self.font_file) {
            (Some(name), Some(bytes)) => Some(FontChoice::file(name, bytes.as_slice())),
            (name, _) => name.as_deref().map(str::parse).transpose()?,
        };
        (options.size, options.wrap) = (self.size, self.wrap);
        options.align = self.align.as_deref().map(str::parse).transpose()?;
        options.line_height = self.line_height;
        options.text = self.text.as_deref().map(str::parse).transpose()?;
        let fonts = self.system_fonts.as_deref();
        options.system_fonts = fonts.map(str::parse).transpose()?;
        options.strict_text = self.strict_text;
        let fill = self.fill.as_deref().filter(|fill| *fill != "none");
        options.fill = fill.map(str::parse).transpose()?;
        (options.fill_spacing, options.fill_angle) = (self.fill_spacing, self.fill_angle);
        options.fill_inset = self.fill_inset;
        options.parts = self.parts.as_deref().map(str::parse).transpose()?;
        options.only.clone_from(&self.only);
        (options.passes, options.no_pause) = (self.passes, self.no_pause);
        options.pens = match (&self.pens, &self.pens_file) {
            (Some(json), _) => {
                let pens = serde_json::from_str(json);
                pens.map_err(|error| format!("pens: {error}"))?
            }
            (None, Some(text)) => {
                let pens = magician_job::pens::from_text(text);
                pens.map_err(|problem| format!("pens: {problem}"))?
            }
            (None, None) => Vec::new(),
        };
        options.frame = self.frame.as_deref().map(str::parse).transpose()?;
        options.frame_power = self.frame_power;
        let note = self.preset(format, &mut options)?;
        options.work = match (self.work.as_deref(), format) {
            (Some("engrave"), _) => Some(WorkOption::Engrave),
            (Some("draw"), _) => Some(WorkOption::Draw),
            (Some(other), _) => {
                return Err(format!("work is \"draw\" or \"engrave\", not \"{other}\""));
            }
            // What is framed is as the tool has it, and so is what a preset of a laser is for.
            (None, _) if options.frame.is_some() => None,
            (None, _) if note.is_some() && options.tool == Some(Tool::Laser) => None,
            (None, Format::Image) if self.image.is_some() => Some(WorkOption::Draw),
            (None, Format::Image) => Some(WorkOption::Engrave),
            (None, _) => Some(WorkOption::ByFile),
        };
        options.check().map_err(|error| error.message)?;
        if let Some((height, _)) = self.surface {
            options.surface = Some(height);
        }
        // No power at all is one, too: it burns nothing.
        if let Some([least, most]) = self.power {
            options.power = Some(Power::new(least, most)?);
        }
        Ok((options, note.flatten()))
    }

    /// With what the preset says where the arguments say nothing; what it tells people, if there is one.
    #[expect(clippy::option_option, reason = "a preset may have nothing to tell")]
    fn preset(
        &self,
        format: Format,
        options: &mut SetupOptions,
    ) -> Result<Option<Option<Diagnostic>>, String> {
        let Some(name) = &self.preset else {
            return Ok(None);
        };
        let preset = Presets::of_user().load(name);
        let preset = preset.map_err(|error| error.to_string())?;
        *options = options.or(&preset.options_for(Some(format)));
        Ok(Some(preset.told()))
    }

    /// What counts where the arguments leave something open: a plan is made for no arm, so that a surface that was not given is that
    /// of a virtual one.
    fn defaults(&self) -> SetupDefaults {
        let mut defaults = SetupDefaults::default().on_virtual_arm();
        defaults.sheet = self.sheet.map(|(x, y, rotation, size)| Sheet {
            corner: [x, y],
            rotation,
            surface: surface(self.surface).unwrap_or(Surface::VIRTUAL),
            size,
        });
        defaults
    }
}

/// The fence of the arm that is meant where no port is given, as far as that is known without one.
fn usual_fence() -> Result<Option<Fence>, Error> {
    let arms = magician::arms::load()?;
    let Ok(target) = core::target(None) else {
        return Ok(None);
    };
    Ok(magician::arms::at(&arms, &target).and_then(|arm| arm.fence))
}

/// What a file is, by what was said, its name, or what is in it.
fn format_of(name: &str, bytes: &[u8], said: Option<&str>) -> Result<Format, String> {
    match said {
        Some(said) => said.parse(),
        None => Format::of(name, bytes).ok_or_else(|| {
            if let Some(foreign) = magician_program::foreign(name, bytes) {
                return foreign.to_string();
            }
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
        let mut request = PrepareRequest::new(format, bytes);
        (request.options, request.preset_note) = wanted.options(format).map_err(refused)?;
        let title = wanted.title.clone();
        request.title = title.unwrap_or_else(|| Format::title(name).to_owned());
        if let Some(Surface { slope, .. }) = surface(wanted.surface) {
            request.surface_slope = slope;
        }
        request.defaults = wanted.defaults();
        request.fence = py
            .detach(usual_fence)
            .map_err(|error| errors::raise(py, &error))?;
        // No arm is there to ask.
        request.start = StartPosition::Unknown;
        let lift = request.options.lift;
        let prepared = py.detach(|| match request.prepare()? {
            Preparation::Done(program) => program.fitting().map(Some),
            Preparation::NeedsStart => Ok(None),
        });
        let prepared = prepared
            .map_err(|error| super::raise(py, Some(name), &error.problem))?
            .ok_or_else(|| refused("it is not known where it begins".to_owned()))?;
        let lies_on_surface =
            format.is_drawing() && (format != Format::Gcode || prepared.setup.places());
        let source = Source {
            name: Some(name.to_owned()),
            format: Some(format.name().to_owned()),
            notes: prepared.notes,
            placed: { prepared.placed }
                .map(|placed| (placed.scale, placed.turn, placed.at, placed.page)),
            rows: false,
            assumed: lies_on_surface && prepared.setup.surface.is_none(),
            is_drawing: prepared.ending.drawing,
            lift,
        };
        Ok(Self::of(prepared.program.into_plan(), source))
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
