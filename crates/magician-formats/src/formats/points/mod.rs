//! Lists of points that programs write for themselves: CSV with a header, JSON made of playback rows, and text files of strokes.
//! Coordinates are the arm's, mm and degrees.
//!
//! * CSV, as made of playback files (`X,Y,Z,R,Velocity,Acceleration,Suction`): one point a line, by the names of its columns.
//!   Where such a file was seen, its columns *Velocity* and *Acceleration* hold the pauses of the playback file that it was made
//!   of, so that they are not taken for speeds; a pause is taken from a column *Pause* or *PauseTime*.
//! * JSON (`{"rows": {"row0": {"MotionStyle": "MOVL", "X": 200, ..}}}`, or the rows at the top): the same by the names of its
//!   members, and arcs, whose end is `_X` to `_R`.
//! * Recordings (`magician record`, `run --record`): CSV with a column `t`, and MCAP with `/pose`. They are followed in their own
//!   time.
//! * Text: `x,y,z` lines without a header, each run of them a stroke of the pen.

mod csv;
mod json;
mod mcap;
mod recording;
mod row;
mod strokes;

use super::content::points::{MAGIC, is_strokes};
use super::{Content, Parsed, ReadOptions, only_recordings};
use crate::encoding::{Otherwise, decode};
use crate::{Diagnostic, Origin};

/// Reads a list of points of any of the three kinds.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    if bytes.starts_with(MAGIC) {
        let mut reading = mcap::read(bytes, options.resample)?;
        reading.content.title.clone_from(&options.title);
        return Ok(Parsed {
            content: Content::Plan(reading.content),
            notes: reading.notes,
        });
    }
    let decoded = decode(bytes, Otherwise::Western)?;
    let text = decoded.text.as_ref();
    let mut reading = match text.trim_start() {
        "" => return Err(Diagnostic::of_file("the file has no points")),
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

/// That something is not a number.
fn no_number(origin: Origin, what: &str, found: &str) -> Diagnostic {
    let found: String = found.chars().take(30).collect();
    Diagnostic::new(
        origin,
        format!("{what} must be a number, and this is '{found}'"),
    )
}
