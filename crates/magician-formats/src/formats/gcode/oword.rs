//! O-words: lines that change the flow of a program, and which of them belong together.
//!
//! All O-words are found and matched before the program runs. Each stores the index of its partner
//! ([`Oword::other`]), so jumps need no search at run time.

use std::collections::HashMap;

use magician_host::{Message, message};

use super::lexer::Words;
use super::parameters::Parameters;
use super::{SourceLine, behind_number};
use crate::Diagnostic;
use crate::formats::span::SpanDiagnostic;

/// Largest number of O-words. It bounds memory for generated programs.
const MAX_O_WORDS: usize = 100_000;
/// Largest nesting depth. A choice above any program written by hand.
const MAX_DEPTH: usize = 200;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keyword {
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    /// The `while` that ends a `do`.
    DoWhile,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

use Keyword::{
    Break, Call, Continue, Do, DoWhile, Else, ElseIf, EndIf, EndRepeat, EndSub, EndWhile, If,
    Repeat, Return, Sub, While,
};

const KEYWORDS: [(&str, Keyword); 15] = [
    ("sub", Sub),
    ("endsub", EndSub),
    ("return", Return),
    ("call", Call),
    ("if", If),
    ("elseif", ElseIf),
    ("else", Else),
    ("endif", EndIf),
    ("while", While),
    ("endwhile", EndWhile),
    ("do", Do),
    ("repeat", Repeat),
    ("endrepeat", EndRepeat),
    ("break", Break),
    ("continue", Continue),
];

impl Keyword {
    fn name(self) -> &'static str {
        let own = if self == DoWhile { While } else { self };
        let mut names = KEYWORDS.iter();
        names
            .find(|(_, keyword)| *keyword == own)
            .map_or("", |(name, _)| name)
    }

    fn opens(self) -> bool {
        matches!(self, Sub | If | While | Do | Repeat)
    }

    fn is_loop(self) -> bool {
        matches!(self, While | Do | Repeat)
    }

    /// True if this keyword may end or divide a block begun by `begun`.
    fn follows(self, begun: Self) -> bool {
        match self {
            EndSub => begun == Sub,
            ElseIf | Else | EndIf => matches!(begun, If | ElseIf) || self == EndIf && begun == Else,
            EndWhile => begun == While,
            DoWhile => begun == Do,
            EndRepeat => begun == Repeat,
            _ => false,
        }
    }
}

/// Label after the O: a number or a name.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Label {
    Number(u32),
    Name(Box<str>),
    /// Computed when the line is reached.
    Computed,
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "o{number}"),
            Self::Name(name) => write!(f, "o<{name}>"),
            Self::Computed => f.write_str("o[..]"),
        }
    }
}

/// Position in the text: byte offset and line number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct TextPosition {
    pub(super) at: usize,
    pub(super) number: u32,
    /// Index of the first O-word at or after it.
    pub(super) oword: usize,
}

/// An O-word.
#[derive(Clone, Debug)]
pub(super) struct Oword {
    pub(super) keyword: Keyword,
    pub(super) label: Label,
    pub(super) place: TextPosition,
    /// Offset in the line at which its values begin.
    pub(super) rest: usize,
    /// Partner in the same block. A keyword that opens or divides the block points to the next one,
    /// all others to the first.
    pub(super) other: usize,
}

/// All O-words of a program, and its numbered programs (`O100` to M99).
#[derive(Debug, Default)]
pub(super) struct Owords {
    pub(super) all: Vec<Oword>,
    subs: HashMap<Label, usize>,
    pub(super) numbered: HashMap<u32, TextPosition>,
}

/// Returns the line at a position, and the offset of the next one.
pub(super) fn line_at(text: &str, place: TextPosition) -> Option<(SourceLine<'_>, usize)> {
    let rest = text.get(place.at..).filter(|rest| !rest.is_empty())?;
    let (line, next) = match rest.find('\n') {
        Some(end) => (rest.get(..end)?, place.at + end + 1),
        None => (rest, text.len()),
    };
    let text = line.strip_suffix('\r').unwrap_or(line);
    let number = place.number;
    Some((SourceLine { number, text }, next))
}

impl Owords {
    pub(super) fn of(text: &str) -> Result<Self, Diagnostic> {
        let mut found = Self::default();
        let mut open: Vec<usize> = Vec::new();
        let mut place = TextPosition {
            number: 1,
            ..TextPosition::default()
        };
        while let Some((line, next)) = line_at(text, place) {
            place.oword = found.all.len();
            found
                .take(&line, place, &mut open)
                .map_err(|error| line.diagnostic(error))?;
            (place.at, place.number) = (next, place.number.saturating_add(1));
        }
        if let Some(first) = open.last().and_then(|first| found.all.get(*first))
            && let Some((line, _)) = line_at(text, first.place)
        {
            let message = message!(
                "{label} {name} is not ended",
                label = first.label.to_string(),
                name = first.keyword.name()
            );
            return Err(
                line.diagnostic(SpanDiagnostic::new(0..line.text.trim_end().len(), message))
            );
        }
        Ok(found)
    }

    /// Returns the index of a subroutine.
    pub(super) fn sub(&self, label: &Label) -> Option<usize> {
        self.subs.get(label).copied()
    }

