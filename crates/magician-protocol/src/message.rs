//! Requests as a controller reads them, and the reply to a queued command.

use crate::commands::{Get, Set};
use crate::layout::{Field, LayoutInfo};
use crate::wire::{FieldType, Reader, Scalar, Wire};
use crate::{DecodeError, Frame, Layout, Range, Row, Writer};

/// A decoded request frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum Request {
    /// Report a value.
    Get(Get),
    /// Set a value or perform an action immediately.
    Set(Set),
    /// Queue a set or an action.
    Queue(Set),
    /// A set-only command with rw = 0: answered empty, without effect (errata E12).
    Nothing,
}

impl Request {
    /// Decodes a frame as a controller does.
    ///
    /// Bit 1 alone decides whether it is queued (errata E07), get-only commands answer whatever rw
    /// says (errata E12), and commands that control the queue are never queued.
    ///
    /// # Errors
    /// [`DecodeError::UnknownId`], or the layout's [`DecodeError::Length`] and
    /// [`DecodeError::List`].
    pub fn decode(frame: &Frame<'_>) -> Result<Self, DecodeError> {
        let (id, ctrl, params) = (frame.id(), frame.ctrl(), frame.params());
        let row = Row::with_id(id).ok_or(DecodeError::UnknownId(id))?;
        let queued = ctrl.queued() && !row.steers_queue();
        match (row.set, row.value) {
            (Some(_), _) if queued => Set::decode(id, params).map(Self::Queue),
            (Some(_), _) if ctrl.write() => Set::decode(id, params).map(Self::Set),
            (_, Some(_)) => Get::decode(id, params).map(Self::Get),
            // A set-only command that is no set (E12).
            _ => Ok(Self::Nothing),
        }
    }
}

/// Reply to a queued command: the index it was given (document 1.2.1, errata E37).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct QueuedCmdIndex(pub u64);

impl Layout for QueuedCmdIndex {
    const INFO: &'static LayoutInfo = &LayoutInfo {
        name: "QueuedCmdIndex",
        fields: &[Field {
            name: "queued_cmd_index",
            ty: FieldType::Scalar(Scalar::U64),
            unit: "index",
            range: Range::Any,
            doc: "Index assigned to the command, one more than that of the previous one; never 0.",
            optional: false,
            omittable: false,
            default: None,
        }],
        forms: &[],
    };

    fn decode(params: &[u8]) -> Result<Self, DecodeError> {
        u64::read(&mut Reader::new(params)).map(Self)
    }

    fn encode(&self, writer: &mut Writer<'_>) {
        self.0.write(writer);
    }
}
