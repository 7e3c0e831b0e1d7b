//! Serialisation of a request to prepare a file, and of its result, for another WebAssembly module
//! that does the work.
//!
//! Both modules come from one build; the format is private to it. It begins with [`FORMAT_ID`],
//! which changes with these files and the version: data of another build is refused, never misread.
//! No input panics, and none takes more memory than a small multiple of its length.
#![allow(clippy::cast_possible_truncation)] // Lengths are below 2^32 on what this runs on, and are read back by their u64.

mod codec;

use std::fmt;

use magician_host::{
    Act, Action as Deed, JointAngles, Message, MessageValue, PinUse, Remedy, Setting, SettingValue,
};
use magician_motion::{Cuboid, Fence};
use magician_protocol::{MAX_PARAMS, Set, Writer};

use crate::artwork::Sheet;
use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{
    Action, AppliedPlacement, Color, Diagnostic, DiagnosticCode, Format, Missing, Origin, Part,
    PartSummary, Pause, PauseCause, Plan, Power, Preparation, PrepareError, PrepareRequest,
    PrepareStage, PreparedProgram, Program, SetupDefaults, SetupOptions, Side, StartPosition, Step,
    Surface, Tool, WorkOption, WouldFit,
};
use codec::{Input, Wire};

/// Result of preparing a file.
pub type FileAnswer = Result<Preparation, PrepareError>;

/// Error: bytes other than a request or result of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WireError {
    /// Error: bytes of another build.
    OtherBuild,
    /// Error: truncated or damaged bytes.
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

/// Identifier of the format: FNV-1a of this file, of the codec, and of the version.
pub const FORMAT_ID: [u8; 8] = format_id().to_le_bytes();

const fn format_id() -> u64 {
    // Offset basis of 64-bit FNV-1a; computed at compile time.
    let mut hash = 0xCBF2_9CE4_8422_2325;
    let mut part = 0;
    let parts: [&[u8]; 3] = [
        include_bytes!("wire.rs"),
        include_bytes!("wire/codec.rs"),
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

impl PrepareRequest {
    /// Serialises the request.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self {
            format,
            title,
            bytes,
            options,
            surface_slope,
            preset_note,
            rest,
            defaults,
            fence,
            tool,
            start,
        } = self;
        // Room for the file and typical options, to avoid copying a large file.
        let mut out = Vec::with_capacity(bytes.len() + 1024);
        out.extend(FORMAT_ID);
        format.put(&mut out);
        title.put(&mut out);
        options.put(&mut out);
        surface_slope.put(&mut out);
        preset_note.put(&mut out);
        rest.put(&mut out);
        defaults.put(&mut out);
        fence.put(&mut out);
        tool.put(&mut out);
        start.put(&mut out);
        // The file comes last and without a length: it is the rest of the message.
        out.extend_from_slice(bytes);
        out
    }

    fn from_bytes(bytes: &[u8]) -> Result<Self, WireError> {
        let mut input = Input(bytes);
        input.format_id()?;
        Self::take(&mut input).ok_or(WireError::Malformed)
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        Some(Self {
            format: Wire::take(input)?,
            title: Wire::take(input)?,
            options: Wire::take(input)?,
            surface_slope: Wire::take(input)?,
            preset_note: Wire::take(input)?,
            rest: Wire::take(input)?,
            defaults: Wire::take(input)?,
            fence: Wire::take(input)?,
            tool: Wire::take(input)?,
            start: Wire::take(input)?,
            bytes: input.0.into(),
        })
    }
}

/// Prepares the file of a request and serialises the result. For bytes that are no request of this
/// build it returns only the format's identifier, so that the other side detects the mismatch.
#[must_use]
pub fn answer(request: &[u8]) -> Vec<u8> {
    match PrepareRequest::from_bytes(request) {
        Ok(request) => answer_bytes(&request.prepare()),
        Err(_) => FORMAT_ID.to_vec(),
    }
}

