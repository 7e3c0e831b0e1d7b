//! A file to be read, and what was in it, as bytes: for a reader in another WebAssembly module.
//!
//! Both modules are of one build, and the form is promised to nobody else. It begins with [`FORM`], which is another one after
//! each change of this file or version: what another build has written is refused, never misread. No bytes make it panic, and
//! none make it take more memory than a small multiple of their number.
#![allow(clippy::cast_possible_truncation)] // Lengths are below 2^32 on what this runs on, and are read back by their u64.

use std::borrow::Cow;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use magician_host::{Act, Action as Deed, Given, Remedy, Setting};
use magician_protocol::{MAX_PARAMS, Set, Writer};

use crate::artwork::{DrawingPart, Layer, PartPen, Style};
use crate::fill::{Area, FillMode, FillRule};
use crate::formats::{Arcs, Dialect, GcodeOptions};
use crate::{
    Action, Align, Artwork, BundledFont, Color, Content, Diagnostic, DiagnosticCode, FilledArea,
    Fills, FontChoice, Format, Missing, Origin, Parsed, Part, Pause, PauseCause, Plan, Raster,
    ReadOptions, Step, Stroke, Surface, TextLines, TextOptions, Tool, White, read,
};

/// What came of reading a file.
pub type FileAnswer = Result<Parsed, Diagnostic>;

/// A file to be read.
#[derive(Clone, Debug)]
pub struct FileRequest {
    /// What it is.
    pub format: Format,
    /// How it is read, where it leaves a choice.
    pub options: ReadOptions,
    /// What is in it.
    pub bytes: Arc<[u8]>,
}

/// Bytes that are no request or answer of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WireError {
    /// Another build wrote them.
    OtherBuild,
    /// They are cut short, or damaged.
    Malformed,
}

impl fmt::Display for WireError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherBuild => {
                "the file reader is from another version of this page: reload the page"
            }
            Self::Malformed => "the file reader gave a damaged answer",
        })
    }
}

impl std::error::Error for WireError {}

/// What the form is known by: FNV-1a of this file and the version.
pub const FORM: [u8; 8] = form().to_le_bytes();

const fn form() -> u64 {
    let mut hash = 0xCBF2_9CE4_8422_2325;
    let mut part = 0;
    let parts: [&[u8]; 2] = [
        include_bytes!("wire.rs"),
        env!("CARGO_PKG_VERSION").as_bytes(),
    ];
    while part < parts.len() {
        let mut at = 0;
        while at < parts[part].len() {
            hash = (hash ^ parts[part][at] as u64).wrapping_mul(0x0100_0000_01B3);
            at += 1;
        }
        part += 1;
    }
    hash
}

impl FileRequest {
    /// As bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.bytes.len() + 256);
        out.extend(FORM);
        self.format.put(&mut out);
        self.options.put(&mut out);
        out.extend_from_slice(&self.bytes);
        out
    }

    /// Whether it asks for the same as another.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        self.format == other.format
            && self.options == other.options
            && (Arc::ptr_eq(&self.bytes, &other.bytes) || self.bytes == other.bytes)
    }
}

/// Reads what a request asks for: the answer as bytes.
#[must_use]
pub fn answer(request: &[u8]) -> Vec<u8> {
    let mut input = Input(request);
    let asked = input.form().and_then(|()| {
        let asked = Option::zip(Format::take(&mut input), ReadOptions::take(&mut input));
        asked.ok_or(WireError::Malformed)
    });
    match asked {
        Ok((format, options)) => answer_bytes(&read(format, input.0, &options)),
        // No answer: whoever asked sees the form, and no more.
        Err(_) => FORM.to_vec(),
    }
}

/// What came of reading a file, as bytes.
#[must_use]
pub fn answer_bytes(answer: &FileAnswer) -> Vec<u8> {
    let mut out = FORM.to_vec();
    match answer {
        Ok(parsed) => {
            out.push(0);
            parsed.put(&mut out);
        }
        Err(problem) => {
            out.push(1);
            problem.put(&mut out);
        }
    }
    out
}

/// What came of reading a file, from its bytes.
///
/// # Errors
/// Where they are no answer of this build.
pub fn answer_from(bytes: &[u8]) -> Result<FileAnswer, WireError> {
    let mut input = Input(bytes);
    input.form()?;
    let answer = match u8::take(&mut input) {
        Some(0) => Parsed::take(&mut input).map(Ok),
        Some(1) => Diagnostic::take(&mut input).map(Err),
        _ => None,
    };
    { answer.filter(|_| input.0.is_empty()) }.ok_or(WireError::Malformed)
}

/// What is left to be taken.
struct Input<'b>(&'b [u8]);

impl<'b> Input<'b> {
    fn form(&mut self) -> Result<(), WireError> {
        match self.bytes(FORM.len()) {
            Some(form) if form == FORM => Ok(()),
            Some(_) => Err(WireError::OtherBuild),
            None => Err(WireError::Malformed),
        }
    }

