//! Plans as Python values: created, checked, drawn, changed and pickled.

mod check;
mod load;
mod points;
mod steps;

use std::sync::Arc;

use magician::Error;
use magician_program::formats::playback::Playback;
use magician_program::{
    Continuation, Diagnostic, DiagnosticCode, Origin, Pallet, Plan, Surface, Tool,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

pub(crate) use check::{Start, findings, numbers, refusal};
pub(crate) use load::SURFACE_ARGUMENT;
pub(crate) use points::floats;

use crate::{errors, values, voice};

/// A plan, and what is known of where it came from.
#[pyclass(frozen, name = "Plan", module = "magician._magician")]
pub(crate) struct PyPlan {
    pub(crate) plan: Arc<Plan>,
    pub(crate) source: Source,
}

/// Origin of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Source {
    /// Name of the file. `None` if it came from no file.
    pub(crate) name: Option<String>,
    /// Name of the file format.
    format: Option<String>,
    /// Notes of the reader.
    notes: Vec<Diagnostic>,
    /// Placement. `None` if it was not placed.
    placed: Option<Placement>,
    /// True if its lines are rows of an array, counted from 0.
    pub(crate) rows: bool,
    /// True if the surface is that of a virtual arm's table, because the real height was not given.
    pub(crate) assumed: bool,
    /// True for a drawing, image or G-code: something that is drawn or engraved.
    pub(crate) is_drawing: bool,
    /// Given lift of the pen, mm.
    pub(crate) lift: Option<f64>,
}

/// Scale, rotation in degrees, position of its centre, and corners of its page.
type Placement = (f64, f64, [f64; 2], Option<[[f64; 2]; 4]>);

/// Line, column, name, message, advice, and code of a note.
type NoteParts<'a> = (
    u32,
    u32,
    Option<&'a str>,
    &'a str,
    Option<String>,
    &'static str,
);

/// Pickled note: line, column, length, name, message, advice, and code.
type PickledNote = (
    u32,
    u32,
    u32,
    Option<String>,
    String,
    Option<String>,
    String,
);

/// Pickled origin: file, format, notes, placement; true for rows, for an assumed surface, for a
/// drawing; and the lift.
type PickledSource = (
    Option<String>,
    Option<String>,
    Vec<PickledNote>,
    Option<Placement>,
    bool,
    bool,
    bool,
    Option<f64>,
);

impl Source {
    fn to_pickled(&self) -> PickledSource {
        let note = |note: &Diagnostic| {
            let Origin {
                line,
                column,
                length,
                ..
            } = note.origin;
            let (name, help) = (note.name.clone(), note.advice(&voice::Python));
            let code = note.code.name().to_owned();
            let message = note.message.to_string();
            (line, column, length, name, message, help, code)
        };
        let notes = self.notes.iter().map(note).collect();
        let (name, format) = (self.name.clone(), self.format.clone());
        (
            name,
            format,
            notes,
            self.placed,
            self.rows,
            self.assumed,
            self.is_drawing,
            self.lift,
        )
    }

    fn from_pickled(
        (name, format, notes, placed, rows, assumed, is_drawing, lift): PickledSource,
    ) -> Self {
        let code_of = |name: String| {
            DiagnosticCode::ALL
                .into_iter()
                .find(|code| code.name() == name)
        };
        let note = |(line, column, length, name, message, help, code): PickledNote| Diagnostic {
            code: code_of(code).unwrap_or_default(),
            origin: Origin {
                line,
                column,
                length,
                name: 0,
            },
            name,
            message: message.into(),
            help: help.map(Into::into),
            remedies: Vec::new(),
            missing: None,
        };
        Self {
            name,
            format,
            notes: notes.into_iter().map(note).collect(),
            placed,
            rows,
            assumed,
            is_drawing,
            lift,
        }
    }
}

impl PyPlan {
    pub(crate) fn of(plan: Plan, source: Source) -> Self {
        Self {
            plan: Arc::new(plan),
            source,
        }
    }

    /// Returns a changed copy of the plan, or the exception if the change fails.
    fn changed(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&Plan) -> Result<Plan, Diagnostic> + Send,
    ) -> PyResult<Self> {
        let plan = py.detach(|| change(&self.plan));
        let plan = plan.map_err(|problem| raise(py, self.source.name.as_deref(), &problem))?;
        Ok(Self::of(plan, self.source.clone()))
    }
}

/// Creates the exception for a problem with a file or plan.
pub(crate) fn raise(py: Python<'_>, name: Option<&str>, problem: &Diagnostic) -> PyErr {
    let name = name.map(|name| format!("{name}: ")).unwrap_or_default();
    let help = problem.help.iter().map(|help| format!("; {help}"));
    let text = format!("{name}{problem}{}", help.collect::<String>());
    let error = Error::from(problem.clone());
    errors::raise(py, &error.reworded(text))
}

/// Parses a tool: a name or a bias.
fn tool(py: Python<'_>, text: Option<&str>) -> PyResult<Option<Tool>> {
    let tool = text.map(str::parse::<Tool>).transpose();
    tool.map_err(|error| errors::raise(py, &Error::invalid(format!("tool: {error}"))))
}

/// Builds a surface from height and slope.
fn surface(given: Option<(f64, [f64; 2])>) -> Option<Surface> {
    given.map(|(height, slope)| Surface { height, slope })
}

