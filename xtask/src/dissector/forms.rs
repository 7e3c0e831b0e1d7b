//! Interpretation of frames of every form by the protocol's own decoder. The dissector repeats it
//! and decides nothing itself.

use magician_protocol::{
    Ctrl, Description, Direction, FormKind, FrameBuf, LayoutInfo, MAX_PARAMS, Row, describe,
};

/// Way in which a number of parameter bytes fits a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fit {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Bytes before the layout begins.
    pub(super) skip: usize,
    /// True if every number is sent as one byte.
    pub(super) bytes: bool,
    pub(super) note: Option<&'static str>,
}

/// Returns all numbers of parameter bytes that fit, in ranges.
pub(super) fn fits(layout: &LayoutInfo) -> Vec<Fit> {
    let mut fits: Vec<Fit> = Vec::new();
    for count in 0..=MAX_PARAMS {
        let Ok(found) = layout.normalise(count) else {
            continue;
        };
        let (skip, bytes) = match found.kind {
            FormKind::Skip(skip) => (skip, false),
            FormKind::Zeros => (0, false),
            FormKind::Bytes => (0, true),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let fit = Fit {
            from: count,
            to: count,
            skip,
            bytes,
            note: found.note,
        };
        match fits.last_mut() {
            Some(run) if run.to + 1 == count && is_same_interpretation(run, &fit) => run.to = count,
            _ => fits.push(fit),
        }
    }
    fits
}

fn is_same_interpretation(run: &Fit, fit: &Fit) -> bool {
    (run.skip, run.bytes, run.note) == (fit.skip, fit.bytes, fit.note)
}

/// Interpretation of a command's frames with one value of Ctrl.
pub(super) struct Plan {
    pub(super) name: &'static str,
    pub(super) request: &'static LayoutInfo,
    pub(super) reply: &'static LayoutInfo,
    /// Remarks about Ctrl.
    pub(super) notes: Vec<&'static str>,
}

/// Returns the interpretation of a row's frames with this Ctrl.
pub(super) fn plan(row: &Row, ctrl: u8) -> Plan {
    let (request, name, notes) = interpret(row, ctrl, Direction::Request);
    let (reply, _, same_notes) = interpret(row, ctrl, Direction::Reply);
    assert_eq!(notes, same_notes, "id {}: Ctrl is Ctrl", row.id);
    Plan {
        name,
        request,
        reply,
        notes,
    }
}

/// Returns the layout, the form's name, and the remarks that do not concern the parameters.
fn interpret(
    row: &Row,
    ctrl: u8,
    direction: Direction,
) -> (&'static LayoutInfo, &'static str, Vec<&'static str>) {
    for count in 0..=MAX_PARAMS {
        let frame = frame(row.id, ctrl, &[0; MAX_PARAMS][..count]);
        if let Ok(description) = describe(&frame.frame(), direction) {
            let of_params = description.layout.normalise(count).ok();
            let of_params = of_params.and_then(|fit| fit.note);
            let notes = description.notes().filter(|note| Some(*note) != of_params);
            return (description.layout, description.name, notes.collect());
        }
    }
    unreachable!("id {}: a layout fits some number of bytes", row.id)
}

fn frame(id: u8, ctrl: u8, params: &[u8]) -> FrameBuf {
    FrameBuf::new(id, Ctrl(ctrl), params).expect("no more than a frame takes")
}

/// Returns the remarks that any command can cause, with the engine's names for them.
pub(super) fn notes() -> [(&'static str, &'static str); 5] {
    const POSE: u8 = 10;
    const PTP_PO: u8 = 88;
    const MOTOR: u8 = 135;
    const START: u8 = 240;
    let first = |id, ctrl, params: &[u8]| {
        let frame = frame(id, ctrl, params);
        let description = describe(&frame.frame(), Direction::Request).ok();
        description.and_then(|description| description.notes().next())
    };
    let float = [&[0, 1][..], &1000f32.to_le_bytes()].concat();
    let start = frame(START, 1, &[]);
    let either = Description::guess(&start.frame()).ok();
    [
        ("error", first(POSE, 4, &[])),
        ("destination", first(POSE, 8, &[])),
        ("counted", first(PTP_PO, 3, &[0; 18])),
        ("float", first(MOTOR, 3, &float)),
        (
            "both",
            either.and_then(|description| description.notes().next()),
        ),
    ]
    .map(|(name, note)| (name, note.expect("the reader remarks it")))
}
