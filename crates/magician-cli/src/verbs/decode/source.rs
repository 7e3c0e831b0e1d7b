//! Input of `decode`: arguments, a file or standard input; as bytes, as hex text or as a capture.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Seek};

use magician_record::hex::{HexError, Parser, Test, is_hex};
use magician_record::pieces::{Decoder, Origin, Sink};
use magician_record::trace::is_trace;

use crate::failure::Failure;

// Size of a read. A choice.
const CHUNK_SIZE: usize = 1 << 16;
/// Number of bytes that identify a capture file.
const MAGIC_LENGTH: usize = 4;

/// Feeds all input that the arguments name into the decoder, in bounded memory.
pub(super) fn read(
    input: &[OsString],
    decoder: &mut Decoder<impl Sink<Error = Failure>>,
) -> Result<(), Failure> {
    if let [argument] = input
        && argument == "-"
    {
        return InputFeed::new(decoder).stream(&mut io::stdin().lock(), "stdin");
    }
    let words: Vec<_> = input.iter().map(|word| word.to_string_lossy()).collect();
    let text = words.join(" ");
    if is_hex(&text) {
        return InputFeed::new(decoder).text(text.as_bytes());
    }
    match input {
        [name] => file(name, &words[0], decoder),
        _ => {
            let odd = words.iter().find(|word| !is_hex(word));
            let odd = odd.map_or("", |word| word);
            let message = format!("`{odd}` is not hex; several arguments must all be hex");
            Err(Failure::invalid(message))
        }
    }
}

fn file(
    path: &OsString,
    name: &str,
    decoder: &mut Decoder<impl Sink<Error = Failure>>,
) -> Result<(), Failure> {
    let unreadable = |error: io::Error| {
        Failure::invalid(format!(
            "`{name}` is neither hex nor a readable file: {error}"
        ))
    };
    let mut file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(Failure::invalid(format!("`{name}` is a directory")));
    }
    if !metadata.is_file() {
        return InputFeed::new(decoder).stream(&mut file, name);
    }
    let encoding = detect_encoding(&mut file).map_err(unreadable)?;
    file.rewind().map_err(unreadable)?;
    InputFeed { decoder, encoding }.rest(&mut file, name)
}

/// Encoding of an input.
#[derive(Clone, Copy)]
enum Encoding {
    Bytes,
    Text(Parser),
    Capture,
}

/// Reads a whole file to find out its encoding.
fn detect_encoding(file: &mut impl Read) -> io::Result<Encoding> {
    let mut chunk = [0; CHUNK_SIZE];
    let mut test = Test::default();
    let mut first = fill(file, &mut chunk)?;
    if is_trace(&chunk) {
        return Ok(Encoding::Capture);
    }
    // A single character that does not fit makes the whole file binary.
    while first > 0 {
        if !test.accepts(&chunk[..first]) {
            return Ok(Encoding::Bytes);
        }
        first = fill(file, &mut chunk)?;
    }
    Ok(Encoding::Text(Parser::default()))
}

/// Reads until there are enough bytes to identify a capture, or the input ends.
fn fill(from: &mut impl Read, chunk: &mut [u8]) -> io::Result<usize> {
    let mut count = 0;
    while count < MAGIC_LENGTH {
        match from.read(&mut chunk[count..]) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
    }
    Ok(count)
}

/// Converts input of some encoding and passes it to the decoder.
struct InputFeed<'d, S: Sink<Error = Failure>> {
    decoder: &'d mut Decoder<S>,
    encoding: Encoding,
}

impl<'d, S: Sink<Error = Failure>> InputFeed<'d, S> {
    fn new(decoder: &'d mut Decoder<S>) -> Self {
        Self {
            decoder,
            encoding: Encoding::Bytes,
        }
    }

    fn text(mut self, text: &[u8]) -> Result<(), Failure> {
        self.encoding = Encoding::Text(Parser::default());
        self.push(text)?;
        self.finish()
    }

    /// Reads input that can be read only once. Its beginning decides about the encoding.
    fn stream(mut self, from: &mut impl Read, name: &str) -> Result<(), Failure> {
        let mut chunk = [0; CHUNK_SIZE];
        let count = fill(from, &mut chunk).map_err(|error| broken(name, &error))?;
        let first = &chunk[..count];
        if is_trace(first) {
            self.encoding = Encoding::Capture;
            return self.rest(&mut first.chain(from), name);
        }
        if Test::default().accepts(first) {
            self.encoding = Encoding::Text(Parser::default());
        }
        self.push(first)?;
        self.rest(from, name)
    }

    fn rest(mut self, from: &mut impl Read, name: &str) -> Result<(), Failure> {
        if matches!(self.encoding, Encoding::Capture) {
            return self.capture(from, name);
        }
        let mut chunk = [0; CHUNK_SIZE];
        loop {
            match from.read(&mut chunk) {
                Ok(0) => return self.finish(),
                Ok(count) => self.push(&chunk[..count])?,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
                Err(error) => return Err(broken(name, &error)),
            }
        }
    }

    /// Reads a capture completely, since its blocks refer to each other.
    fn capture(self, from: &mut impl Read, name: &str) -> Result<(), Failure> {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes)
            .map_err(|error| broken(name, &error))?;
        let wrong = self.decoder.capture(&bytes)?;
        wrong.map_or(Ok(()), |error| {
            Err(Failure::invalid(format!("{name}: {error}")))
        })
    }

    fn push(&mut self, chunk: &[u8]) -> Result<(), Failure> {
        match &mut self.encoding {
            Encoding::Text(parser) => {
                let mut bytes = Vec::with_capacity(chunk.len() / 2 + 1);
                let parsed = parser.push(chunk, &mut bytes);
                // Bytes before a mistake are decoded before the mistake is reported.
                self.decoder.push(Origin::default(), &bytes)?;
                parsed.map_err(not_hex)?;
            }
            _ => self.decoder.push(Origin::default(), chunk)?,
        }
        // Flushed after each chunk, so that a live stream is shown at once.
        self.decoder.flush()
    }

    fn finish(self) -> Result<(), Failure> {
        let Encoding::Text(mut parser) = self.encoding else {
            return Ok(());
        };
        let mut bytes = Vec::new();
        parser.finish(&mut bytes).map_err(not_hex)?;
        self.decoder.push(Origin::default(), &bytes)
    }
}

fn broken(name: &str, error: &io::Error) -> Failure {
    Failure::invalid(format!("{name} cannot be read: {error}"))
}

fn not_hex(error: HexError) -> Failure {
    let failure = Failure::invalid(error.to_string());
    match error {
        HexError::Odd(_) => failure.hint("for a file with such a name write ./NAME"),
        HexError::Letter(_) => failure,
    }
}
