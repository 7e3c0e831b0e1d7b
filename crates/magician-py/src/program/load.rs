//! Files, as plans.

use magician::Error;
use magician_job::presets::Presets;
use magician_program::artwork::Sheet;
use magician_program::{
    Content, Diagnostic, FontChoice, Format, ModeOption, Paper, Parsed, Plan, Power, Prepared,
    ReadOptions, Setup, SetupDefaults, SetupOptions, Surface, Tool, WorkOption, read,
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
    fn options(&self, format: Format) -> Result<(SetupOptions, Vec<Diagnostic>), String> {
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
        let framed = options.frame_for(&SetupDefaults::default(), None);
        // No power at all is one, too: it burns nothing.
        if let Some([least, most]) = self.power {
            options.power = Some(Power::new(least, most)?);
        }
        Ok((options, framed.into_iter().chain(note.flatten()).collect()))
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

    /// How it is to be done: with a surface on a slope and a sheet, which have no flags.
    fn setup(&self, options: &SetupOptions) -> Setup {
        let mut defaults = SetupDefaults::default();
        defaults.assumed_surface = Some(Surface::VIRTUAL);
        let mut setup = options.setup(&defaults);
        setup.surface = surface(self.surface).or(setup.surface);
        setup.sheet = self.sheet.map(|(x, y, rotation, size)| Sheet {
            corner: [x, y],
            rotation,
            surface: setup.surface.unwrap_or(Surface::VIRTUAL),
            size,
        });
        setup
    }

    fn reading(&self, options: &SetupOptions, title: String, setup: &Setup) -> ReadOptions {
        let mut reading = options.reading(setup);
        reading.title = title;
        setup.prepare(&mut reading.gcode, setup.surface);
        reading.gcode.start = options.start;
        reading
    }
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
        let (said, note) = wanted.options(format).map_err(refused)?;
        let setup = wanted.setup(&said);
        let title = wanted
            .title
            .clone()
            .unwrap_or_else(|| Format::title(name).to_owned());
        let options = wanted.reading(&said, title, &setup);
        let placed = format == Format::Gcode && setup.places();
        let made = py.detach(|| made(format, bytes, &options, &setup));
        let (mut made, taught) = made.map_err(|problem| super::raise(py, Some(name), &problem))?;
        made.notes.splice(0..0, note);
        let source = Source {
            name: Some(name.to_owned()),
            format: Some(format.name().to_owned()),
            notes: made.notes,
            placed: { made.placed }
                .map(|placed| (placed.scale, placed.turn, placed.at, placed.page)),
            rows: false,
            assumed: (!taught || placed) && setup.surface.is_none(),
            is_drawing: wanted.work.is_some() || said.frame.is_some() || format.is_drawing(),
            lift: said.lift,
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