/// Serialises the result of preparing a file.
#[must_use]
pub fn answer_bytes(answer: &FileAnswer) -> Vec<u8> {
    let mut out = FORMAT_ID.to_vec();
    match answer {
        Ok(Preparation::Done(prepared)) => {
            out.push(0);
            ProgramHead::of(prepared).put(&mut out);
            // Steps come last, so that they can be read in slices.
            prepared.program.plan.steps.put(&mut out);
        }
        Ok(Preparation::NeedsStart) => out.push(1),
        Err(error) => {
            out.push(2);
            error.put(&mut out);
        }
    }
    out
}

/// Deserialises the result for a request. The request need not hold its file any more.
///
/// # Errors
/// [`WireError`] if the bytes are not a result of this build.
pub fn answer_from(request: &PrepareRequest, bytes: &[u8]) -> Result<FileAnswer, WireError> {
    run_to_end(answer_yielding(request, bytes, &NeverYield))
}

/// Like [`answer_from`], yielding to other tasks between slices.
///
/// # Errors
/// Same as [`answer_from`].
pub async fn answer_yielding(
    request: &PrepareRequest,
    bytes: &[u8],
    yields: &impl Yield,
) -> Result<FileAnswer, WireError> {
    let mut input = Input(bytes);
    input.format_id()?;
    let answer = match u8::take(&mut input) {
        Some(0) => prepared(request, &mut input, yields).await.map(Ok),
        Some(1) => Some(Ok(Preparation::NeedsStart)),
        Some(2) => PrepareError::take(&mut input).map(Err),
        _ => None,
    };
    // Trailing bytes mean a different format that happened to decode.
    { answer.filter(|_| input.0.is_empty()) }.ok_or(WireError::Malformed)
}

async fn prepared(
    request: &PrepareRequest,
    input: &mut Input<'_>,
    yields: &impl Yield,
) -> Option<Preparation> {
    let head = ProgramHead::take(input)?;
    let mut left = input.count::<Step>()?;
    // Safe to allocate: `count` has checked that the input can hold this many.
    let mut steps = Vec::with_capacity(left);
    while left > 0 {
        for _ in 0..left.min(STEPS_PER_SLICE) {
            steps.push(Step::take(input)?);
            left -= 1;
        }
        yields.yield_now().await;
    }
    Some(Preparation::Done(Box::new(head.with(request, steps))))
}

/// Prepared program without its steps, and without what the request contains.
struct ProgramHead {
    title: String,
    tool: Option<Tool>,
    surface: Option<Surface>,
    names: Vec<String>,
    settings: Vec<Set>,
    iterations: Option<u64>,
    pen_stays_down: bool,
    leading: u64,
    start: Option<[f64; 3]>,
    staged_joints: Option<[f64; 4]>,
    notes: Vec<Diagnostic>,
    placed: Option<AppliedPlacement>,
    misfit: Option<Diagnostic>,
    would_fit: Option<WouldFit>,
    parts: Vec<PartSummary>,
}

impl ProgramHead {
    fn of(prepared: &PreparedProgram) -> Self {
        let PreparedProgram {
            program,
            format: _,
            setup: _,
            ending: _,
            start,
            staged_joints,
            notes,
            placed,
            misfit,
            would_fit,
            parts,
        } = prepared;
        let Program {
            plan,
            settings,
            iterations,
            pen_stays_down,
            leading,
            ..
        } = program;
        let Plan {
            title,
            tool,
            surface,
            names,
            steps: _,
            curves: _,
        } = &**plan;
        Self {
            title: title.clone(),
            tool: *tool,
            surface: *surface,
            names: names.clone(),
            settings: settings.clone(),
            iterations: *iterations,
            pen_stays_down: *pen_stays_down,
            leading: *leading,
            start: *start,
            staged_joints: staged_joints.map(JointAngles::to_array),
            notes: notes.clone(),
            placed: *placed,
            misfit: misfit.clone(),
            would_fit: *would_fit,
            parts: parts.clone(),
        }
    }

    fn with(self, request: &PrepareRequest, steps: Vec<Step>) -> PreparedProgram {
        let (setup, ending) = request.setup_and_ending();
        let plan = Plan {
            title: self.title,
            tool: self.tool,
            surface: self.surface,
            steps,
            names: self.names,
            ..Plan::default()
        };
        PreparedProgram {
            program: Program {
                pen_stays_down: self.pen_stays_down,
                leading: self.leading,
                ..Program::new(plan, self.iterations).with_settings(self.settings)
            },
            format: request.format,
            setup,
            ending,
            start: self.start,
            staged_joints: self.staged_joints.map(JointAngles::from),
            notes: self.notes,
            placed: self.placed,
            misfit: self.misfit,
            would_fit: self.would_fit,
            parts: self.parts,
        }
    }
}

