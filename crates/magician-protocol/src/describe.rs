//! Explanation of single frames for traces, logs and `magician decode`: row, form, fields, and the
//! deviations from the strict form.

use crate::layout::Fields;
use crate::message::QueuedCmdIndex;
use crate::motor;
use crate::{DecodeError, FieldValue, Frame, Layout, LayoutInfo, NoArgs, Row};

/// Direction of travel of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the host to the arm.
    Request,
    /// From the arm to the host.
    Reply,
}

/// Largest number of notes on one frame.
pub const MAX_NOTES: usize = 6;

/// A decoded frame: its command, form, fields and deviations.
#[derive(Clone, Debug)]
pub struct Description<'a> {
    /// Row of the command.
    pub row: &'static Row,
    /// Name of the form, as the vendor writes it (`GetPose`, `SetPTPCmd`).
    pub name: &'static str,
    /// The sender.
    pub direction: Direction,
    /// True if the form is a set.
    pub write: bool,
    /// True if the queued bit is set.
    pub queued: bool,
    /// The layout that the parameters follow.
    pub layout: &'static LayoutInfo,
    params: &'a [u8],
    notes: [Option<&'static str>; MAX_NOTES],
}

impl<'a> Description<'a> {
    /// Fields with their values.
    ///
    /// # Errors
    /// Never in practice: [`describe`] has decoded the fields once.
    pub fn values(&self) -> Result<Fields<'a>, DecodeError> {
        self.layout.values(self.params)
    }

    /// Deviations from the strict form, in words, with their errata.
    pub fn notes(&self) -> impl Iterator<Item = &'static str> {
        self.notes.into_iter().flatten()
    }

    /// True if the frame has exactly the form that a strict sender uses.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.notes.iter().all(Option::is_none)
    }

    fn note(&mut self, text: &'static str) {
        if let Some(free) = self.notes.iter_mut().find(|note| note.is_none()) {
            *free = Some(text);
        }
    }
}

/// Explains a frame whose direction is known.
///
/// # Errors
/// [`DecodeError::UnknownId`], or [`DecodeError::Length`] if the parameters fit no accepted form.
pub fn describe<'a>(
    frame: &Frame<'a>,
    direction: Direction,
) -> Result<Description<'a>, DecodeError> {
    let (ctrl, params) = (frame.ctrl(), frame.params());
    let row = Row::with_id(frame.id()).ok_or(DecodeError::UnknownId(frame.id()))?;
    let queued = ctrl.queued() && !row.steers_queue();
    let write = row.sets(ctrl);
    // A get of a set-only command is answered empty and does nothing (E12).
    let inert = !write && row.value.is_none();
    let layout = match direction {
        _ if inert => NoArgs::INFO,
        Direction::Request if write => row.set.unwrap_or(NoArgs::INFO),
        Direction::Request => row.query.unwrap_or(NoArgs::INFO),
        Direction::Reply if write && queued => QueuedCmdIndex::INFO,
        Direction::Reply if write => NoArgs::INFO,
        Direction::Reply => row.value.unwrap_or(NoArgs::INFO),
    };
    let fit = layout.normalise(params.len())?;
    let mut description = Description {
        row,
        name: row.form_name(ctrl),
        direction,
        write,
        queued: ctrl.queued(),
        layout,
        params,
        notes: [None; MAX_NOTES],
    };
    for (_, value) in description.values()? {
        match value {
            FieldValue::Outputs(list) if list.counted() => {
                description.note("count byte before the list of outputs (E29)");
            }
            FieldValue::Signed(speed) if motor::float_bits(speed).is_some() => {
                description.note("speed read as the bits of a float (E41)");
            }
            // All other types have one form on the wire.
            _ => {}
        }
    }
    if let Some(note) = fit.note {
        description.note(note);
    }
    note_ctrl(&mut description, frame, inert);
    Ok(description)
}

fn note_ctrl(description: &mut Description<'_>, frame: &Frame<'_>, inert: bool) {
    let (row, ctrl) = (description.row, frame.ctrl());
    if ctrl.queued() && !ctrl.write() && row.set.is_some() && !row.steers_queue() {
        description.note("queued with rw = 0: treated as a queued set (E07)");
    }
    if inert {
        description.note("set-only command with rw = 0: has no effect (E12)");
    }
    if ctrl.write() && row.set.is_none() {
        description.note("get-only command with rw = 1: answered as a get (E12)");
    }
    if ctrl.queued() && (row.steers_queue() || row.set.is_none()) {
        description.note("queued bit ignored for this command");
    }
    if ctrl.error() {
        description.note("error bit set: the controller refused the command (E05)");
    }
    // Bits 3 to 7: reserved, destination, slave.
    if ctrl.0 & 0xF8 != 0 {
        description.note("destination or reserved bits set in Ctrl (E05)");
    }
}

impl<'a> Description<'a> {
    /// Explains a frame whose direction is unknown.
    ///
    /// Takes the direction whose layout fits exactly (the host's if both do), else the direction
    /// that fits with a deviation.
    ///
    /// # Errors
    /// Same as [`describe`], for the direction from the host.
    pub fn guess(frame: &Frame<'a>) -> Result<Self, DecodeError> {
        let request = describe(frame, Direction::Request);
        let reply = describe(frame, Direction::Reply);
        let fits = |d: &Result<Description<'_>, _>| d.as_ref().is_ok_and(Description::fits_exactly);
        match (fits(&request), fits(&reply)) {
            // Typical of frames without parameters: nothing in them shows the direction.
            (true, true) => request.map(|mut description| {
                description.note("fits both directions: treated as a request of the host");
                description
            }),
            (true, false) => request,
            (false, true) => reply,
            (false, false) => request.or(reply),
        }
    }

    fn fits_exactly(&self) -> bool {
        self.layout
            .normalise(self.params.len())
            .is_ok_and(|fit| fit.note.is_none())
    }
}
