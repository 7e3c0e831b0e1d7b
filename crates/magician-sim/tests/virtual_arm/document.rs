//! Text files: bounded in size, and each error in one line with its position.

use magician_sim::document::{self, DocumentError, MOST_BYTES};
use magician_sim::{Flash, Profile};

#[test]
fn what_is_no_text_is_refused_where_it_begins_not_to_be() {
    for (bytes, place) in [
        (&b"title = \"ok\"\n[tab\xFFle]\n"[..], (2, 5)),
        ("t = \"\u{e4}".as_bytes(), (0, 0)),
        (b"t = \"\xC3\xA4\xE4\"", (1, 7)),
        (b"\xFF\xFE[\0t\0", (1, 1)),
        (b"\n\n\xC3", (3, 1)),
    ] {
        match document::text(bytes.to_vec()) {
            Err(DocumentError::NotUtf8 { line, column }) => assert_eq!((line, column), place),
            Ok(text) => assert_eq!((text.as_bytes(), place), (bytes, (0, 0))),
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn what_is_too_large_is_refused() {
    assert!(document::text(vec![b' '; MOST_BYTES]).is_ok());
    assert_eq!(
        document::text(vec![b' '; MOST_BYTES + 1]),
        Err(DocumentError::TooLarge)
    );
}

#[test]
fn profiles_and_flashes_are_refused_in_one_line() {
    let profile = format!("{}\n[zzz]\n", Profile::pattern());
    let error = Profile::from_toml(&profile).unwrap_err().to_string();
    let line = profile.lines().count();
    assert!(
        error.starts_with(&format!("line {line}, column 2: unknown field `zzz`")),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1);

    // The line itself is not quoted: it may contain the password of a network.
    let flash = magician_sim::Controller::default().flash().to_toml();
    let flash = flash.replace("password = \"\"", "password = \"secret\" \"");
    let error = Flash::from_toml(&flash).unwrap_err().to_string();
    assert!(error.starts_with("line 8, column "), "{error}");
    assert!(
        !error.contains("secret") && error.lines().count() == 1,
        "{error}"
    );
}
