//! Reader of lists of points and recordings, as programs write them. Coordinates are the arm's, mm
//! and degrees.
//!
//! * CSV, as converted from playback files (`X,Y,Z,R,Velocity,Acceleration,Suction`): one point per
//!   line, by column name. In known files of this kind *Velocity* and *Acceleration* contain the
//!   pauses of the original, so they are ignored; a pause is read from a column *Pause* or
//!   `PauseTime`.
//! * JSON (`{"rows": {"row0": {"MotionStyle": "MOVL", "X": 200, ..}}}`, or the rows at the top
//!   level): the same by member name, and arcs, which end at `_X` to `_R`.
//! * Recordings (`magician record`, `run --record`): CSV with a column `t`, and MCAP with `/pose`.
//!   They are replayed in their own time.
//! * Text: lines `x,y,z` without a header; each run of lines is a stroke of the pen.

mod csv;
mod json;
mod mcap;
mod recording;
mod row;
mod strokes;

use magician_host::{Message, message};

use super::content::points::{MCAP_MAGIC, is_strokes};
use super::{Content, Parsed, ReadOptions, only_recordings};
use crate::encoding::{Fallback, decode};
use crate::{Diagnostic, Origin};

/// Reads a list of points of any kind.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    if bytes.starts_with(MCAP_MAGIC) {
        let mut reading = mcap::read(bytes, options.resample)?;
        reading.content.title.clone_from(&options.title);
        return Ok(Parsed {
            content: Content::Plan(reading.content),
            notes: reading.notes,
        });
    }
    let decoded = decode(bytes, Fallback::Western)?;
    let text = decoded.text.as_ref();
    let mut reading = match text.trim_start() {
        "" => return Err(Diagnostic::of_file(message!("the file has no points"))),
        json if json.starts_with('{') => {
            only_recordings(options.resample)?;
            json::read(text)?
        }
        _ if is_strokes(text) => {
            only_recordings(options.resample)?;
            strokes::read(text)?
        }
        _ => csv::read(text, options.resample)?,
    };
    reading.content.title.clone_from(&options.title);
    reading.notes.extend(decoded.note);
    Ok(Parsed {
        content: Content::Plan(reading.content),
        notes: reading.notes,
    })
}

/// Creates the diagnostic that a value is not a number.
fn no_number(origin: Origin, what: Message, found: &str) -> Diagnostic {
    let found: String = found.chars().take(30).collect();
    Diagnostic::new(
        origin,
        message!(
            "{what} must be a number, and this is '{found}'",
            what,
            found
        ),
    )
}
