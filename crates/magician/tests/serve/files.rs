//! Files of a virtual arm: bounded reading, and atomic replacement of its flash.

use std::fs;

use magician::serve::files::{FlashFileError, TextFileError, load_flash, read_text, save_flash};
use magician_protocol::commands::{DeviceName, WifiPassword};
use magician_protocol::{Ctrl, FrameBuf, Text, Writable};
use magician_sim::document::DocumentError;
use magician_sim::{Controller, LinkId};

fn set<T: Writable>(arm: &mut Controller, value: &T) {
    let request = FrameBuf::encode(T::ROW.id, Ctrl::SET, value).unwrap();
    arm.receive(LinkId(0), request.bytes());
}

/// Sets some of the values kept in flash.
fn fill(arm: &mut Controller) {
    let device_name = Text::new("Ada \"=\n\u{e4}").unwrap();
    set(arm, &DeviceName { device_name });
    let password = Text::new("\\secret\u{7f}").unwrap();
    set(arm, &WifiPassword { password });
}

#[test]
fn what_is_too_large_is_not_read_to_its_end() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("scenario.toml");
    let file = fs::File::create(&path).unwrap();
    file.set_len(16 << 20).unwrap();
    assert_eq!(read_text(&path).unwrap().len(), 16 << 20);
    // Larger than memory.
    file.set_len(1 << 36).unwrap();
    assert!(matches!(
        read_text(&path),
        Err(TextFileError::Document(DocumentError::TooLarge))
    ));
    assert!(matches!(load_flash(&path), Err(error) if error.to_string().contains("16 MB")));
    let missing = read_text(&directory.path().join("missing"));
    assert!(matches!(missing, Err(TextFileError::File(_))));
}

#[test]
fn a_file_is_replaced_whole() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("flash.toml");
    assert!(load_flash(&path).unwrap().is_none(), "no file is no error");
    let mut arm = Controller::default();
    save_flash(arm.flash(), &path).unwrap();
    fill(&mut arm);
    save_flash(arm.flash(), &path).unwrap();
    assert_eq!(&load_flash(&path).unwrap().unwrap(), arm.flash());
    let left: Vec<_> = fs::read_dir(directory.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_damaged_file_is_named_and_left_alone() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("flash.toml");
    for damage in [&b"version = 1\nname = "[..], b"\xFF\xFE", b""] {
        fs::write(&path, damage).unwrap();
        let error = load_flash(&path).unwrap_err();
        assert!(matches!(error, FlashFileError::Damaged { .. }), "{error}");
        assert!(error.to_string().contains("flash.toml is damaged"));
        assert_eq!(fs::read(&path).unwrap(), damage);
    }
    assert!(matches!(
        load_flash(directory.path()),
        Err(FlashFileError::File { .. })
    ));
}

#[test]
fn flash_that_cannot_be_written_says_where() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("flash.toml");
    fs::create_dir(&path).unwrap();
    let mut arm = Controller::default();
    fill(&mut arm);
    let error = save_flash(arm.flash(), &path).unwrap_err();
    assert!(error.to_string().contains("flash.toml: cannot write"));
    assert!(path.is_dir());
    let nowhere = directory.path().join("no/such/flash.toml");
    assert!(save_flash(arm.flash(), &nowhere).is_err());
}

#[cfg(unix)]
#[test]
fn a_file_behind_a_symlink_stays_there_and_is_its_owners() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let directory = tempfile::tempdir().unwrap();
    let (path, link) = (directory.path().join("real"), directory.path().join("link"));
    fs::write(&path, "").unwrap();
    symlink(&path, &link).unwrap();
    save_flash(Controller::default().flash(), &link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(load_flash(&path).unwrap().is_some());
    let mode = fs::metadata(&path).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
}
