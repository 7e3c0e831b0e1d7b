use crate::commands::{Get, Set};
use crate::layout::{Field, LayoutInfo};
use crate::wire::{FieldType, Reader, Scalar, Wire};
use crate::{DecodeError, Frame, Layout, Range, Row, Writer};

/// What a frame asks of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum Request {
    /// To report a value.
    Get(Get),
    /// To set a value or act, at once.
    Set(Set),
    /// To set a value or act when its turn comes.
    Queue(Set),
    /// A set-only command with rw = 0: answered empty, does nothing (errata E12).
    Nothing,
}

impl Request {
    /// Reads a frame as a controller does: bit 1 alone decides queueing (errata E07), get-only
    /// commands answer whatever rw says (errata E12), the commands that steer the queue are never
    /// queued.
    ///
    /// # Errors
    /// [`DecodeError::UnknownId`] and [`DecodeError::Length`].
    pub fn decode(frame: &Frame<'_>) -> Result<Self, DecodeError> {
        let (id, ctrl, params) = (frame.id(), frame.ctrl(), frame.params());
        let row = Row::with_id(id).ok_or(DecodeError::UnknownId(id))?;
        let queued = ctrl.queued() && !row.steers_queue();
        match (row.set, row.value) {
            (Some(_), _) if queued => Set::decode(id, params).map(Self::Queue),
            (Some(_), _) if ctrl.write() => Set::decode(id, params).map(Self::Set),
            (_, Some(_)) => Get::decode(id, params).map(Self::Get),
            _ => Ok(Self::Nothing),
        }
    }
}

/// The answer to a queued command: the index it was given (document 1.2.1, errata E37).
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
            doc: "Index given to the command, one more than the one before; 0 is never given.",
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
