//! Sequence of the short moves (pieces) of a bounded jog, with the limit check of each and the
//! distance covered.

use std::collections::VecDeque;

use magician_protocol::Set;

use super::POSITION_TOLERANCE;
use super::pace::{Pace, Piece};
use crate::Result;
use crate::build::{self, Axis, JogDirection};
use crate::preflight::Preflight;

/// Factor by which a piece that would cross a limit is shortened, repeatedly. Choice.
const SHORTENING_FACTOR: f32 = 0.5;
/// Shortest piece after shortening, mm or degrees. Choice: the jog ends within 0.05 mm of its
/// limit.
const MIN_PIECE_LENGTH: f32 = 0.05;

/// Pieces of a bounded jog.
pub(super) struct Pieces {
    pub(super) direction: JogDirection,
    pace: Pace,
    course: Preflight,
    /// Start position on the axis.
    pub(super) from: f64,
    /// Distance from the start at which the arm was last seen.
    covered: f64,
    /// Total length of the pieces sent.
    pub(super) sent: f64,
    /// Unfinished pieces: length, and distance of the end from the start.
    under_way: VecDeque<(f64, f64)>,
}

impl Pieces {
    pub(super) fn new(direction: JogDirection, pace: Pace, course: Preflight, from: f64) -> Self {
        Self {
            direction,
            pace,
            course,
            from,
            covered: 0.0,
            sent: 0.0,
            under_way: VecDeque::new(),
        }
    }

    /// Stores a position on the axis, drops finished pieces, and returns the distance from the
    /// start.
    pub(super) fn update_position(&mut self, place: f64) -> f64 {
        let offset = place - self.from;
        self.covered = if self.direction.forward {
            offset
        } else {
            -offset
        };
        while let Some((_, end)) = self.under_way.front()
            && *end <= self.covered + POSITION_TOLERANCE
        {
            self.under_way.pop_front();
        }
        self.covered
    }

    /// Returns the length of the next piece, or as `Err` the time until the next position read, s.
    pub(super) fn next(&self) -> std::result::Result<f64, f64> {
        self.pace
            .next(self.under_way.iter().map(|(length, end)| Piece {
                length: *length,
                left: (end - self.covered).clamp(0.0, *length),
            }))
    }

    /// Returns a piece of at most this length, the check advanced past it, and its length. The
    /// piece is halved until it crosses no limit.
    pub(super) fn piece_within_limits(&self, length: f64) -> Result<(Set, Preflight, f64)> {
        let mut by = length as f32;
        loop {
            let command = piece(self.direction, by);
            let mut course = self.course.clone();
            match course.check(&command) {
                Ok(_) => return Ok((command, course, by.into())),
                Err(error) if by * SHORTENING_FACTOR < MIN_PIECE_LENGTH => return Err(error),
                // Halving finds a piece that ends before the limit within a few checks.
                Err(_) => by *= SHORTENING_FACTOR,
            }
        }
    }

    pub(super) fn note(&mut self, course: Preflight, length: f64) {
        self.course = course;
        self.sent += length;
        self.under_way.push_back((length, self.sent));
    }
}

/// Returns a piece of this length, mm or degrees.
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
