//! Decoded pieces for people: one line per piece, its fields below.

use magician_protocol::{DecodeError, Description, Frame, Rejection};
use magician_record::pieces::{Place, Sink};

use super::direction_word;
use crate::columns::wrap;
use crate::failure::Failure;
use crate::output::Output;
use crate::values;

/// Largest number of bytes shown of a run of noise.
const MAX_NOISE_BYTES: usize = 32;
/// Columns of the offset.
const OFFSET_WIDTH: usize = 8;

/// Writes pieces as lines.
pub(super) struct Lines<'o> {
    out: &'o mut Output,
    noise: Noise,
    /// Times of the first and the latest packet of a capture, µs.
    first: Option<u64>,
    last: u64,
}

/// Run of noise that has not ended yet.
#[derive(Default)]
struct Noise {
    position: String,
    count: u64,
    first: Vec<u8>,
}

impl<'o> Lines<'o> {
    pub(super) fn new(out: &'o mut Output) -> Self {
        Self {
            out,
            noise: Noise::default(),
            first: None,
            last: 0,
        }
    }

    fn title(
        &mut self,
        place: Place<'_>,
        direction: &str,
        name: &str,
        about: &str,
    ) -> Result<(), Failure> {
        let position = self.position(place);
        let paint = self.out.paint;
        let line = format!(
            "{}{direction:<9}{}{about}",
            paint.dim(position),
            paint.name(name)
        );
        self.out.line(line.trim_end())
    }

    fn write_error(&mut self, place: Place<'_>, what: &str, about: &str) -> Result<(), Failure> {
        let position = self.position(place);
        self.write_error_at(&position, what, about)
    }

    fn write_error_at(&mut self, position: &str, what: &str, about: &str) -> Result<(), Failure> {
        let paint = self.out.paint;
        let what = paint.error(format!("{what:<8} ")).to_string();
        self.out
            .line(format_args!("{}{what}{about}", paint.dim(position)))
    }

    /// Returns the offset, or for a capture the link and the time since its first packet.
    fn position(&mut self, place: Place<'_>) -> String {
        let Some((_, link)) = place.origin.link else {
            return format!("{:<OFFSET_WIDTH$}", place.offset);
        };
        let time = place.origin.time.unwrap_or(self.last);
        self.last = time;
        let since = time.saturating_sub(*self.first.get_or_insert(time));
        let (seconds, micros) = (since / 1_000_000, since % 1_000_000);
        format!("{seconds}.{micros:06} s  {link}  ")
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let text = spaced(bytes);
        for line in wrap(
            &text,
            self.out.width().saturating_sub(OFFSET_WIDTH).min(3 * 32),
        ) {
            let line = self.out.paint.dim(line).to_string();
            self.out.line(format_args!("{:OFFSET_WIDTH$}{line}", ""))?;
        }
        Ok(())
    }

    fn fields(&mut self, description: &Description<'_>) -> Result<(), Failure> {
        values::columns(description, OFFSET_WIDTH)?.write(self.out)
    }
}

fn spaced(bytes: &[u8]) -> String {
    let pairs: Vec<_> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(" ")
}

impl Sink for Lines<'_> {
    type Error = Failure;

    fn frame(
        &mut self,
        place: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure> {
        match meaning {
            Ok(description) => {
                let direction = direction_word(description.direction);
                let queued = if description.queued { "  queued" } else { "" };
                self.title(place, direction, description.name, queued)?;
                self.bytes(frame.bytes())?;
                self.fields(&description)?;
                for note in description.notes() {
                    let note = self
                        .out
                        .paint
                        .note(format_args!("note: {note}"))
                        .to_string();
                    self.out.line(format_args!("{:OFFSET_WIDTH$}{note}", ""))?;
                }
                Ok(())
            }
            Err(error @ DecodeError::UnknownId(_)) => {
                self.write_error(place, "unknown", &error.to_string())?;
                self.bytes(frame.bytes())
            }
            Err(error) => {
                let name = magician_protocol::Row::with_id(frame.id()).map_or("", |row| row.name);
                self.write_error(place, "length", &format!("{name}: {error}"))?;
                self.bytes(frame.bytes())
            }
        }
    }

    fn rejected(
        &mut self,
        place: Place<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Failure> {
        self.write_error(place, reason.name(), &format!("{reason:#}"))?;
        self.bytes(bytes)
    }

    fn noise_begins(&mut self, place: Place<'_>) -> Result<(), Failure> {
        self.noise = Noise {
            position: self.position(place),
            ..Noise::default()
        };
        Ok(())
    }

    fn noise(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.noise.count += bytes.len() as u64;
        let room = MAX_NOISE_BYTES.saturating_sub(self.noise.first.len());
        self.noise.first.extend(bytes.iter().take(room));
        Ok(())
    }

    fn noise_ends(&mut self) -> Result<(), Failure> {
        let Noise {
            position,
            count,
            first,
        } = std::mem::take(&mut self.noise);
        let bytes = if count == 1 { "byte" } else { "bytes" };
        let more = if count > MAX_NOISE_BYTES as u64 {
            " ..."
        } else {
            ""
        };
        let text = first.escape_ascii();
        self.write_error_at(
            &position,
            "noise",
            &format!("{count} {bytes}: \"{text}\"{more}"),
        )?;
        self.bytes(&first)
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.out.flush()
    }
}
