//! Meaning of the control byte and the id, in both directions.

use crate::material::{assert_single_note, fields, frame, notes, request};
use magician_protocol::{DecodeError, Description, Direction, Get, Request, Set};

#[test]
fn e05_destination_and_error_bits_are_kept_and_noted() {
    assert_eq!(request(10, 0x10, &[]), request(10, 0, &[]));
    assert_single_note(10, 0x10, &[], "E05");
    assert_single_note(10, 0xC0, &[], "E05");
    let notes = notes(84, 0x07, &[0; 8], Direction::Reply);
    assert!(notes.len() == 1 && notes[0].contains("refused"));
    let ctrl = frame(10, 0x95, &[]).frame().ctrl();
    assert_eq!((ctrl.destination(), ctrl.slave()), (1, 2));
    assert!(ctrl.error() && ctrl.write() && !ctrl.queued());
}

#[test]
fn e07_the_queued_bit_alone_queues() {
    assert!(matches!(
        request(3, 2, &[1, 1]),
        Ok(Request::Queue(Set::SetDeviceWithL(_)))
    ));
    assert_single_note(3, 2, &[1, 1], "E07");
    assert_eq!(
        fields(3, 2, &[5, 0, 0, 0, 0, 0, 0, 0], Direction::Reply),
        "queued_cmd_index=5"
    );
    assert_eq!(
        request(240, 3, &[]),
        request(240, 1, &[]),
        "240 is never queued"
    );
    assert_eq!(request(246, 2, &[]), request(246, 0, &[]), "nor is a get");
}

#[test]
fn e12_rw_does_not_matter_where_there_is_one_direction() {
    assert!(matches!(
        request(246, 1, &[]),
        Ok(Request::Get(Get::QueuedCmdCurrentIndex(_)))
    ));
    assert_single_note(246, 1, &[], "E12");
    let answer = fields(246, 1, &[7, 0, 0, 0, 0, 0, 0, 0], Direction::Reply);
    assert_eq!(answer, "queued_cmd_current_index=7");
    assert_eq!(request(240, 0, &[]), Ok(Request::Nothing));
    assert_single_note(240, 0, &[], "E12");
    assert_eq!(request(84, 0, &[1, 2, 3]), Ok(Request::Nothing));
}

#[test]
fn e19_alarms_are_cleared_under_both_ids() {
    assert!(matches!(
        request(20, 1, &[]),
        Ok(Request::Set(Set::ClearAlarmsState(_)))
    ));
    assert!(matches!(
        request(21, 1, &[]),
        Ok(Request::Set(Set::ClearAllAlarmsState(_)))
    ));
}

#[test]
fn unknown_ids_and_missing_forms_say_so() {
    assert_eq!(request(7, 0, &[]), Err(DecodeError::UnknownId(7)));
    assert_eq!(Set::decode(10, &[]), Err(DecodeError::NoSuchForm(10)));
    assert_eq!(Get::decode(84, &[]), Err(DecodeError::NoSuchForm(84)));
}

#[test]
fn the_direction_is_guessed_from_what_fits() {
    let guess = |id, ctrl, params: &[u8]| {
        let frame = frame(id, ctrl, params);
        let guess = Description::guess(&frame.frame()).unwrap();
        (
            guess.direction,
            guess.notes().any(|note| note.contains("both")),
        )
    };
    assert_eq!(guess(10, 0, &[]), (Direction::Request, false));
    assert_eq!(guess(10, 0, &[0; 32]), (Direction::Reply, false));
    assert_eq!(guess(84, 3, &[0; 17]), (Direction::Request, false));
    assert_eq!(guess(84, 3, &[0; 8]), (Direction::Reply, false));
    assert_eq!(guess(84, 1, &[]), (Direction::Reply, false));
    assert_eq!(guess(245, 1, &[]), (Direction::Request, true));
    assert_eq!(guess(1, 0, b"arm\0"), (Direction::Reply, false));
}
