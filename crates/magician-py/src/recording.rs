//! Recordings of an arm, and replays of recorded sessions on a virtual arm.

use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use magician::sim::{Controller, Profile, Speed, World};
use magician::{Arm, Error, ErrorCode};
use magician_job::files::WholeFile;
use magician_job::recording::{Clock, Options, RecordError, Recorder, RecordingProgress, Summary};
use magician_record::replay::{Difference, DifferenceKind, Replay, ReplayWriter, Tolerances};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use tokio::sync::oneshot;

use crate::call::Call;
use crate::cell::scenario_of;
use crate::core::Core;
use crate::runtime::{self, Local};
use crate::{errors, values};

/// Advice for a file name that is no format of a recording.
const FORMAT_ADVICE: &str = "use .mcap, .csv or .jsonl for readings, .plan.json or .playback for a program that repeats the \
     motion";

/// Packets replayed between two checks for Ctrl-C. A choice: a fraction of a second.
const PACKETS_PER_CHECK: usize = 4096;

/// An arm on record.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Recording {
    inner: Local<Inner>,
}

struct Inner {
    tally: Box<dyn Fn() -> RecordingProgress + Send + Sync>,
    ending: Mutex<Option<Ending>>,
}

struct Ending {
    /// Sender that ends the recording. Dropping it ends the recording too.
    end: oneshot::Sender<()>,
    ended: oneshot::Receiver<Result<Summary, RecordError>>,
}

fn to_exception(py: Python<'_>, error: RecordError) -> PyErr {
    let message = error.to_string();
    match error {
        RecordError::Format(_) => {
            errors::raise(py, &Error::invalid(format!("{message}; {FORMAT_ADVICE}")))
        }
        RecordError::Unwritable { why, .. } | RecordError::Write(why) => {
            std::io::Error::new(why.kind(), message).into()
        }
        RecordError::Program(problem) => errors::raise(py, &problem.into()),
        RecordError::Arm(error) => errors::raise(py, &error),
        RecordError::Lost { readings, .. } => {
            let message = format!("{message}; the {readings} readings before that are kept");
            errors::raise(py, &Error::new(ErrorCode::LineLost, message))
        }
        RecordError::TaskFailed(_) => PyRuntimeError::new_err(message),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Starts a recording, reports that, and continues until it is ended or fails.
async fn record(
    arm: Arm,
    path: PathBuf,
    options: Options,
    begun: oneshot::Sender<Result<Inner, RecordError>>,
) {
    let mut recorder = match Recorder::begin(&arm, &path, options).await {
        Ok(recorder) => recorder,
        Err(error) => {
            // The receiver may be gone: the caller was interrupted.
            let _ = begun.send(Err(error));
            return;
        }
    };
    let (end, stopped) = oneshot::channel();
    let (tell, ended) = oneshot::channel();
    let inner = Inner {
        tally: Box::new(recorder.progress_reader()),
        ending: Mutex::new(Some(Ending { end, ended })),
    };
    drop(begun.send(Ok(inner)));
    let failed = tokio::select! {
        biased;
        _ = stopped => None,
        error = recorder.failed() => Some(error),
    };
    let _ = tell.send(match failed {
        Some(error) => Err(error),
        None => recorder.finish().await,
    });
}

#[pymethods]
impl Core {
    /// Records the arm to a file.
    fn record(
        &self,
        py: Python<'_>,
        path: PathBuf,
        rate: f64,
        tolerance: f64,
        units: bool,
    ) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let options = Options {
            tolerance,
            units,
            // The clock of a virtual arm may run faster than wall time.
            clock: if arm.is_virtual() {
                Clock::Arm
            } else {
                Clock::Host
            },
            ..Options::new(SystemTime::now(), rate)
        };
        let (begun, inner) = oneshot::channel();
        // On a separate thread, so that a slow disk does not delay connections.
        let work = record(arm, path, options, begun);
        let thread =
            runtime::spawn_separately("magician-record", move |runtime| runtime.block_on(work));
        thread.map_err(|error| errors::raise(py, &error))?;
        let inner = async move { Ok::<_, Error>(inner.await) };
        Ok(Call::start(inner, |py, inner| match inner {
            Ok(Ok(inner)) => {
                let inner = Local::new(inner);
                Recording { inner }.into_py_any(py)
            }
            Ok(Err(error)) => Err(to_exception(py, error)),
            Err(_) => Err(PyRuntimeError::new_err("the recording did not begin")),
        }))
    }
}

#[pymethods]
impl Recording {
    /// Progress: time, s; number of readings; tool position x, y, z, r; speed, mm/s; path length,
    /// mm.
    fn tally(&self, py: Python<'_>) -> PyResult<(f64, u64, [f64; 4], f64, f64)> {
        let tally = (self.inner.get(py)?.tally)();
        let RecordingProgress {
            seconds,
            readings,
            pose,
            speed,
            length,
        } = tally;
        Ok((seconds, readings, pose.map(values::shortest), speed, length))
    }

    /// True while the recording continues.
    fn is_open(&self, py: Python<'_>) -> PyResult<bool> {
        let ending = self.inner.get(py)?.ending.lock();
        let ending = ending.unwrap_or_else(PoisonError::into_inner);
        Ok(ending
            .as_ref()
            .is_some_and(|ending| !ending.end.is_closed()))
    }

    /// Ends the recording. Returns time, s, readings, path length, mm, and steps of a program. May
    /// be called once.
    fn finish(&self, py: Python<'_>) -> PyResult<Call> {
        let ending = self.inner.get(py)?.ending.lock();
        let ending = ending.unwrap_or_else(PoisonError::into_inner).take();
        let ended = async move {
            let ending = ending?;
            // Fails if the recording has ended by itself; its error follows.
            let _ = ending.end.send(());
            ending.ended.await.ok()
        };
        Ok(Call::start(
            async move { Ok::<_, Error>(ended.await) },
            |py, ended| match ended {
                Some(Ok(ended)) => {
                    (ended.seconds, ended.readings, ended.length, ended.steps).into_py_any(py)
                }
                Some(Err(error)) => Err(to_exception(py, error)),
                None => Err(PyRuntimeError::new_err("the recording was ended")),
            },
        ))
    }
}

/// Options of a replay.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ReplayOptions {
    link: Option<String>,
    clock: f64,
    ignore: Vec<String>,
    tolerance: f32,
    time_tolerance: u32,
    scenario: Option<String>,
    profile: Option<String>,
    save: Option<PathBuf>,
}

