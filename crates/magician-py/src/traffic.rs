//! Decoding of the bytes of a line, for `magician.decode`.

use magician_protocol::{
    DecodeError, Description, Direction, FieldValue, Frame, QueuedCmdIndex, Rejection, Row,
};
use magician_record::hex;
use magician_record::pieces::{Decoder, Origin, Place, Sink};
use magician_record::trace::is_trace;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PyModule, PyTuple};

use crate::{errors, values};

/// Collects decoded pieces as objects of `magician.traffic`.
struct PieceCollector<'py> {
    module: Bound<'py, PyModule>,
    commands: Bound<'py, PyModule>,
    found: Bound<'py, PyList>,
    /// Current run of noise: its position and bytes.
    noise: Option<(PieceSource, Vec<u8>)>,
}

/// Offset, link, and time in s since 1970.
type PieceSource = (u64, Option<String>, Option<f64>);

fn place(place: &Place<'_>) -> PieceSource {
    let origin = &place.origin;
    let link = origin.link.map(|(_, name)| name.to_owned());
    let time = origin.time.map(|time| time as f64 / 1e6);
    (place.offset, link.filter(|name| !name.is_empty()), time)
}

impl<'py> PieceCollector<'py> {
    fn new(py: Python<'py>) -> PyResult<Self> {
        Ok(Self {
            module: py.import("magician.traffic")?,
            commands: py.import("magician.commands")?,
            found: PyList::empty(py),
            noise: None,
        })
    }

    fn bad(
        &self,
        at: PieceSource,
        bytes: &[u8],
        error: &str,
        why: &str,
        frame: Option<&Frame<'_>>,
    ) -> PyResult<()> {
        let (offset, link, time) = at;
        let row = frame.and_then(|frame| Some((Row::with_id(frame.id())?, frame)));
        let name = row.map(|(row, frame)| row.form_name(frame.ctrl()));
        let bytes = PyBytes::new(self.found.py(), bytes);
        let id = frame.map(|frame| u32::from(frame.id()));
        let rejected = self.module.getattr("Rejected")?;
        let parts = (offset, bytes, error, why, id, name, link, time);
        self.found.append(rejected.call1(parts)?)
    }

    /// Decodes parameters: a command, or the index that a queued command got. Both are `None` if
    /// there are no parameters.
    fn meaning(
        &self,
        meant: &Description<'_>,
        params: &[u8],
    ) -> PyResult<(Option<Py<PyAny>>, Option<u64>)> {
        use magician_protocol::Layout as _;
        if meant.layout == QueuedCmdIndex::INFO {
            let index = meant
                .values()
                .ok()
                .and_then(|mut fields| match fields.next() {
                    Some((_, FieldValue::Unsigned(index))) => Some(index),
                    _ => None,
                });
            return Ok((None, index));
        }
        match self.commands.getattr_opt(meant.layout.name)? {
            Some(class) => Ok((Some(values::decode(&class, meant.layout, params)?), None)),
            None => Ok((None, None)),
        }
    }
}

impl Sink for PieceCollector<'_> {
    type Error = PyErr;

    fn frame(
        &mut self,
        at: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> PyResult<()> {
        let at = place(&at);
        let meant = match meaning {
            Ok(meant) => meant,
            Err(error) => {
                let what = match error {
                    DecodeError::UnknownId(_) => "unknown",
                    _ => "length",
                };
                return self.bad(at, frame.bytes(), what, &error.to_string(), Some(frame));
            }
        };
        let py = self.found.py();
        let (value, index) = self.meaning(&meant, frame.params())?;
        let (offset, link, time) = at;
        let direction = match meant.direction {
            Direction::Request => "request",
            Direction::Reply => "reply",
        };
        let notes = PyTuple::new(py, meant.notes().collect::<Vec<_>>())?;
        let seen = (offset, PyBytes::new(py, frame.bytes()), link, time);
        let form = (u32::from(frame.id()), meant.name, direction);
        let carried = (value, index, PyBytes::new(py, frame.params()));
        let flags = (meant.write, meant.queued);
        let decoded = py.import("magician._conversion")?.getattr("decoded")?;
        self.found
            .append(decoded.call1((seen, form, flags, carried, notes))?)
    }

    fn rejected(&mut self, at: Place<'_>, bytes: &[u8], reason: Rejection) -> PyResult<()> {
        self.bad(place(&at), bytes, reason.name(), &reason.to_string(), None)
    }

    fn noise_begins(&mut self, at: Place<'_>) -> PyResult<()> {
        self.noise = Some((place(&at), Vec::new()));
        Ok(())
    }

    fn noise(&mut self, bytes: &[u8]) -> PyResult<()> {
        if let Some((_, run)) = &mut self.noise {
            run.extend_from_slice(bytes);
        }
        Ok(())
    }

    fn noise_ends(&mut self) -> PyResult<()> {
        match self.noise.take() {
            Some((at, run)) => self.bad(at, &run, "noise", "no frame begins in these bytes", None),
            None => Ok(()),
        }
    }
}

/// Decodes bytes of a capture or a line to pieces. The content of a `file` may also be hex text.
#[pyfunction]
pub(crate) fn pieces(
    py: Python<'_>,
    data: &[u8],
    file: bool,
    sender: Option<&str>,
) -> PyResult<Py<PyAny>> {
    let sender = match sender {
        None => None,
        Some("host") => Some(Direction::Request),
        Some("arm") => Some(Direction::Reply),
        Some(_) => return Err(PyTypeError::new_err("the sender is \"host\" or \"arm\"")),
    };
    let mut decoder = Decoder::new(sender, PieceCollector::new(py)?);
    if is_trace(data) {
        let wrong = decoder.capture(data)?;
        let (_, pieces) = decoder.finish()?;
        if let Some(error) = wrong {
            let at = (data.len() as u64, None, None);
            pieces.bad(at, &[], "trace", &error.to_string(), None)?;
        }
        return Ok(pieces.found.into_any().unbind());
    }
    let text = std::str::from_utf8(data).ok();
    match text.filter(|text| file && hex::is_hex(text)) {
        Some(text) => decoder.push(Origin::default(), &parse_hex(py, text)?)?,
        None => decoder.push(Origin::default(), data)?,
    }
    let (_, pieces) = decoder.finish()?;
    Ok(pieces.found.into_any().unbind())
}

/// Parses hex text to bytes. Returns `None` for other text.
#[pyfunction]
pub(crate) fn hex_bytes<'py>(py: Python<'py>, text: &str) -> PyResult<Option<Bound<'py, PyBytes>>> {
    if !hex::is_hex(text) {
        return Ok(None);
    }
    Ok(Some(PyBytes::new(py, &parse_hex(py, text)?)))
}

fn parse_hex(py: Python<'_>, text: &str) -> PyResult<Vec<u8>> {
    hex::bytes(text)
        .map_err(|error| errors::raise(py, &magician::Error::invalid(error.to_string())))
}