    fn bytes(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }
}

trait Wire: Sized {
    /// The least bytes that one takes.
    const LEAST: usize = 1;

    fn put(&self, out: &mut Vec<u8>);
    fn take(input: &mut Input<'_>) -> Option<Self>;
}

/// Little endian, as they are.
macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            const LEAST: usize = size_of::<Self>();

            fn put(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                let bytes = input.bytes(size_of::<Self>())?;
                Some(Self::from_le_bytes(bytes.try_into().ok()?))
            }
        }
    )*};
}
numbers!(u8, f32, f64);

/// Seven bits in each byte, the lowest first.
impl Wire for u64 {
    fn put(&self, out: &mut Vec<u8>) {
        let mut left = *self;
        while left >= 0x80 {
            out.push(left as u8 | 0x80);
            left >>= 7;
        }
        out.push(left as u8);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = u8::take(input)?;
            number |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }
}

macro_rules! counts {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            fn put(&self, out: &mut Vec<u8>) {
                (*self as u64).put(out);
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                u64::take(input)?.try_into().ok()
            }
        }
    )*};
}
counts!(u32, usize);

impl Wire for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        match u8::take(input)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Wire> Wire for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        if let Some(what) = self {
            what.put(out);
        }
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        match bool::take(input)? {
            true => T::take(input).map(Some),
            false => Some(None),
        }
    }
}

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const LEAST: usize = N * T::LEAST;

    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|one| one.put(out));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let mut all = [T::default(); N];
        for one in &mut all {
            *one = T::take(input)?;
        }
        Some(all)
    }
}

impl<T: Wire> Wire for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        self.iter().for_each(|one| one.put(out));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let count = usize::take(input)?;
        // So many cannot be in what is left: nothing is set aside for them.
        if count > input.0.len() / T::LEAST {
            return None;
        }
        let mut all = Self::with_capacity(count);
        for _ in 0..count {
            all.push(T::take(input)?);
        }
        Some(all)
    }
}

impl Wire for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        out.extend(self.as_bytes());
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let count = usize::take(input)?;
        let text = std::str::from_utf8(input.bytes(count)?).ok()?;
        Some(text.to_owned())
    }
}

impl Wire for Cow<'static, str> {
    fn put(&self, out: &mut Vec<u8>) {
        self.as_ref().to_owned().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        String::take(input).map(Cow::Owned)
    }
}

/// Words of our own code that have come so far, at most, and how long one may be.
const WORDS: usize = 256;
const LONGEST: usize = 64;

/// A word of our own code; a bounded number of them lasts as long as the program.
impl Wire for &'static str {
    fn put(&self, out: &mut Vec<u8>) {
        (*self).to_owned().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        static KNOWN: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
        let word = String::take(input)?;
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.iter().find(|known| **known == word) {
            return Some(*found);
        }
        if known.len() == WORDS || word.len() > LONGEST {
            return None;
        }
        let word: &'static str = Box::leak(word.into_boxed_str());
        known.push(word);
        Some(word)
    }
}

/// All fields, in this order: one that is forgotten does not compile.
macro_rules! fields {
    ($($kind:ident { $($field:ident),* $(,)? })*) => {$(
        impl Wire for $kind {
            fn put(&self, out: &mut Vec<u8>) {
                let Self { $($field),* } = self;
                $($field.put(out);)*
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                $(let $field = Wire::take(input)?;)*
                Some(Self { $($field),* })
            }
        }
    )*};
}
fields! {
    Surface { height, slope }
    Origin { line, column, length, name }
    Plan { title, tool, surface, steps, names }
    Step { action, origin, feed, follows_speed }
    Part { n, name, color, pass }
    Pause { text, cause }
    Artwork { title, page, strokes, areas, names, layers, colors, parts, in_order }
    Stroke { points, origin, style }
    FilledArea { area, origin, style }
    Style { layer, color, part }
    Layer { name, inkscape }
    DrawingPart { part, waits, skipped, passes, pen }
    PartPen { surface_offset, lift, speed, power, fill }
    Area { rings, rule }
    TextOptions { font, size, wrap, align, line_height }
    Diagnostic { origin, name, code, message, help, remedies, missing }
    Remedy { act, effect }
    Parsed { content, notes }
    ReadOptions {
        title, tolerance, gcode, fills, white, clip_page, resample, text, text_lines, strict_text,
    }
    GcodeOptions {
        dialect, start, placed, s_max, laser_speed, surface, lift, travel_speed,
        travel_acceleration, acceleration, arcs, home,
    }
}

impl Wire for Color {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        Wire::take(input).map(Self)
    }
}

