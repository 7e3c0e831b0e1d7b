//! Step of a case, as written and as executed. The crate documentation has the grammar.

use std::time::Duration;

use magician_protocol::{
    Ctrl, Frame, FrameBuf, Layout, LayoutInfo, MAX_PARAMS, NoArgs, QueuedCmdIndex, Row, Writer,
    encode_text,
};
use magician_sim::ExternalEvent;

use crate::expect::Check;
use crate::words;

mod outside;

pub use outside::Observable;
pub(crate) use outside::Observation;
use outside::{observation, parse_event};

/// Step with its location.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// Line in the file of cases, from 1.
    pub(crate) line: usize,
    /// Text of the step.
    pub(crate) text: String,
    /// Number of repetitions.
    pub(crate) times: u32,
    pub(crate) action: Action,
}

/// Action of a step. Not boxed: steps are few, and most are requests.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
pub(crate) enum Action {
    /// Sends bytes without expectation.
    Send(Vec<u8>),
    /// Sends a frame and checks its answer.
    Ask(FrameBuf, ExpectedAnswer),
    /// Checks the answer to the last frame.
    Answered(ExpectedAnswer),
    /// Checks the next frame from the arm; `None` stands for any byte.
    Reply(Vec<Option<u8>>),
    /// Checks that the arm is silent.
    Silence,
    /// Lets time pass.
    Wait(Duration),
    /// Lets time pass until this much has elapsed since the last set or queued command.
    At(Duration),
    /// Lets time pass until the last queued command has finished; with the expected time and its
    /// tolerance.
    Done(Option<(Duration, Duration)>),
    /// Lets time pass until the arm is at rest.
    Rest,
    /// Checks which queued command has finished last.
    Finished(Finished),
    /// Checks the active alarms.
    Alarms(Alarms),
    /// Injects an external event.
    Happens(ExternalEvent),
    /// Checks the arm's tools and motors from outside.
    Sees(Vec<Observation>),
    /// Continues as another host, on its own link.
    Link(u8),
}

/// Expected answer.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExpectedAnswer {
    /// Expected fields.
    pub(crate) checks: Vec<Check>,
    /// True if the queue is expected to be full: index 0, and bit 2 of Ctrl.
    pub(crate) full: bool,
}

/// Expected last finished command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Finished {
    /// None since the case began.
    Nothing,
    /// The last queued one, or this many before it.
    Last(u64),
}

/// Expected alarms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Alarms {
    /// Exactly these.
    Are(Vec<u8>),
    /// At least these.
    With(Vec<u8>),
    /// None of these.
    Without(Vec<u8>),
}

/// Default tolerance of an expected time. A choice, not a measurement.
const DEFAULT_TIME_TOLERANCE: Duration = Duration::from_millis(2);
/// Most repetitions of a step. A choice, not a measurement.
const MAX_REPETITIONS: u32 = 10_000;

/// Parses the lines of a case; `first` is the number of the first line.
///
/// # Errors
/// The line, and the error in it.
pub(crate) fn read_all(text: &str, first: usize) -> Result<Vec<Step>, (usize, String)> {
    let mut steps = Vec::new();
    let mut sent = None;
    for (line, text) in text
        .lines()
        .enumerate()
        .map(|(at, text)| (first + at, text))
    {
        let words = words::split(text).map_err(|error| (line, error))?;
        if words.is_empty() {
            continue;
        }
        let (times, words) = repetitions(&words).map_err(|error| (line, error))?;
        let action = read(words, sent.as_ref()).map_err(|error| (line, error))?;
        // The grammar of `answered` depends on the frame before it, so it is tracked while parsing.
        if let Some(frame) = action.frame() {
            sent = Some(frame);
        }
        let text = text.trim().to_owned();
        steps.push(Step {
            line,
            text,
            times,
            action,
        });
    }
    Ok(steps)
}

/// Parses `32x` before a step.
fn repetitions(words: &[String]) -> Result<(u32, &[String]), String> {
    let Some((head, rest)) = words.split_first() else {
        return Ok((1, words));
    };
    let count = head
        .strip_suffix('x')
        .and_then(|number| number.parse().ok());
    match count {
        // Not a count, so the word is the step itself.
        None => Ok((1, words)),
        Some(count) if (1..=MAX_REPETITIONS).contains(&count) && !rest.is_empty() => {
            Ok((count, rest))
        }
        Some(_) => Err(format!(
            "'{head}' is 1x to {MAX_REPETITIONS}x and stands before a step"
        )),
    }
}

