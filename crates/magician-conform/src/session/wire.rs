//! Bytes and frames to and from the arm.

use std::time::Duration;

use magician_protocol::{Ctrl, Direction, Event, Frame, FrameBuf, NoArgs, Readable, Row};

use super::{Session, StepError, StepResult, differs};
use crate::report::{hex, in_words};
use crate::step::{ExpectedAnswer, reply_layout};
use crate::target::Target;

/// Bytes and frames.
impl<T: Target> Session<T> {
    pub(super) async fn send(&mut self, bytes: &[u8]) -> StepResult {
        self.sent = bytes.to_vec();
        Ok(self.target.send(bytes).await?)
    }

    /// Returns the next frame from the arm; `None` if none arrives in time.
    async fn next(&mut self, within: Duration) -> Result<Option<FrameBuf>, StepError> {
        let mut pieces = 0;
        while self.inbox.is_empty() {
            let bytes = self.target.receive(within).await?;
            // A line that is never silent has no frames for us either.
            pieces += 1;
            if bytes.is_empty() || pieces > 1000 {
                return Ok(None);
            }
            let mut input = bytes.as_slice();
            while let Some(event) = self.deframer.next(&mut input) {
                if let Event::Frame { frame, .. } = event {
                    self.inbox.push_back(FrameBuf::from(frame));
                }
            }
        }
        Ok(self.inbox.pop_front())
    }

    pub(super) async fn nothing(&mut self, within: Duration) -> StepResult {
        match self.next(within).await? {
            None => Ok(()),
            Some(frame) => differs(
                "nothing from the arm",
                in_words(&frame, Direction::Reply),
                frame.bytes(),
            ),
        }
    }

    pub(super) async fn reply(&mut self, bytes: &[Option<u8>]) -> StepResult {
        let expected: Vec<String> = bytes
            .iter()
            .map(|byte| byte.map_or("..".to_owned(), |byte| hex(&[byte])))
            .collect();
        let expected = expected.join(" ");
        let Some(frame) = self.next(self.patience).await? else {
            return differs(expected, "nothing", &[]);
        };
        let found = frame.bytes();
        let same = found.len() == bytes.len()
            && found
                .iter()
                .zip(bytes)
                .all(|(found, byte)| byte.is_none_or(|byte| byte == *found));
        if same {
            self.note_index(&frame).await
        } else {
            differs(expected, in_words(&frame, Direction::Reply), found)
        }
    }

    /// Expects the answer to the last frame: the same id and Ctrl, and exactly the parameters of
    /// its layout.
    pub(super) async fn answered(&mut self, answer: &ExpectedAnswer) -> StepResult {
        let Some(request) = Frame::new(&self.sent).map(FrameBuf::from) else {
            return differs(
                "a frame that can be answered",
                "damaged bytes were sent",
                &[],
            );
        };
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        let Some(row) = Row::with_id(id) else {
            return differs(
                "a command that can be answered",
                format!("id {id} was sent"),
                &[],
            );
        };
        // A refused command is answered with bit 2 of Ctrl set.
        let ctrl = if answer.full { ctrl.with_error() } else { ctrl };
        let layout = reply_layout(row, ctrl);
        let expected = || expectation(row, ctrl, answer);
        let Some(frame) = self.next(self.patience).await? else {
            return differs(expected(), "nothing", &[]);
        };
        let view = frame.frame();
        let fits = layout
            .normalise(view.params().len())
            .is_ok_and(|fit| fit.note.is_none());
        let right = view.id() == id
            && view.ctrl() == ctrl
            // A reply in another accepted form is a deviation: the arm has one.
            && fits
            && answer
                .checks
                .iter()
                .all(|check| check.holds(layout, view.params()))
            && self.indexed(row, ctrl, &frame, answer.full);
        if right {
            self.note_index(&frame).await
        } else {
            differs(
                expected(),
                in_words(&frame, Direction::Reply),
                frame.bytes(),
            )
        }
    }