#[pymethods]
impl PyPlan {
    /// Restores a pickled plan from the text of its file and its origin.
    #[new]
    fn of_kept(py: Python<'_>, json: &str, source: PickledSource) -> PyResult<Self> {
        let plan = py.detach(|| Plan::from_json(json.as_bytes()));
        let plan = plan.map_err(|problem| raise(py, None, &problem))?;
        Ok(Self::of(plan, Source::from_pickled(source)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (String, PickledSource)) {
        let kept = (slf.get().to_json(slf.py()), slf.get().source.to_pickled());
        (slf.get_type().into_any(), kept)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyDict>) -> Py<Self> {
        slf
    }

    /// Creates a plan from commands.
    #[staticmethod]
    #[pyo3(name = "of_commands")]
    fn of_commands(
        py: Python<'_>,
        title: &str,
        commands: &Bound<'_, PyAny>,
        tool: Option<&str>,
        surface: Option<(f64, [f64; 2])>,
    ) -> PyResult<Self> {
        let mut plan = Plan::new(title);
        plan.tool = self::tool(py, tool)?;
        plan.surface = self::surface(surface);
        for (nth, object) in (1..).zip(commands.try_iter()?) {
            let command = values::command(&object?)?;
            let row = command.row();
            if !row.queueable {
                let error =
                    Error::invalid(format!("step {nth}: {} cannot be queued", row.set_name));
                return Err(errors::raise(py, &error.with_command(row.set_name)));
            }
            plan.push(command, magician_program::Origin::NONE);
        }
        Ok(Self::of(plan, Source::default()))
    }

    #[getter]
    fn title(&self) -> &str {
        &self.plan.title
    }

    #[getter]
    fn tool(&self) -> Option<String> {
        self.plan.tool.map(|tool| tool.to_string())
    }

    #[getter]
    fn surface(&self) -> Option<(f64, [f64; 2])> {
        self.plan
            .surface
            .map(|surface| (surface.height, surface.slope))
    }

    #[getter]
    fn source(&self) -> Option<&str> {
        self.source.name.as_deref()
    }

    #[getter]
    fn format(&self) -> Option<&str> {
        self.source.format.as_deref()
    }

    #[getter]
    fn assumed(&self) -> bool {
        self.source.assumed
    }

    /// Notes of the reader.
    #[getter]
    fn notes(&self) -> Vec<NoteParts<'_>> {
        let notes = self.source.notes.iter();
        let parts = notes.map(|note| {
            let (line, column) = (note.origin.line, note.origin.column);
            let help = note.advice(&voice::Python);
            (
                line,
                column,
                note.name.as_deref(),
                note.message.as_str(),
                help,
                note.code.name(),
            )
        });
        parts.collect()
    }

    /// Placement, if the plan was placed.
    #[getter]
    fn placed(&self) -> Option<Placement> {
        self.source.placed
    }

    fn moved(&self, py: Python<'_>, by: [f64; 3]) -> PyResult<Self> {
        self.changed(py, |plan| plan.moved(by))
    }

    fn scaled(&self, py: Python<'_>, factor: f64, about: [f64; 3]) -> PyResult<Self> {
        self.changed(py, |plan| plan.scaled(factor, about))
    }

    fn rotated(&self, py: Python<'_>, degrees: f64, about: [f64; 2]) -> PyResult<Self> {
        self.changed(py, |plan| plan.rotated(degrees, about))
    }

    fn repeated(&self, py: Python<'_>, times: usize) -> PyResult<Self> {
        self.changed(py, |plan| plan.repeated(times))
    }

    fn on_grid(
        &self,
        py: Python<'_>,
        rows: usize,
        columns: usize,
        pitch: [f64; 2],
    ) -> PyResult<Self> {
        self.changed(py, |plan| {
            plan.placed_on(&Pallet::grid(rows, columns, pitch))
        })
    }

    fn on_corners(
        &self,
        py: Python<'_>,
        rows: usize,
        columns: usize,
        corners: [[f64; 3]; 3],
    ) -> PyResult<Self> {
        self.changed(py, |plan| {
            plan.placed_on(&Pallet::corners(rows, columns, corners))
        })
    }

    /// Appends the steps of another plan.
    fn joined(&self, other: &Self) -> Self {
        let source = Source {
            assumed: self.source.assumed || other.source.assumed,
            rows: self.source.rows && other.source.rows,
            ..Source::default()
        };
        Self::of(self.plan.joined(&other.plan), source)
    }

    /// Returns the plan from a step on, counted from 1, for the given arm state, or for a virtual
    /// arm.
    fn starting_at(&self, py: Python<'_>, step: usize, start: Option<&Start>) -> PyResult<Self> {
        let at = step.checked_sub(1);
        let at =
            at.ok_or_else(|| errors::raise(py, &Error::invalid("steps are counted from 1")))?;
        let start = self.start_or_virtual(py, start)?;
        self.changed(py, |plan| {
            Continuation::from_step(plan, at, &start).map(|rest| rest.plan)
        })
    }

    fn to_json(&self, py: Python<'_>) -> String {
        py.detach(|| self.plan.to_json())
    }

    /// Text of a DobotStudio file, and notes on content that it cannot express.
    fn to_playback(&self, py: Python<'_>) -> PyResult<(String, Vec<String>)> {
        let playback = py.detach(|| Playback::from_plan(&self.plan));
        let playback =
            playback.map_err(|problem| raise(py, self.source.name.as_deref(), &problem))?;
        let lost = playback.notes().iter().map(ToString::to_string);
        Ok((playback.to_xml(), lost.collect()))
    }

    /// Pauses: step numbers from 1, and messages for the operator.
    fn pauses(&self) -> Vec<(usize, String)> {
        let pauses = self.plan.pauses();
        pauses
            .map(|(nth, pause)| (nth + 1, pause.text.clone()))
            .collect()
    }

    fn __len__(&self) -> usize {
        self.plan.steps.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.plan == other.plan
    }
}

/// Copies an error with another text. Its parts stay.
pub(crate) fn with_text(error: &Error, text: String) -> Error {
    let changed = error.reworded(text);
    match error.command() {
        Some(command) => changed.with_command(command),
        None => changed,
    }
}