fn read(all: &[String], sent: Option<&FrameBuf>) -> Result<Action, String> {
    let (verb, rest) = all.split_first().ok_or("a step is missing")?;
    let one = || match rest {
        [word] => Ok(word.as_str()),
        _ => Err(format!("'{verb}' takes one word")),
    };
    match verb.as_str() {
        "get" => ask(Row::find_readable, Ctrl::GET, rest),
        "set" => ask(Row::find_writable, Ctrl::SET, rest),
        "queue" => ask(Row::find_writable, Ctrl::QUEUED, rest),
        "send" => words::bytes(rest).map(Action::Send),
        "frame" => frame(rest).map(|frame| Action::Send(frame.bytes().to_vec())),
        "reply" => rest
            .iter()
            .map(|word| any_byte(word))
            .collect::<Result<_, _>>()
            .map(Action::Reply),
        "answered" => answered(rest, sent).map(Action::Answered),
        "silence" if rest.is_empty() => Ok(Action::Silence),
        "wait" => words::span(rest).map(Action::Wait),
        "at" => words::span(rest).map(Action::At),
        "done" => done(rest).map(Action::Done),
        "rest" if rest.is_empty() => Ok(Action::Rest),
        "finished" => finished(one()?).map(Action::Finished),
        "alarms" => alarms(rest).map(Action::Alarms),
        "happens" => parse_event(rest).map(Action::Happens),
        "sees" => rest
            .iter()
            .map(|word| observation(word))
            .collect::<Result<_, _>>()
            .map(Action::Sees),
        "link" => words::code(one()?).map(Action::Link),
        _ => Err(format!(
            "unknown step '{}': steps are get, set, queue, send, frame, reply, answered, silence, \
                wait, at, done, rest, \
             finished, alarms, happens, sees and link",
            all.join(" ")
        )),
    }
}

/// Parses a command with its fields, and the expected answer after `->`.
fn ask(
    find: impl Fn(&str) -> Result<&'static Row, magician_protocol::NameError>,
    ctrl: Ctrl,
    rest: &[String],
) -> Result<Action, String> {
    let (name, rest) = rest.split_first().ok_or("the command is missing")?;
    let row = find(name).map_err(|_| format!("no command '{name}' for this"))?;
    let (fields, wanted) = match rest.iter().position(|word| word == "->") {
        Some(at) => (rest.get(..at).unwrap_or_default(), rest.get(at + 1..)),
        None => (rest, None),
    };
    let layout = if ctrl.write() { row.set } else { row.query };
    let params = params(layout.unwrap_or(NoArgs::INFO), fields)?;
    let frame = FrameBuf::new(row.id, ctrl, &params).map_err(|error| error.to_string())?;
    let answer = answer(reply_layout(row, ctrl), wanted.unwrap_or_default())?;
    Ok(Action::Ask(frame, answer))
}

fn params(layout: &LayoutInfo, fields: &[String]) -> Result<Vec<u8>, String> {
    let pair = |word: &'_ String| -> Result<(String, String), String> {
        let pair = word.split_once('=');
        let (key, value) =
            pair.ok_or_else(|| format!("'{word}' is not a field: write key=value"))?;
        Ok((key.to_owned(), value.to_owned()))
    };
    let pairs = fields.iter().map(pair).collect::<Result<Vec<_>, _>>()?;
    let pairs: Vec<_> = pairs
        .iter()
        .map(|(key, value)| (key.as_str(), value.as_str()))
        .collect();
    let mut bytes = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut bytes);
    encode_text(layout, &pairs, &mut writer).map_err(|error| error.to_string())?;
    let count = writer.finish().map_err(|error| error.to_string())?;
    Ok(bytes.get(..count).unwrap_or_default().to_vec())
}

fn answer(layout: &LayoutInfo, words: &[String]) -> Result<ExpectedAnswer, String> {
    let mut answer = ExpectedAnswer::default();
    for word in words {
        match word.as_str() {
            // Not a field: no layout has one of this name.
            "full" => answer.full = true,
            word => answer.checks.push(Check::read(layout, word)?),
        }
    }
    Ok(answer)
}