    /// True if the index in the answer to a queued command is the next one, or 0 if it was refused.
    fn indexed(&self, row: &Row, ctrl: Ctrl, frame: &FrameBuf, full: bool) -> bool {
        match index_of(row, ctrl, frame) {
            None => true,
            Some(index) if full => index == 0,
            // The first index of a case may have any value: earlier cases have used the queue.
            Some(index) => index > 0 && self.last.is_none_or(|last| index == last + 1),
        }
    }

    async fn note_index(&mut self, frame: &FrameBuf) -> StepResult {
        let view = frame.frame();
        let Some(row) = Row::with_id(view.id()) else {
            return Ok(());
        };
        // 0 is the index of a refused command.
        if let Some(index) = index_of(row, view.ctrl(), frame).filter(|index| *index > 0) {
            self.last = Some(index);
        }
        // Durations count from the answer to the last command.
        if row.sets(view.ctrl()) {
            self.mark_command_time().await?;
        }
        Ok(())
    }

    /// Reads a value between steps; a report still shows the bytes of the step.
    pub(super) async fn ask<V: Readable<Query = NoArgs>>(&mut self) -> Result<V, StepError> {
        let told = std::mem::take(&mut self.sent);
        let frame = FrameBuf::get(&NoArgs, V::ROW).map_err(magician::Error::from)?;
        let name = V::ROW.get_name;
        self.send(frame.bytes()).await?;
        let Some(reply) = self.next(self.patience).await? else {
            return differs(format!("an answer to {name}"), "nothing", &[]);
        };
        let view = reply.frame();
        let value = (view.id() == V::ROW.id)
            .then(|| view.read::<V>().ok())
            .flatten();
        let Some(value) = value else {
            let got = in_words(&reply, Direction::Reply);
            return differs(format!("an answer to {name}"), got, reply.bytes());
        };
        // On errors the read stays in `sent`: then it is the frame to report.
        self.sent = told;
        Ok(value)
    }
}

fn index_of(row: &Row, ctrl: Ctrl, frame: &FrameBuf) -> Option<u64> {
    let queued = row.sets(ctrl) && ctrl.queued() && !row.steers_queue();
    let params: [u8; 8] = frame.frame().params().try_into().ok()?;
    queued.then(|| u64::from_le_bytes(params))
}

fn expectation(row: &Row, ctrl: Ctrl, answer: &ExpectedAnswer) -> String {
    let mut text = format!("{} with Ctrl {:#04x}", row.form_name(ctrl), ctrl.0);
    if row.sets(ctrl) && ctrl.queued() && !row.steers_queue() {
        text += if answer.full {
            " and index 0"
        } else {
            " and the next index"
        };
    }
    for check in &answer.checks {
        text += &format!(" {check}");
    }
    text
}

/// Exchanges outside of cases.
impl<T: Target> Session<T> {
    /// Returns the parameters in the answer to a get without fields; `None` without an answer.
    pub(crate) async fn value(&mut self, id: u8) -> magician::Result<Option<Vec<u8>>> {
        let frame = FrameBuf::new(id, Ctrl::GET, &[])?;
        let reply = self.exchange(&frame).await?;
        Ok(reply.map(|reply| reply.frame().params().to_vec()))
    }

    /// True if the arm answers a set.
    pub(crate) async fn acknowledged(&mut self, frame: &FrameBuf) -> magician::Result<bool> {
        Ok(self.exchange(frame).await?.is_some())
    }

    async fn exchange(&mut self, frame: &FrameBuf) -> magician::Result<Option<FrameBuf>> {
        self.target.send(frame.bytes()).await?;
        let id = frame.frame().id();
        match self.next(self.patience).await {
            Ok(reply) => Ok(reply.filter(|reply| reply.frame().id() == id)),
            Err(StepError::Line(error)) => Err(error),
            Err(StepError::Difference(_)) => Ok(None),
        }
    }
}