impl ReplayOptions {
    fn arm(&self, py: Python<'_>, session: &Replay<'_>) -> PyResult<Controller> {
        let scenario = scenario_of(py, self.scenario.as_deref())?;
        let wrong = |error| errors::raise(py, &Error::invalid(format!("profile: {error}")));
        let profile = self.profile.as_deref().map(Profile::from_toml);
        let profile = profile.transpose().map_err(wrong)?.unwrap_or_default();
        let profile = session.beginning(profile);
        let world = scenario.as_ref().map(World::from_scenario);
        Ok(Controller::in_world(profile, world.unwrap_or_default()))
    }

    fn session<'a>(&self, py: Python<'_>, trace: &'a [u8]) -> PyResult<Replay<'a>> {
        let made = || {
            let mut session = Replay::new(trace)?;
            if let Some(link) = self.link.clone().or_else(|| session.line_of_arm()) {
                session = session.only_link(&link)?;
            }
            for name in &self.ignore {
                session = session.ignoring(name)?;
            }
            let tolerances = Tolerances {
                measured: self.tolerance,
                time_ms: self.time_tolerance,
            };
            let clock = match self.clock {
                0.0 => Speed::Max,
                times => Speed::Times(times),
            };
            Ok(session.tolerances(tolerances).clock(clock))
        };
        made().map_err(|error: magician_record::replay::ReplayError| {
            errors::raise(py, &Error::invalid(error.to_string()))
        })
    }
}

/// Replays a trace on a virtual arm: counts by their names, and the differences, as
/// `magician.recordings` has them.
#[pyfunction]
pub(crate) fn replay(py: Python<'_>, trace: &[u8], options: ReplayOptions) -> PyResult<Py<PyAny>> {
    let session = options.session(py, trace)?;
    let mut arm = options.arm(py, &session)?;
    let session = py.detach(|| session.fitted(&arm));
    let mut file = match &options.save {
        Some(path) => Some(WholeFile::create(path)?),
        None => None,
    };
    let mut saved = match &mut file {
        Some(file) => Some(ReplayWriter::new(BufWriter::new(file.writer()), &session)?),
        None => None,
    };
    let mut play = session.play(&mut arm);
    loop {
        let more = py.detach(|| {
            for _ in 0..PACKETS_PER_CHECK {
                let Some(moment) = play.step() else {
                    return Ok(false);
                };
                if let Some(saved) = &mut saved {
                    saved.write(&moment)?;
                }
            }
            std::io::Result::Ok(true)
        });
        if !more? {
            break;
        }
        py.check_signals()?;
    }
    // Flush the buffer before the file is finished.
    drop(saved);
    let report = py.detach(|| {
        let whole = file.map_or(Ok(()), WholeFile::finish);
        whole.map(|()| play.finish())
    })?;
    let class = py.import("magician.replaying")?.getattr("Difference")?;
    let differences = PyList::empty(py);
    for difference in &report.differences {
        differences.append(class.call1(parts(py, difference)?)?)?;
    }
    let counts = [
        report.found,
        report.requests,
        report.answers,
        report.fields,
        report.ignored,
        report.unanswered,
        report.undirected,
    ];
    (counts, differences).into_py_any(py)
}

/// Arguments of a Python `Difference`.
fn parts<'py>(py: Python<'py>, found: &Difference) -> PyResult<Bound<'py, PyTuple>> {
    let field = match found.what {
        DifferenceKind::Value(field) => Some(field.name),
        _ => None,
    };
    let shown = |replayed| found.shown(replayed).map(|value| values::take(py, &value));
    let command = Some(found.command).filter(|command| !command.is_empty());
    let parts = (
        found.to_string(),
        found.time.as_micros() as f64 / 1e6,
        Some(found.link.as_str()).filter(|link| !link.is_empty()),
        u32::from(found.id),
        command,
        found.what.name(),
        field,
        shown(false).transpose()?,
        shown(true).transpose()?,
    );
    parts.into_pyobject(py)
}