impl Input<'_> {
    fn format_id(&mut self) -> Result<(), WireError> {
        match self.bytes(FORMAT_ID.len()) {
            Some(form) if form == FORMAT_ID => Ok(()),
            Some(_) => Err(WireError::OtherBuild),
            None => Err(WireError::Malformed),
        }
    }
}

/// Serialises all fields in this order. A forgotten field does not compile.
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
    Step { action, origin, feed, follows_speed, color }
    Part { n, name, color, pass }
    Pause { text, cause }
    ProgramHead {
        title, tool, surface, names, settings, iterations, pen_stays_down, leading, start, staged_joints, notes, placed, misfit, would_fit, parts,
    }
    PrepareError { stage, problem, notes }
    PartSummary { n, name, color, strokes, drawn_mm, seconds, skipped }
    Diagnostic { origin, name, code, message, help, remedies, missing }
    Remedy { act, effect }
    AppliedPlacement { scale, turn, at, page, beside }
    WouldFit { scale, rotate }
    Sheet { corner, rotation, surface, size }
    Cuboid { min, max }
    SetupDefaults {
        tool, sheet, surface, assumed_surface, draw_speed, draw_travel_speed, draw_lift, engrave_speed, engrave_power, park,
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

impl Wire for Power {
    fn put(&self, out: &mut Vec<u8>) {
        self.range().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let [least, most] = Wire::take(input)?;
        Self::new(least, most).ok()
    }
}

impl Wire for Fence {
    fn put(&self, out: &mut Vec<u8>) {
        self.floor().put(out);
        self.within().put(out);
        self.keep_outs().to_vec().put(out);
        self.top_speed().put(out);
        self.strongest_laser().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let mut fence = Self::default();
        if let Some(floor) = Wire::take(input)? {
            fence = fence.with_floor(floor).ok()?;
        }
        if let Some(within) = Wire::take(input)? {
            fence = fence.with_box(within).ok()?;
        }
        for keep_out in Vec::take(input)? {
            fence = fence.with_keep_out(keep_out).ok()?;
        }
        if let Some(speed) = Wire::take(input)? {
            fence = fence.with_top_speed(speed).ok()?;
        }
        if let Some(percent) = Wire::take(input)? {
            fence = fence.with_strongest_laser(percent).ok()?;
        }
        Some(fence)
    }
}

/// Largest nesting of messages that keep their templates. Deeper input is refused, so that no input
/// exhausts the stack.
const MAX_MESSAGE_DEPTH: usize = 8;

impl Wire for Message {
    fn put(&self, out: &mut Vec<u8>) {
        put_message(self, MAX_MESSAGE_DEPTH, out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        take_message(MAX_MESSAGE_DEPTH, input)
    }
}

fn put_message(message: &Message, depth: usize, out: &mut Vec<u8>) {
    message.as_str().to_owned().put(out);
    message.template().unwrap_or_default().into_owned().put(out);
    message.values().len().put(out);
    for (name, value) in message.values() {
        name.put(out);
        match value {
            MessageValue::Message(message) if depth > 0 => {
                out.push(1);
                put_message(message, depth - 1, out);
            }
            MessageValue::Option(name) => {
                out.push(2);
                name.put(out);
            }
            text => {
                out.push(0);
                text.to_string().put(out);
            }
        }
    }
}

fn take_message(depth: usize, input: &mut Input<'_>) -> Option<Message> {
    let (text, template) = (String::take(input)?, String::take(input)?);
    let mut values = Vec::new();
    for _ in 0..input.count::<u8>()? {
        let name = Wire::take(input)?;
        let value = match u8::take(input)? {
            0 => MessageValue::Text(Wire::take(input)?),
            1 => MessageValue::Message(take_message(depth.checked_sub(1)?, input)?),
            2 => MessageValue::Option(Wire::take(input)?),
            _ => return None,
        };
        values.push((name, value));
    }
    Some(Message::from_parts(text, template, values))
}

/// Encoded as JSON, except [`WorkOption::ByFile`], which is separate. A font from a file has no
/// JSON form, and no client can name one.
impl Wire for SetupOptions {
    fn put(&self, out: &mut Vec<u8>) {
        let by_file = self.work == Some(WorkOption::ByFile);
        by_file.put(out);
        let mut options = self.clone();
        options.work = options.work.filter(|_| !by_file);
        serde_json::to_string(&options).unwrap_or_default().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let by_file = bool::take(input)?;
        let mut options: Self = serde_json::from_str(&String::take(input)?).ok()?;
        if by_file {
            options.work = Some(WorkOption::ByFile);
        }
        Some(options)
    }
}

/// Serialises variants as a byte.
macro_rules! kinds {
    ($($kind:ident { $($number:literal = $variant:ident $(($($part:ident),*))?),* $(,)? })*) => {$(
        impl Wire for $kind {
            fn put(&self, out: &mut Vec<u8>) {
                match self {
                    $(Self::$variant $(($($part),*))? => {
                        out.push($number);
                        $($($part.put(out);)*)?
                    })*
                    // All variants are known within this workspace.
                    #[cfg(not(magician_workspace))]
                    #[allow(unreachable_patterns)]
                    _ => unreachable!(),
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
    Tool { 0 = None, 1 = Suction, 2 = Gripper, 3 = Pen, 4 = Laser, 5 = Bias(bias) }
    Missing { 0 = Start, 1 = Feature(feature) }
    StartPosition { 0 = Unread, 1 = At(at), 2 = Unknown, 3 = Staged }
    PrepareStage { 0 = Read, 1 = Place }
    Side { 0 = Left, 1 = Right }
    Act { 0 = Do(deed), 1 = Give(setting, given), 2 = Omit(setting), 3 = System(line), 4 = SetPin(pin, function), 5 = UseStation(url) }
    PinUse { 0 = DigitalOutput, 1 = Pwm }
    SettingValue { 0 = On, 1 = Off, 2 = Number(number), 3 = Point(x, y), 4 = Word(word), 5 = Any(word), 6 = Position(at) }
}

/// Serialises variants by name: they change in other crates.
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

/// Marker of a step that sends nothing, in place of the parameter count: more than any command has.
const NO_COMMAND: u8 = u8::MAX;
const PART_TAG: u8 = 0;
const PAUSE_TAG: u8 = 1;

impl Wire for Set {
    const MIN_SIZE: usize = 2;

    fn put(&self, out: &mut Vec<u8>) {
        let mut room = [0; MAX_PARAMS];
        let mut writer = Writer::new(&mut room);
        self.encode(&mut writer);
        let params = writer.finish().ok().and_then(|count| room.get(..count));
        let params = params.unwrap_or_default();
        out.extend([self.row().id, params.len() as u8]);
        out.extend_from_slice(params);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let (id, count) = (u8::take(input)?, u8::take(input)?);
        Self::decode(id, input.bytes(count.into())?).ok()
    }
}

/// An action is stored as its command, which restores it exactly. Actions without a command have a
/// marker.
impl Wire for Action {
    const MIN_SIZE: usize = Set::MIN_SIZE;

    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Part(part) => {
                out.extend([PART_TAG, NO_COMMAND]);
                part.put(out);
            }
            Self::Pause(pause) => {
                out.extend([PAUSE_TAG, NO_COMMAND]);
                pause.put(out);
            }
            _ => {
                if let Some(command) = self.command() {
                    command.put(out);
                }
            }
        }
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        match *input.0 {
            [PART_TAG, NO_COMMAND, ref rest @ ..] => {
                input.0 = rest;
                Wire::take(input).map(Box::new).map(Self::Part)
            }
            [PAUSE_TAG, NO_COMMAND, ref rest @ ..] => {
                input.0 = rest;
                Wire::take(input).map(Box::new).map(Self::Pause)
            }
            _ => Set::take(input).map(Self::from),
        }
    }
}

#[cfg(test)]
mod tests;
