//! Strokes as lists of lines.

use super::message::{Color, Line, Xyz};

/// Means of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::mcap) enum Ink {
    Pen,
    Laser,
}

impl Ink {
    const ALL: [Self; 2] = [Self::Pen, Self::Laser];

    fn color(self) -> Color {
        match self {
            Self::Pen => Color::hex("#1a4fa3"),
            Self::Laser => Color::hex("#5b3216"),
        }
    }
}

/// Lines of pen and laser.
#[derive(Default)]
pub(super) struct Strokes {
    all: [Lines; 2],
    new: [Lines; 2],
    /// True if there are too many to be written again.
    many: bool,
}

#[derive(Clone, Default)]
struct Lines {
    points: Vec<Xyz>,
    /// Pairs of indices into `points`.
    ends: Vec<u32>,
}

impl Lines {
    fn add(&mut self, from: Xyz, to: Xyz) {
        // Lines that continue each other share a point.
        if self.points.last() != Some(&from) {
            self.points.push(from);
        }
        let last = self.points.len() as u32;
        self.points.push(to);
        self.ends.extend([last - 1, last]);
    }
}

impl Strokes {
    pub(super) fn add(&mut self, ink: Ink, from: [f64; 3], to: [f64; 3], most: usize) {
        let (from, to) = (Xyz::millimetres(from), Xyz::millimetres(to));
        self.new[ink as usize].add(from, to);
        self.many |= self.all[ink as usize].points.len() >= most;
        if self.many {
            self.all = Default::default();
        } else {
            self.all[ink as usize].add(from, to);
        }
    }

    pub(super) fn has_new(&self) -> bool {
        self.new.iter().any(|lines| !lines.ends.is_empty())
    }

    /// True if all of them can be written again.
    pub(super) fn are_kept(&self) -> bool {
        !self.many
    }

    pub(super) fn all(&self) -> Vec<Line> {
        listed(&self.all)
    }

    pub(super) fn new_ones(&self) -> Vec<Line> {
        listed(&self.new)
    }

    /// Marks the new lines as written.
    pub(super) fn shown(&mut self) {
        self.new = Default::default();
    }
}

fn listed(all: &[Lines; 2]) -> Vec<Line> {
    let drawn = Ink::ALL.into_iter().zip(all);
    let drawn = drawn.filter(|(_, lines)| !lines.ends.is_empty());
    drawn
        .map(|(ink, lines)| Line::list(ink.color(), lines.points.clone(), lines.ends.clone()))
        .collect()
}