/// Grey is bytes already.
impl Wire for Raster {
    fn put(&self, out: &mut Vec<u8>) {
        let Self {
            title,
            width,
            height,
            grey,
            pixel,
        } = self;
        title.put(out);
        width.put(out);
        height.put(out);
        pixel.put(out);
        grey.len().put(out);
        out.extend_from_slice(grey);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let (title, width, height) = (Wire::take(input)?, Wire::take(input)?, Wire::take(input)?);
        let pixel = Wire::take(input)?;
        let count = usize::take(input)?;
        let grey = input.bytes(count)?.to_vec();
        Some(Self {
            title,
            width,
            height,
            grey,
            pixel,
        })
    }
}

/// A font of a file comes with its bytes.
impl Wire for FontChoice {
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Bundled(font) => {
                out.push(0);
                font.put(out);
            }
            Self::File { name, bytes } => {
                out.push(1);
                name.put(out);
                bytes.len().put(out);
                out.extend_from_slice(bytes);
            }
        }
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        Some(match u8::take(input)? {
            0 => Self::Bundled(Wire::take(input)?),
            1 => {
                let (name, count) = (String::take(input)?, usize::take(input)?);
                Self::file(name, input.bytes(count)?)
            }
            _ => return None,
        })
    }
}

/// Kinds by a byte.
macro_rules! kinds {
    ($($kind:ident { $($number:literal = $variant:ident $(($($part:ident),*))?),* $(,)? })*) => {$(
        impl Wire for $kind {
            fn put(&self, out: &mut Vec<u8>) {
                match self {
                    $(Self::$variant $(($($part),*))? => {
                        out.push($number);
                        $($($part.put(out);)*)?
                    })*
                }
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                Some(match u8::take(input)? {
                    $($number => {
                        $($(let $part = Wire::take(input)?;)*)?
                        Self::$variant $(($($part),*))?
                    })*
                    _ => return None,
                })
            }
        }
    )*};
}
kinds! {
    Content { 0 = Plan(plan), 1 = Artwork(artwork), 2 = Image(image) }
    Tool { 0 = None, 1 = Suction, 2 = Gripper, 3 = Pen, 4 = Laser, 5 = Bias(bias) }
    Missing { 0 = Start, 1 = Feature(feature) }
    Fills { 0 = Outline, 1 = Ignore, 2 = Areas }
    FillMode { 0 = None, 1 = Hatch, 2 = Cross, 3 = Contour }
    FillRule { 0 = NonZero, 1 = EvenOdd }
    TextLines { 0 = Outline, 1 = Stroke }
    Align { 0 = Left, 1 = Center, 2 = Right }
    BundledFont { 0 = Sans, 1 = Script, 2 = Gothic }
    White { 0 = Skip, 1 = Draw }
    Arcs { 0 = Arcs, 1 = Lines }
    Dialect { 0 = Detect, 1 = Pen, 2 = Laser, 3 = Servo }
    Act { 0 = Do(deed), 1 = Give(setting, given), 2 = Omit(setting), 3 = System(line) }
    Given { 0 = On, 1 = Off, 2 = Number(number), 3 = Point(x, y), 4 = Word(word), 5 = Any(word) }
}

/// Kinds by their names: they come and go elsewhere.
macro_rules! named {
    ($($kind:ident),*) => {$(
        impl Wire for $kind {
            fn put(&self, out: &mut Vec<u8>) {
                self.name().to_owned().put(out);
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                let name = String::take(input)?;
                Self::ALL.iter().copied().find(|one| one.name() == name)
            }
        }
    )*};
}
named!(PauseCause, Format, DiagnosticCode, Deed, Setting);

/// More parameters than any command has, and what stands before it then: a step that sends nothing.
const SILENT: u8 = u8::MAX;
const PART: u8 = 0;
const PAUSE: u8 = 1;

/// An action is its command, which it is made of again to the last bit.
impl Wire for Action {
    const LEAST: usize = 2;

    fn put(&self, out: &mut Vec<u8>) {
        let command = match self {
            Self::Part(part) => {
                out.extend([PART, SILENT]);
                return part.put(out);
            }
            Self::Pause(pause) => {
                out.extend([PAUSE, SILENT]);
                return pause.put(out);
            }
            _ => self.command(),
        };
        let Some(command) = command else { return };
        let mut room = [0; MAX_PARAMS];
        let mut writer = Writer::new(&mut room);
        command.encode(&mut writer);
        let params = writer.finish().ok().and_then(|count| room.get(..count));
        let params = params.unwrap_or_default();
        out.extend([command.row().id, params.len() as u8]);
        out.extend_from_slice(params);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let (id, count) = (u8::take(input)?, u8::take(input)?);
        match (id, count) {
            (PART, SILENT) => return Wire::take(input).map(Box::new).map(Self::Part),
            (PAUSE, SILENT) => return Wire::take(input).map(Box::new).map(Self::Pause),
            _ => {}
        }
        let params = input.bytes(count.into())?;
        Set::decode(id, params).ok().map(Self::from)
    }
}

#[cfg(test)]
mod tests;
