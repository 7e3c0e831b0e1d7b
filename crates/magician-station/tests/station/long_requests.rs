//! Turns of long-running requests.

use magician_station::LibraryAct;
use serde_json::json;

use crate::bare::BareStation;

#[test]
fn request_of_a_closed_socket_does_not_start() {
    let mut bare = BareStation::new();
    let ben = bare.join("Ben");
    for name in ["first", "second"] {
        bare.send("program.get", &json!({"name": name}));
    }
    let first = bare.station.poll_library().expect("her first begins");
    assert!(
        bare.station.poll_library().is_none(),
        "one of a session at once"
    );
    bare.station.close(bare.now, bare.socket);
    bare.ask(ben, "program.list", &json!({}));
    let of_ben = bare
        .station
        .poll_library()
        .expect("others do not wait for it");
    assert_eq!(of_ben.act, LibraryAct::List);
    bare.station
        .library_done(bare.now, first.request, Ok(json!({})));
    assert!(
        bare.station.poll_library().is_none(),
        "her second is forgotten"
    );
}
