//! Files that people write: bounded, and every refusal in one line that says where.

use std::fs;

use magician_sim::document::{self, DocumentError};
use magician_sim::{Flash, Profile};

#[test]
fn what_is_no_text_is_refused_where_it_begins_not_to_be() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("scenario.toml");
    for (bytes, place) in [
        (&b"title = \"ok\"\n[tab\xFFle]\n"[..], (2, 5)),
        ("t = \"\u{e4}".as_bytes(), (0, 0)),
        (b"t = \"\xC3\xA4\xE4\"", (1, 7)),
        (b"\xFF\xFE[\0t\0", (1, 1)),
        (b"\n\n\xC3", (3, 1)),
    ] {
        fs::write(&path, bytes).unwrap();
        match document::read(&path) {
            Err(DocumentError::NotUtf8 { line, column }) => assert_eq!((line, column), place),
            Ok(text) => assert_eq!((text.as_bytes(), place), (bytes, (0, 0))),
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn what_is_too_large_is_not_read_to_its_end() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("scenario.toml");
    let file = fs::File::create(&path).unwrap();
    file.set_len(16 << 20).unwrap();
    assert_eq!(document::read(&path).unwrap().len(), 16 << 20);
    // Larger than memory.
    file.set_len(1 << 36).unwrap();
    assert!(matches!(
        document::read(&path),
        Err(DocumentError::TooLarge)
    ));
    assert!(matches!(Flash::load(&path), Err(error) if error.to_string().contains("16 MB")));
    let missing = document::read(&directory.path().join("missing"));
    assert!(matches!(missing, Err(DocumentError::File(_))));
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

    // The line itself is not told: it may hold the password of a network.
    let flash = magician_sim::Controller::default().flash().to_toml();
    let flash = flash.replace("password = \"\"", "password = \"secret\" \"");
    let error = Flash::from_toml(&flash).unwrap_err().to_string();
    assert!(error.starts_with("line 8, column "), "{error}");
    assert!(
        !error.contains("secret") && error.lines().count() == 1,
        "{error}"
    );
}
