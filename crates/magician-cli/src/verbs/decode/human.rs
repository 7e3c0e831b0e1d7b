//! Pieces for people: a line each, its fields below.

use magician_protocol::{DecodeError, Description, Direction, Frame, Rejection};

use super::Printer;
use crate::columns::{Columns, wrap};
use crate::failure::Failure;
use crate::output::Output;

/// Bytes of a run of noise that are shown.
const SHOWN: usize = 32;
/// Columns of the offset.
const OFFSET: usize = 8;

/// Writes the pieces as lines.
pub(super) struct Lines<'o> {
    out: &'o mut Output,
    noise: Noise,
}

/// A run of noise as far as it has come.
#[derive(Default)]
struct Noise {
    offset: u64,
    count: u64,
    first: Vec<u8>,
}

impl<'o> Lines<'o> {
    pub(super) fn new(out: &'o mut Output) -> Self {
        Self {
            out,
            noise: Noise::default(),
        }
    }

    fn title(
        &mut self,
        offset: u64,
        direction: &str,
        name: &str,
        about: &str,
    ) -> Result<(), Failure> {
        let paint = self.out.paint;
        let offset = format!("{offset:<OFFSET$}");
        let line = format!(
            "{}{direction:<9}{}{about}",
            paint.dim(offset),
            paint.name(name)
        );
        self.out.line(line.trim_end())
    }

    fn bad(&mut self, offset: u64, what: &str, about: &str) -> Result<(), Failure> {
        let paint = self.out.paint;
        let offset = format!("{offset:<OFFSET$}");
        let what = format!("{what:<9}");
        self.out.line(format_args!(
            "{}{}{about}",
            paint.dim(offset),
            paint.error(what)
        ))
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let text = spaced(bytes);
        for line in wrap(&text, self.out.width().saturating_sub(OFFSET).min(3 * 32)) {
            let line = self.out.paint.dim(line).to_string();
            self.out.line(format_args!("{:OFFSET$}{line}", ""))?;
        }
        Ok(())
    }

    fn fields(&mut self, description: &Description<'_>) -> Result<(), Failure> {
        let mut columns = Columns::indented(OFFSET);
        let values = description
            .values()
            .map_err(|error| Failure::invalid(error.to_string()))?;
        for (field, value) in values {
            let unit = match field.unit {
                "flag" | "enum" | "text" | "bytes" | "bitmap" | "reserved" => "",
                unit => unit,
            };
            let value = value.to_string().replace(',', ", ").replace(",  ", ", ");
            columns.row([
                field.name.to_owned(),
                format!("{value} {unit}").trim_end().to_owned(),
            ]);
        }
        columns.write(self.out)
    }
}

fn spaced(bytes: &[u8]) -> String {
    let pairs: Vec<_> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(" ")
}

impl Printer for Lines<'_> {
    fn frame(
        &mut self,
        offset: u64,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure> {
        match meaning {
            Ok(description) => {
                let direction = match description.direction {
                    Direction::Request => "request",
                    Direction::Reply => "reply",
                };
                let queued = if description.queued { "  queued" } else { "" };
                self.title(offset, direction, description.name, queued)?;
                self.bytes(frame.bytes())?;
                self.fields(&description)?;
                for note in description.notes() {
                    let note = self
                        .out
                        .paint
                        .note(format_args!("note: {note}"))
                        .to_string();
                    self.out.line(format_args!("{:OFFSET$}{note}", ""))?;
                }
                Ok(())
            }
            Err(error @ DecodeError::UnknownId(_)) => {
                self.bad(offset, "unknown", &error.to_string())?;
                self.bytes(frame.bytes())
            }
            Err(error) => {
                let name = magician_protocol::Row::with_id(frame.id()).map_or("", |row| row.name);
                self.bad(offset, "length", &format!("{name}: {error}"))?;
                self.bytes(frame.bytes())
            }
        }
    }

    fn rejected(&mut self, offset: u64, bytes: &[u8], reason: Rejection) -> Result<(), Failure> {
        let (what, about) = match reason {
            Rejection::Checksum { expected, found } => (
                "checksum",
                format!("is {found:02X}, the bytes call for {expected:02X}"),
            ),
            Rejection::Length(len) => ("length", format!("is {len}, a frame has 2 to 250")),
            Rejection::Truncated => ("truncated", " the input ends inside the frame".to_owned()),
        };
        self.bad(offset, what, &about)?;
        self.bytes(bytes)
    }

    fn noise_begins(&mut self, offset: u64) -> Result<(), Failure> {
        self.noise = Noise {
            offset,
            ..Noise::default()
        };
        Ok(())
    }

    fn noise(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.noise.count += bytes.len() as u64;
        let room = SHOWN.saturating_sub(self.noise.first.len());
        self.noise.first.extend(bytes.iter().take(room));
        Ok(())
    }

    fn noise_ends(&mut self) -> Result<(), Failure> {
        let Noise {
            offset,
            count,
            first,
        } = std::mem::take(&mut self.noise);
        let bytes = if count == 1 { "byte" } else { "bytes" };
        let more = if count > SHOWN as u64 { " ..." } else { "" };
        let text = first.escape_ascii();
        self.bad(
            offset,
            "noise",
            &format!("{count} {bytes}: \"{text}\"{more}"),
        )?;
        self.bytes(&first)
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.out.flush()
    }
}
