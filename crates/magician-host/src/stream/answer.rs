//! Answers to the stream's requests: accepted and failed commands, and stops, clears and starts of
//! the queue.

use magician_protocol::{ArmInstant, FrameBuf, Layout, QueuedCmdIndex};

use super::drive::Phase;
use super::item::{Entry, Fate};
use super::reading::MIN_READ_INTERVAL;
use super::{Stream, StreamEvent, StreamFailure};
use crate::connection::{Connection, Failure, Micros, Ticket};

/// Attempts to start the queue without an answer.
// A choice: each attempt waits until the arm stands.
const MAX_START_ATTEMPTS: u8 = 4;

impl Stream {
    /// Processes the result of a request. True if it was one of the stream's. Call
    /// [`advance`](Self::advance) afterwards.
    pub fn answered(
        &mut self,
        now: Micros,
        ticket: Ticket,
        result: &Result<FrameBuf, Failure>,
        connection: &mut Connection,
    ) -> bool {
        let now = self.clock.at(now);
        let flying = |entry: &Entry| entry.fate == Fate::InFlight(ticket);
        if self.flying() > 0
            && let Some(at) = self.entries.find(flying)
        {
            self.command_answered(now, at, result);
            self.guessed = connection.is_last_index_estimated();
            return true;
        }
        if self.control.take_if(|control| *control == ticket).is_some() {
            self.control_answered(now, result);
            return true;
        }
        self.reading_answered(now, ticket, result, connection)
    }

    fn command_answered(&mut self, now: ArmInstant, at: usize, result: &Result<FrameBuf, Failure>) {
        let index = |frame: &FrameBuf| QueuedCmdIndex::decode(frame.frame().params());
        match result {
            Ok(frame) => match index(frame) {
                Ok(QueuedCmdIndex(index)) => self.command_accepted(now, at, index),
                Err(_) => self.command_failed(now, at, Failure::NoIndex),
            },
            Err(failure) => self.command_failed(now, at, *failure),
        }
    }

    fn command_accepted(&mut self, now: ArmInstant, at: usize, index: u64) {
        if self.entries.unfinished(self.reader.current).count == 0 {
            self.reader.begins(now);
        }
        self.correct(index);
        let Some(entry) = self.entries.get(at).copied() else {
            return;
        };
        if let Some(expected) = self.expected
            && expected != index
        {
            self.entries.set_fate(at, Fate::Doubtful);
            return self.fail(StreamFailure::Index {
                expected,
                found: index,
            });
        }
        let fate = Fate::Accepted(index);
        self.entries.set_fate(at, fate);
        self.newest = Some(Entry { fate, ..entry });
        self.accepted += u64::from(!entry.inserted);
        self.first.get_or_insert(index);
        if self.expected.is_none() {
            // First index of the stream, or first after a Clear, which skips the numbers of dropped
            // commands.
            self.base = index.saturating_sub(1);
        }
        // If it travelled alone and everything before it is confirmed, its index is confirmed, too.
        let itself = self.confirmed.is_none_or(|confirmed| index > confirmed);
        if self.entries.unconfirmed(self.confirmed) <= usize::from(itself) {
            self.confirmed = Some(index);
            self.mark();
        }
        self.last = Some(index);
        self.expected = index.checked_add(1);
        self.report_progress();
    }

    pub(super) fn report_progress(&mut self) {
        if let (Some(first), Some(last), false) = (self.first, self.last, self.is_over()) {
            self.events.push(StreamEvent::Sent {
                accepted: self.accepted,
                first,
                last,
                current: self.reader.current,
            });
        }
    }

    fn command_failed(&mut self, now: ArmInstant, at: usize, failure: Failure) {
        let nowhere = match failure {
            // The controller may have taken the command; after any other failure it has not.
            Failure::Uncertain { .. } | Failure::NoIndex | Failure::Timeout { sent: 1.. } => false,
            Failure::Timeout { .. }
            | Failure::QueueFull
            | Failure::Refused
            | Failure::Stopped
            | Failure::Lost
            | Failure::Draining
            | Failure::Busy => true,
        };
        let fate = if nowhere {
            Fate::Waiting
        } else {
            Fate::Doubtful
        };
        self.entries.set_fate(at, fate);
        if nowhere && let Some(group) = &mut self.group {
            *group += 1;
        }
        let overtaken = self
            .entries
            .iter()
            .skip(at + 1)
            .any(|entry| !entry.is_waiting());
        match failure {
            // The stream is over, or `resolve` finds out the fate of every command.
            _ if self.is_over() || matches!(self.phase, Phase::Resolve(_)) => {}
            // Dropped by the connection because it waited behind the gap.
            Failure::Stopped if self.gap => {}
            Failure::Uncertain { .. } => self.note_gap(failure),
            Failure::QueueFull | Failure::Busy | Failure::Draining if overtaken => {
                self.note_gap(failure);
            }
            // The group was measured to fit in the empty queue, which must not start with only a
            // part of the group.
            Failure::QueueFull if self.stopped && self.group.is_some() => {
                self.fail(StreamFailure::Request(failure));
            }
            Failure::QueueFull => {
                self.credit.full = true;
                self.reader.want_left();
                self.reader.look(now.after_micros(MIN_READ_INTERVAL));
            }
            Failure::Busy | Failure::Draining => {
                self.retry_at = Some(now.after_micros(MIN_READ_INTERVAL))
            }
            _ => self.fail(StreamFailure::Request(failure)),
        }
    }

    /// Handles a command that was or may have been lost between others.
    fn note_gap(&mut self, failure: Failure) {
        if self.settings.window > 1 && self.may_go_back() {
            self.gap = true;
        } else {
            self.fail(StreamFailure::Request(failure));
        }
    }

    fn control_answered(&mut self, now: ArmInstant, result: &Result<FrameBuf, Failure>) {
        match result {
            Err(Failure::Busy) => self.retry_at = Some(now.after_micros(MIN_READ_INTERVAL)),
            // The start may have got through, and a second one may end a motion (model section 14).
            Err(Failure::Timeout { sent: 1.. } | Failure::Uncertain { .. })
                if self.phase == Phase::Start && self.starts + 1 < MAX_START_ATTEMPTS =>
            {
                self.starts += 1;
                self.reader.look_closely(now, true);
                self.phase = Phase::AwaitRest(None);
            }
            Err(failure) => self.fail(StreamFailure::Request(*failure)),
            // Late answers after the end change nothing.
            Ok(_) if self.is_over() => {}
            Ok(_) => {
                self.phase = match self.phase {
                    Phase::Stop => {
                        self.stopped = true;
                        Phase::Load
                    }
                    Phase::Start => self.started(now),
                    Phase::Halt => {
                        self.stopped = true;
                        self.reader.look_closely(now, true);
                        Phase::AwaitStop(None)
                    }
                    Phase::Clear => {
                        self.reader.look_closely(now, true);
                        Phase::Drain {
                            since: now,
                            left: 0,
                        }
                    }
                    other => other,
                };
            }
        }
    }
}