/// Parses a frame with a correct checksum: command, Ctrl and parameters in hex.
fn frame(words: &[String]) -> Result<FrameBuf, String> {
    let [name, ctrl, params @ ..] = words else {
        return Err("write frame COMMAND CTRL BYTES".to_owned());
    };
    // The command may be given by number, for ids that no command has.
    let id = match name.parse::<u8>() {
        Ok(id) => id,
        Err(_) => {
            Row::find(name)
                .map_err(|_| format!("no command '{name}'"))?
                .id
        }
    };
    let (ctrl, params) = (Ctrl(words::byte(ctrl)?), words::bytes(params)?);
    FrameBuf::new(id, ctrl, &params).map_err(|error| error.to_string())
}

fn any_byte(word: &str) -> Result<Option<u8>, String> {
    match word {
        ".." => Ok(None),
        word => words::byte(word).map(Some),
    }
}

fn answered(rest: &[String], sent: Option<&FrameBuf>) -> Result<ExpectedAnswer, String> {
    let frame = sent
        .ok_or("nothing was sent that could be answered")?
        .frame();
    let row = Row::with_id(frame.id()).ok_or("the frame sent last has no command")?;
    let words = match rest {
        [] => rest,
        [arrow, words @ ..] if arrow == "->" => words,
        _ => return Err("write answered -> field=value".to_owned()),
    };
    answer(reply_layout(row, frame.ctrl()), words)
}

/// Returns the layout of the answer to a request.
pub(crate) fn reply_layout(row: &Row, ctrl: Ctrl) -> &'static LayoutInfo {
    match (row.sets(ctrl), ctrl.queued() && !row.steers_queue()) {
        (true, true) => QueuedCmdIndex::INFO,
        (true, false) => NoArgs::INFO,
        (false, _) => row.value.unwrap_or(NoArgs::INFO),
    }
}

/// Parses nothing, `after 2 s`, or `after 2 s +- 10 ms`.
fn done(words: &[String]) -> Result<Option<(Duration, Duration)>, String> {
    match words {
        [] => Ok(None),
        [after, number, unit, rest @ ..] if after == "after" => {
            let at = words::span(&[number.clone(), unit.clone()])?;
            match rest {
                [] => Ok(Some((at, DEFAULT_TIME_TOLERANCE))),
                [sign, tolerance @ ..] if sign == "+-" => Ok(Some((at, words::span(tolerance)?))),
                _ => Err("write done after 2 s +- 10 ms".to_owned()),
            }
        }
        _ => Err("write done, or done after 2 s".to_owned()),
    }
}

fn finished(word: &str) -> Result<Finished, String> {
    match word {
        "nothing" => return Ok(Finished::Nothing),
        "last" => return Ok(Finished::Last(0)),
        _ => {}
    }
    let before = word
        .strip_prefix("last-")
        .and_then(|number| number.parse().ok());
    before
        .map(Finished::Last)
        .ok_or_else(|| "write finished last, finished last-1 or finished nothing".to_owned())
}

fn alarms(words: &[String]) -> Result<Alarms, String> {
    let codes = |words: &[String]| {
        words
            .iter()
            .map(|word| words::code(word))
            .collect::<Result<Vec<_>, _>>()
    };
    match words {
        [] => Err(
            "write alarms none, alarms 0x11, alarms with 0x11 or alarms without 0x11".to_owned(),
        ),
        // No alarms are written as `none`, because an empty list would look like an omission.
        [none] if none == "none" => Ok(Alarms::Are(Vec::new())),
        [with, rest @ ..] if with == "with" => codes(rest).map(Alarms::With),
        [without, rest @ ..] if without == "without" => codes(rest).map(Alarms::Without),
        words => codes(words).map(Alarms::Are),
    }
}

impl Action {
    /// Returns the frame that it sends, if it sends a complete one.
    pub(crate) fn frame(&self) -> Option<FrameBuf> {
        match self {
            Self::Ask(frame, _) => Some(*frame),
            Self::Send(bytes) => Frame::new(bytes).map(FrameBuf::from),
            // All other steps send nothing.
            _ => None,
        }
    }

    /// Returns the bytes that it sends.
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Ask(frame, _) => frame.bytes(),
            Self::Send(bytes) => bytes,
            // All other steps send nothing.
            _ => &[],
        }
    }
}
