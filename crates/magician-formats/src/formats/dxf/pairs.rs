//! The syntax of DXF: pairs of a group code and a value, each on its own line, grouped into
//! records.

use magician_host::message;

use crate::encoding::number;
use crate::{Diagnostic, Origin};

/// A value with its group code.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'t> {
    pub(super) code: i32,
    pub(super) value: &'t str,
    /// The value with surrounding blanks, which are significant in texts.
    pub(super) verbatim: &'t str,
    pub(super) origin: Origin,
}

/// Parses the pairs of a text up to `EOF`.
pub(super) fn pairs(text: &str) -> Result<Vec<Pair<'_>>, Diagnostic> {
    let mut pairs = Vec::new();
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let mut lines = (1_u32..).zip(text.lines());
    while let Some((line, code)) = lines.next() {
        let at = origin(line, code);
        let Ok(number) = code.trim().parse() else {
            if code.trim().is_empty() && pairs.last().is_some_and(is_end) {
                break;
            }
            let what = shortened(code.trim());
            return Err(Diagnostic::new(
                at,
                message!("expected a group code, found \"{what}\"", what),
            ));
        };
        let Some((line, value)) = lines.next() else {
            return Err(Diagnostic::new(
                at,
                message!("the file ends after a group code"),
            ));
        };
        pairs.push(Pair {
            code: number,
            value: value.trim(),
            verbatim: value,
            origin: origin(line, value),
        });
        if pairs.last().is_some_and(is_end) {
            break;
        }
    }
    Ok(pairs)
}

fn is_end(pair: &Pair<'_>) -> bool {
    (pair.code, pair.value) == (0, "EOF")
}

fn origin(line: u32, text: &str) -> Origin {
    let count = |text: &str| u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
    let before = text.len() - text.trim_start().len();
    Origin {
        line,
        column: count(text.get(..before).unwrap_or_default()).saturating_add(1),
        length: count(text.trim()),
        name: 0,
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(20).collect()
}

impl Pair<'_> {
    pub(super) fn number(&self) -> Result<f64, Diagnostic> {
        number(self.value).ok_or_else(|| {
            let what = shortened(self.value);
            Diagnostic::new(
                self.origin,
                message!("expected a number, found \"{what}\"", what),
            )
        })
    }

    pub(super) fn integer(&self) -> Result<i64, Diagnostic> {
        self.value.parse().map_err(|_| {
            let what = shortened(self.value);
            Diagnostic::new(
                self.origin,
                message!("expected a whole number, found \"{what}\"", what),
            )
        })
    }
}

/// A record: a pair of code 0, which gives its kind, and all pairs up to the next one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<'p> {
    pub(super) kind: &'p str,
    pub(super) origin: Origin,
    pub(super) pairs: &'p [Pair<'p>],
}

pub(super) fn records<'p>(pairs: &'p [Pair<'p>]) -> Vec<Record<'p>> {
    let groups = pairs.chunk_by(|_, next| next.code != 0);
    let records = groups.filter_map(|group| match group {
        [head, pairs @ ..] if head.code == 0 => Some(Record {
            kind: head.value,
            origin: head.origin,
            pairs,
        }),
        _ => None,
    });
    records.collect()
}

impl<'p> Record<'p> {
    /// Returns the first value with this code.
    pub(super) fn text(&self, code: i32) -> Option<&'p str> {
        self.first(code).map(|pair| pair.value)
    }

    /// Returns the first value with this code, including surrounding blanks.
    pub(super) fn verbatim(&self, code: i32) -> Option<&'p str> {
        self.first(code).map(|pair| pair.verbatim)
    }

    /// Returns the part before the first value with this code.
    pub(super) fn until(&self, code: i32) -> Self {
        let end = self.pairs.iter().position(|pair| pair.code == code);
        let pairs = end.and_then(|end| self.pairs.get(..end));
        Self {
            pairs: pairs.unwrap_or(self.pairs),
            ..*self
        }
    }

    /// Returns the part before the data of a subclass (code 100).
    pub(super) fn until_class(&self, name: &str) -> Self {
        let begins = |pair: &Pair<'_>| pair.code == 100 && pair.value == name;
        let end = self.pairs.iter().position(begins);
        let pairs = end.and_then(|end| self.pairs.get(..end));
        Self {
            pairs: pairs.unwrap_or(self.pairs),
            ..*self
        }
    }

    pub(super) fn number(&self, code: i32) -> Result<Option<f64>, Diagnostic> {
        self.first(code).map(Pair::number).transpose()
    }

    /// Returns a mandatory number.
    pub(super) fn needed(&self, code: i32) -> Result<f64, Diagnostic> {
        self.number(code)?.ok_or_else(|| {
            let why = message!(
                "{kind} has no value for group code {code}",
                kind = self.kind,
                code
            );
            Diagnostic::new(self.origin, why)
        })
    }

    /// Returns the first whole number with this code, or 0 if there is none.
    pub(super) fn integer(&self, code: i32) -> Result<i64, Diagnostic> {
        self.first(code).map_or(Ok(0), Pair::integer)
    }

    /// Returns all numbers with this code.
    pub(super) fn numbers(&self, code: i32) -> Result<Vec<f64>, Diagnostic> {
        let pairs = self.pairs.iter().filter(|pair| pair.code == code);
        pairs.map(Pair::number).collect()
    }

    /// Returns the point whose x has this code. y and z have that code plus 10 and 20, and default
    /// to 0.
    pub(super) fn point(&self, code: i32) -> Result<[f64; 3], Diagnostic> {
        let x = self.needed(code)?;
        let [y, z] = [10, 20].map(|offset| self.number(code + offset));
        Ok([x, y?.unwrap_or(0.0), z?.unwrap_or(0.0)])
    }

    /// Returns all points whose x has this code, each with the value of the code `extra_code`
    /// that follows it.
    pub(super) fn points(
        &self,
        code: i32,
        extra_code: i32,
    ) -> Result<Vec<([f64; 3], f64)>, Diagnostic> {
        let mut points: Vec<([f64; 3], f64)> = Vec::new();
        for pair in self.pairs {
            if pair.code == code {
                points.push(([pair.number()?, 0.0, 0.0], 0.0));
            } else if let Some((point, extra)) = points.last_mut() {
                match pair.code - code {
                    10 => point[1] = pair.number()?,
                    20 => point[2] = pair.number()?,
                    _ if pair.code == extra_code => *extra = pair.number()?,
                    _ => {}
                }
            }
        }
        Ok(points)
    }

    fn first(&self, code: i32) -> Option<&'p Pair<'p>> {
        self.pairs.iter().find(|pair| pair.code == code)
    }
}
