//! Loading of files as plans.

use magician::{Error, Fence};
use magician_job::presets::Presets;
use magician_program::artwork::Sheet;
use magician_program::{
    Diagnostic, FontChoice, Format, Plan, Preparation, PrepareRequest, SetupDefaults, SetupOptions,
    StartPosition, Surface, Tool, WorkOption,
};
use pyo3::prelude::*;
use serde_json::{Map, Value, json};

use super::{PyPlan, Source, surface};
use crate::{core, errors};

/// Sentence for an unknown height of the paper.
pub(crate) const SURFACE_ARGUMENT: &str = "work surface height unknown: give load() surface=Z, the z of the arm's pose when its tool \
     touches it; nothing was sent";

/// Options for loading a file. Missing ones come from the file or are defaults.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct LoadOptions {
    format: Option<String>,
    title: Option<String>,
    /// Height and slope of the surface.
    surface: Option<(f64, [f64; 2])>,
    sheet: Option<(f64, f64, f64, Option<[f64; 2]>)>,
    /// Given options, as JSON.
    options: String,
    /// Name and bytes of a custom font.
    font_file: Option<(String, Vec<u8>)>,
    /// Content of a pens file.
    pens_file: Option<String>,
    preset: Option<String>,
}

impl LoadOptions {
    /// Builds the options, and the note of the preset.
    ///
    /// # Errors
    /// What cannot be meant, in a sentence.
    fn options(&self, format: Format) -> Result<(SetupOptions, Option<Diagnostic>), String> {
        let fields = serde_json::from_str(&self.options);
        let mut fields: Map<String, Value> = fields.map_err(|error| error.to_string())?;
        if let Some(text) = &self.pens_file {
            let pens = magician_job::pens::from_text(text);
            let pens = pens.map_err(|problem| format!("pens: {problem}"))?;
            fields.insert("pens".to_owned(), json!(pens));
        }
        let options = match self.preset {
            None => SetupOptions::from_fields(&fields),
            // Consistency is checked later, once the preset has filled the gaps.
            Some(_) => SetupOptions::from_partial_fields(&fields),
        };
        let mut options = options.map_err(|error| error.message)?;
        if let Some((name, bytes)) = &self.font_file {
            options.font = Some(FontChoice::file(name, bytes.as_slice()));
        }
        let has_image = options.image.is_some();
        let note = self.preset(format, &mut options)?;
        options.work = match (options.work, format) {
            (Some(work), _) => Some(work),
            // A frame follows the tool, and so does a preset for a laser.
            (None, _) if options.frame.is_some() => None,
            (None, _) if note.is_some() && options.tool == Some(Tool::Laser) => None,
            (None, Format::Image) if has_image => Some(WorkOption::Draw),
            (None, Format::Image) => Some(WorkOption::Engrave),
            (None, _) => Some(WorkOption::ByFile),
        };
        options.check().map_err(|error| error.message)?;
        if let Some((height, _)) = self.surface {
            options.surface = Some(height);
        }
        Ok((options, note.flatten()))
    }

    /// Fills gaps with the preset. Returns `None` without a preset, otherwise its note, if it has
    /// one.
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
        let completed = preset.complete(options, Some(format));
        let (completed, note) = completed.map_err(|error| error.message)?;
        *options = completed;
        Ok(Some(note))
    }

    /// Defaults for missing options. A plan is made for no particular arm, so a missing surface is
    /// that of a virtual one.
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

/// Fence of the default arm, if that is known without connecting.
fn default_fence() -> Result<Option<Fence>, Error> {
    let arms = magician::arms::load()?;
    let Ok(target) = core::target(None) else {
        return Ok(None);
    };
    Ok(magician::arms::at(&arms, &target).and_then(|arm| arm.fence))
}

/// Determines the format: as given, or from name and content.
fn format_of(name: &str, bytes: &[u8], format: Option<&str>) -> Result<Format, String> {
    match format {
        Some(format) => format.parse(),
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
    /// Creates a plan from the content of a file.
    #[staticmethod]
    fn load(py: Python<'_>, name: &str, bytes: &[u8], options: LoadOptions) -> PyResult<Self> {
        let refused = |text: String| errors::raise(py, &Error::invalid(format!("{name}: {text}")));
        let format = format_of(name, bytes, options.format.as_deref()).map_err(refused)?;
        let mut request = PrepareRequest::new(format, bytes);
        let parsed = options.options(format);
        (request.options, request.preset_note) =
            parsed.map_err(|text| errors::raise(py, &Error::invalid(text)))?;
        let title = options.title.clone();
        request.title = title.unwrap_or_else(|| Format::title(name).to_owned());
        if let Some(Surface { slope, .. }) = surface(options.surface) {
            request.surface_slope = slope;
        }
        request.defaults = options.defaults();
        request.fence = py
            .detach(default_fence)
            .map_err(|error| errors::raise(py, &error))?;
        // There is no arm to ask.
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

    /// Creates a plan from the text of a plan file.
    #[staticmethod]
    fn of_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let plan = py.detach(|| Plan::from_json(text.as_bytes()));
        let plan = plan.map_err(|problem| super::raise(py, None, &problem))?;
        Ok(Self::of(plan, Source::default()))
    }

    /// Readable formats: name, file extensions, description.
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