    fn take(
        &mut self,
        line: &SourceLine<'_>,
        place: TextPosition,
        open: &mut Vec<usize>,
    ) -> Result<(), SpanDiagnostic> {
        let Some(head) = head(line.text)? else {
            return Ok(());
        };
        let Some((word, mut keyword)) = head.keyword else {
            if let (Label::Number(number), true) = (&head.label, head.is_alone) {
                self.numbered.entry(*number).or_insert(place);
            }
            return Ok(());
        };
        let error = |message: Message| SpanDiagnostic::new(word.clone(), message);
        let own = self.all.len();
        if own == MAX_O_WORDS {
            return Err(error(message!(
                "the program has more than {most} O-words",
                most = MAX_O_WORDS
            )));
        }
        if head.label == Label::Computed && keyword != Call {
            return Err(error(message!(
                "the number of {name} is computed, which only call allows",
                name = keyword.name()
            )));
        }
        let top = open.last().copied();
        let is_own = |at: &usize| self.all.get(*at).is_some_and(|one| one.label == head.label);
        let begun = top.filter(is_own);
        let begun_as = begun.and_then(|at| self.all.get(at)).map(|one| one.keyword);
        if keyword == While && begun_as == Some(Do) {
            keyword = DoWhile;
        }
        let mut other = own;
        if keyword.opens() {
            if open.len() == MAX_DEPTH {
                return Err(error(message!(
                    "O-words are nested {most} deep",
                    most = MAX_DEPTH
                )));
            }
            if keyword == Sub {
                let inside = open.iter().any(|at| self.all[*at].keyword == Sub);
                if inside {
                    return Err(error(message!("a subroutine begins within another one")));
                }
                if self.subs.insert(head.label.clone(), own).is_some() {
                    let label = head.label.to_string();
                    return Err(error(message!("there are two subroutines {label}", label)));
                }
            }
            open.push(own);
        } else if matches!(keyword, Break | Continue) {
            let mut loops = open.iter().rev().filter(|at| is_own(at));
            let found = loops.find(|at| self.all[**at].keyword.is_loop());
            let Some(found) = found else {
                let (name, label) = (keyword.name(), head.label.to_string());
                return Err(error(message!(
                    "{name} is not in a loop {label}",
                    name,
                    label
                )));
            };
            other = *found;
        } else if !matches!(keyword, Return | Call) {
            let matching = begun.filter(|_| begun_as.is_some_and(|begun| keyword.follows(begun)));
            let Some(begun) = matching else {
                let what = match top.and_then(|at| self.all.get(at)) {
                    Some(top) => message!(
                        "{label} {name} of line {line} is open here",
                        label = top.label.to_string(),
                        name = top.keyword.name(),
                        line = top.place.number
                    ),
                    None => message!("nothing is open here"),
                };
                let (name, label) = (keyword.name(), head.label.to_string());
                return Err(error(message!(
                    "{label} {name} does not match: {what}",
                    label,
                    name,
                    what
                )));
            };
            open.pop();
            self.all[begun].other = own;
            other = begun;
            if matches!(keyword, ElseIf | Else) {
                open.push(own);
            }
        }
        self.all.push(Oword {
            keyword,
            label: head.label,
            place,
            rest: head.rest,
            other,
        });
        Ok(())
    }
}

struct Head {
    label: Label,
    keyword: Option<(std::ops::Range<usize>, Keyword)>,
    rest: usize,
    /// True if the line contains nothing else.
    is_alone: bool,
}

/// Parses the O-word at the start of a line, after its number.
fn head(text: &str) -> Result<Option<Head>, SpanDiagnostic> {
    let start = behind_number(text);
    if !matches!(text.as_bytes().get(start), Some(b'o' | b'O')) {
        return Ok(None);
    }
    let none = Parameters::none();
    let mut words = Words::new(text, &none);
    words.at = start;
    words.at += 1;
    words.skip_blanks();
    let label = match words.peek() {
        Some(b'<') => Label::Name(words.name()?),
        Some(b'[' | b'#') => {
            // The label is evaluated when the line is executed.
            return Ok(computed(text, start));
        }
        Some(byte) if byte.is_ascii_digit() => match words.number() {
            Some(number) if number.fract() == 0.0 && number <= f64::from(u32::MAX) => {
                Label::Number(number as u32)
            }
            _ => return Ok(None),
        },
        _ => return Ok(None),
    };
    words.skip_blanks();
    let begin = words.at;
    words.pass(|byte| byte.is_ascii_alphabetic());
    let name = text.get(begin..words.at).unwrap_or_default();
    let mut keywords = KEYWORDS.into_iter();
    let keyword = keywords.find(|(known, _)| known.eq_ignore_ascii_case(name));
    let keyword = keyword.map(|(_, keyword)| (start..words.at, keyword));
    let rest = words.at;
    words.at = begin;
    let is_alone = words.begin().is_none();
    Ok(Some(Head {
        label,
        keyword,
        rest,
        is_alone,
    }))
}

/// Parses a call with a computed label: `o[#1+2] call`, `o#1 call`.
fn computed(text: &str, start: usize) -> Option<Head> {
    let lower = text.to_ascii_lowercase();
    let at = lower.get(start..)?.find("call")? + start;
    Some(Head {
        label: Label::Computed,
        keyword: Some((start..at + 4, Call)),
        rest: at + 4,
        is_alone: false,
    })
}
