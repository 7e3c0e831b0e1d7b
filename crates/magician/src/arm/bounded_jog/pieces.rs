//! The pieces of a jog.

use std::collections::VecDeque;

use magician_protocol::Set;

use super::READ;
use super::pace::{Pace, Piece};
use crate::Result;
use crate::build::{self, Axis, JogDirection};
use crate::preflight::Preflight;

/// A piece that would cross a limit is cut to this share of it, again and again, but not below the least, mm or degrees.
const CUT: f32 = 0.5;
const LEAST: f32 = 0.05;

/// What a jog in pieces is made of.
pub(super) struct Pieces {
    pub(super) direction: JogDirection,
    pace: Pace,
    course: Preflight,
    /// Where it began on its axis.
    pub(super) from: f64,
    /// How far the arm was seen to be from there, and how far the pieces lead.
    gone: f64,
    pub(super) sent: f64,
    /// Those that the arm may not have done: how long each is, and how far from the beginning it ends.
    under_way: VecDeque<(f64, f64)>,
}

impl Pieces {
    pub(super) fn new(direction: JogDirection, pace: Pace, course: Preflight, from: f64) -> Self {
        Self {
            direction,
            pace,
            course,
            from,
            gone: 0.0,
            sent: 0.0,
            under_way: VecDeque::new(),
        }
    }

    /// How far along its way the arm is that was seen at a place. Pieces that are done are forgotten.
    pub(super) fn saw(&mut self, place: f64) -> f64 {
        let way = place - self.from;
        self.gone = if self.direction.forward { way } else { -way };
        while let Some((_, end)) = self.under_way.front()
            && *end <= self.gone + READ
        {
            self.under_way.pop_front();
        }
        self.gone
    }

    /// How long the next piece may be; or after which time to look again, s.
    pub(super) fn next(&self) -> std::result::Result<f64, f64> {
        self.pace
            .next(self.under_way.iter().map(|(length, end)| Piece {
                length: *length,
                left: (end - self.gone).clamp(0.0, *length),
            }))
    }

    /// The piece of that length, or as much of it as leads across no limit, with the check behind it.
    pub(super) fn cut(&self, length: f64) -> Result<(Set, Preflight, f64)> {
        let mut by = length as f32;
        loop {
            let command = piece(self.direction, by);
            let mut course = self.course.clone();
            match course.check(&command) {
                Ok(_) => return Ok((command, course, by.into())),
                Err(error) if by * CUT < LEAST => return Err(error),
                Err(_) => by *= CUT,
            }
        }
    }

    pub(super) fn note(&mut self, course: Preflight, length: f64) {
        self.course = course;
        self.sent += length;
        self.under_way.push_back((length, self.sent));
    }
}

/// A piece of a jog, of so many mm or degrees.
pub(super) fn piece(direction: JogDirection, length: f32) -> Set {
    let by = direction.signed(length);
    match direction.axis {
        Axis::X => build::path_by(by, 0.0, 0.0),
        Axis::Y => build::path_by(0.0, by, 0.0),
        Axis::Z => build::path_by(0.0, 0.0, by),
        // A jog of r turns joint 4 alone.
        Axis::R => build::move_joints_by(0.0, 0.0, 0.0, by),
        axis => axis.step(by),
    }
}
