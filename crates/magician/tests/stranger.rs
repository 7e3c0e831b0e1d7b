//! Matches of a foreign crate over one enum each of protocol, host and driver, without a wildcard.
//! Inside this workspace (`--cfg magician_workspace`) they compile. Anywhere else each must be
//! error E0004, since a new variant would break programs of other authors: `.ci/run published`
//! counts them.

use std::io::ErrorKind;

use magician::connection::Event;
use magician::serve::Notice;
use magician_protocol::Effect;

fn takes_time(effect: Effect) -> bool {
    match effect {
        Effect::Look | Effect::Consume | Effect::Setting | Effect::Store => false,
        Effect::Motion | Effect::Jog | Effect::Motor | Effect::Wait => true,
        Effect::Laser | Effect::Queue => false,
    }
}

fn ends_request(event: &Event) -> bool {
    match event {
        Event::Done { .. } => true,
        Event::Reset | Event::Unaccounted { .. } => false,
    }
}

fn is_about_files(notice: &Notice) -> bool {
    match notice {
        Notice::FlashNotKept(_) | Notice::TraceEnded(_) | Notice::RecordingEnded(_) => true,
        Notice::Arm(_) | Notice::Connected(_) | Notice::Left(_) | Notice::Refused(_) => false,
        Notice::MadeRoom(_) | Notice::Unplugged | Notice::Plugged(_) => false,
        Notice::Undiscoverable { .. } => false,
    }
}

#[test]
fn enums_that_may_grow_are_exhaustive_inside_this_workspace() {
    assert!(takes_time(Effect::Jog));
    assert!(!ends_request(&Event::Reset));
    let full = Notice::TraceEnded(ErrorKind::StorageFull.into());
    assert!(is_about_files(&full));
}
