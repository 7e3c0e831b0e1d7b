//! Files, as plans.

use magician::Error;
use magician_job::presets::Presets;
use magician_program::artwork::Sheet;
use magician_program::{
    Content, Diagnostic, FontChoice, Format, Parsed, Plan, Prepared, ReadOptions, Setup,
    SetupDefaults, SetupOptions, Surface, Tool, WorkOption, read,
};
use pyo3::prelude::*;
use serde_json::{Map, Value, json};

use super::{PyPlan, Source, surface};
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
    /// A surface that may be on a slope.
    surface: Option<(f64, [f64; 2])>,
    sheet: Option<(f64, f64, f64, Option<[f64; 2]>)>,
    /// The options that were given, as JSON.
    options: String,
    /// Name and bytes of a font that is not built in.
    font_file: Option<(String, Vec<u8>)>,
    /// The text of a file of pens.
    pens_file: Option<String>,
    preset: Option<String>,
}

/// What the arguments say.
struct Said {
    options: SetupOptions,
    /// What people are told of them first.
    notes: Vec<Diagnostic>,
    /// True if they say which work it is.
    has_work: bool,
}

impl Wanted {
    /// # Errors
    /// What cannot be meant, in a sentence.
    fn options(&self, format: Format) -> Result<Said, String> {
        let fields = serde_json::from_str(&self.options);
        let mut fields: Map<String, Value> = fields.map_err(|error| error.to_string())?;
        if let Some(text) = &self.pens_file {
            let pens = magician_job::pens::from_text(text);
            let pens = pens.map_err(|problem| format!("pens: {problem}"))?;
            fields.insert("pens".to_owned(), json!(pens));
        }
        let options = match self.preset {
            None => SetupOptions::from_fields(&fields),
            // Whether they agree shows with what the preset says.
            Some(_) => SetupOptions::from_fields_of_some(&fields),
        };
        let mut options = options.map_err(|error| error.message)?;
        if let Some((name, bytes)) = &self.font_file {
            options.font = Some(FontChoice::file(name, bytes.as_slice()));
        }
        let (has_work, has_image) = (options.work.is_some(), options.image.is_some());
        let note = self.preset(format, &mut options)?;
        options.work = match (options.work, format) {
            (Some(work), _) => Some(work),
            // What is framed is as the tool has it, and so is what a preset of a laser is for.
            (None, _) if options.frame.is_some() => None,
            (None, _) if note.is_some() && options.tool == Some(Tool::Laser) => None,
            (None, Format::Image) if has_image => Some(WorkOption::Draw),
            (None, Format::Image) => Some(WorkOption::Engrave),
            (None, _) => Some(WorkOption::ByFile),
        };
        options.check().map_err(|error| error.message)?;
        let framed = options.frame_for(&SetupDefaults::default(), None);
        Ok(Said {
            options,
            notes: framed.into_iter().chain(note.flatten()).collect(),
            has_work,
        })
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
        let format = format_of(name, bytes, wanted.format.as_deref()).map_err(refused)?;
        let said = wanted.options(format);
        let said = said.map_err(|text| errors::raise(py, &Error::invalid(text)))?;
        let Said {
            options: said,
            notes,
            has_work,
        } = said;
        let setup = wanted.setup(&said);
        let title = wanted
            .title
            .clone()
            .unwrap_or_else(|| Format::title(name).to_owned());
        let options = wanted.reading(&said, title, &setup);
        let placed = format == Format::Gcode && setup.places();
        let made = py.detach(|| made(format, bytes, &options, &setup));
        let (mut made, taught) = made.map_err(|problem| super::raise(py, Some(name), &problem))?;
        made.notes.splice(0..0, notes);
        let source = Source {
            name: Some(name.to_owned()),
            format: Some(format.name().to_owned()),
            notes: made.notes,
            placed: { made.placed }
                .map(|placed| (placed.scale, placed.turn, placed.at, placed.page)),
            rows: false,
            assumed: (!taught || placed) && setup.surface.is_none(),
            is_drawing: has_work || said.frame.is_some() || format.is_drawing(),
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
