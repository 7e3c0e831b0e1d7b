//! Tests of atomic replacement: complete files, growing files, locks and leftovers.

use super::*;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a directory"))
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns names and contents, sorted.
    fn files(&self) -> Vec<(String, String)> {
        let entries = fs::read_dir(self.0.path()).expect("read");
        let mut files: Vec<_> = entries
            .map(|entry| {
                let entry = entry.expect("an entry");
                let text = fs::read_to_string(entry.path()).unwrap_or_default();
                (entry.file_name().to_string_lossy().into_owned(), text)
            })
            .collect();
        files.sort();
        files
    }
}

fn pair(name: &str, text: &str) -> (String, String) {
    (name.to_owned(), text.to_owned())
}

#[cfg(unix)]
#[test]
fn whole_file_keeps_its_mode_and_link_and_no_device_is_replaced() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let place = Place::new();
    let (path, link) = (place.at("a.svg"), place.at("b.svg"));
    write_whole(&path, b"one").expect("written");
    fs::set_permissions(&path, Permissions::from_mode(0o640)).expect("set");
    symlink("a.svg", &link).expect("linked");
    check_writable(&link).expect("it can be");
    write_whole(&link, b"two").expect("written again");
    replace(&link, "three").expect("written again");
    assert_eq!(fs::read(&path).expect("read"), b"three");
    let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode() & 0o777;
    assert_eq!(mode(&path), 0o640);
    assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    let device = Path::new("/dev/null");
    check_writable(device).expect("it can be");
    write_whole(device, b"gone").expect("written");
    assert!(!fs::metadata(device).expect("there").is_file());
    let nowhere = place.at("none/a.svg");
    assert!(check_writable(&nowhere).is_err() && write_whole(&nowhere, b"x").is_err());
    assert_eq!(place.files().len(), 2);
    let secret = place.at("secret");
    rewrite_private(&secret, "x").expect("written");
    assert_eq!(mode(&secret), 0o600);
}

#[cfg(unix)]
#[test]
fn dangling_link_leads_to_the_file_that_is_made() {
    use std::os::unix::fs::symlink;
    let place = Place::new();
    for (name, link) in [("a", "to-a"), ("b", "to-b"), ("c", "to-c")] {
        symlink(name, place.at(link)).expect("linked");
    }
    write_whole(&place.at("to-a"), b"1").expect("written");
    replace(&place.at("to-b"), "2").expect("written");
    let mut growing = WholeFile::grow(&place.at("to-c")).expect("begun");
    growing.write_all(b"3").expect("written");
    drop(growing);
    for (name, text) in [("a", "1"), ("b", "2"), ("c", "3")] {
        let link = fs::symlink_metadata(place.at(&format!("to-{name}")));
        assert!(link.expect("there").is_symlink());
        let file = fs::symlink_metadata(place.at(name)).expect("there");
        assert!(file.is_file());
        assert_eq!(fs::read_to_string(place.at(name)).expect("read"), text);
    }
    symlink("round", place.at("round")).expect("linked");
    assert!(write_whole(&place.at("round"), b"x").is_err());
    assert!(write_whole(place.0.path(), b"x").is_err());
}

#[test]
fn replaced_file_is_whole_and_its_directory_is_made() {
    let place = Place::new();
    let path = place.at("new/config.toml");
    replace(&path, "a = 1\n").expect("written");
    replace(&path, "a = 2\n").expect("written again");
    assert_eq!(fs::read_to_string(&path).expect("read"), "a = 2\n");
    let files = fs::read_dir(path.parent().expect("its place")).expect("read");
    assert_eq!(files.count(), 1);
}

#[test]
fn unfinished_file_leaves_the_old_one_and_nothing_beside_it() {
    let place = Place::new();
    for before in [vec![], vec![pair("a.svg", "old")]] {
        for (name, text) in &before {
            fs::write(place.at(name), text).expect("written");
        }
        let mut file = WholeFile::create(&place.at("a.svg")).expect("begun");
        file.write_all(b"half").expect("written");
        drop(file);
        assert_eq!(place.files(), before);
    }
}

#[test]
fn longest_name_can_be_written_and_recorded() {
    let place = Place::new();
    let name = "\u{e9}".repeat(127);
    for text in ["one", "two"] {
        write_whole(&place.at(&name), text.as_bytes()).expect("written");
        let mut growing = WholeFile::grow(&place.at(&name)).expect("begun");
        growing.write_all(b"grown").expect("written");
        drop(growing);
        assert_eq!(place.files(), [pair(&name, "grown")]);
    }
}

#[test]
fn new_file_grows_under_its_name_and_is_locked() {
    let place = Place::new();
    let path = place.at("a.csv");
    let mut first = WholeFile::grow(&path).expect("begun");
    first.write_all(b"one").expect("written");
    let error = WholeFile::grow(&path).expect_err("locked");
    assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
    assert_eq!(place.files(), [pair("a.csv", "one")]);
    first.finish().expect("finished");
    drop(WholeFile::grow(&path).expect("free"));
    // Nothing was written, so the old file is kept.
    assert_eq!(place.files(), [pair("a.csv", "one")]);
    drop(WholeFile::grow(&place.at("b.csv")).expect("begun"));
    assert_eq!(place.files(), [pair("a.csv", "one")]);
}

#[test]
fn file_that_is_there_stays_until_the_growing_one_is_whole() {
    let place = Place::new();
    let path = place.at("a.csv");
    fs::write(&path, "old").expect("written");
    let mut growing = WholeFile::grow(&path).expect("begun");
    growing.write_all(b"new").expect("written");
    let under_way = [pair("a.csv", "old"), pair("a.csv.partial", "new")];
    assert_eq!(place.files(), under_way);
    let error = WholeFile::grow(&path).expect_err("locked");
    assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
    assert_eq!(place.files(), under_way);
    drop(growing);
    assert_eq!(place.files(), [pair("a.csv", "new")]);
}

#[test]
fn part_that_a_killed_program_left_is_kept() {
    let place = Place::new();
    let path = place.at("a.csv");
    fs::write(&path, "old").expect("written");
    fs::write(place.at("a.csv.partial"), "killed").expect("written");
    let mut growing = WholeFile::grow(&path).expect("begun");
    growing.write_all(b"new").expect("written");
    assert_eq!(place.files()[2], pair("a.csv.partial2", "new"));
    growing.finish().expect("finished");
    let kept = [pair("a.csv", "new"), pair("a.csv.partial", "killed")];
    assert_eq!(place.files(), kept);
}

#[test]
fn shared_file_takes_its_name_only_when_its_owner_finishes_it() {
    let place = Place::new();
    let path = place.at("a.mcap");
    fs::write(&path, "old").expect("written");
    let mut growing = WholeFile::grow(&path).expect("begun");
    let mut writer = growing.writer();
    writer.write_all(b"new").expect("written");
    drop((writer, growing));
    let part = pair("a.mcap.partial", "new");
    assert_eq!(place.files(), [pair("a.mcap", "old"), part.clone()]);
    let mut growing = WholeFile::grow(&path).expect("begun");
    growing.writer().write_all(b"whole").expect("written");
    growing.finish().expect("finished");
    assert_eq!(place.files(), [pair("a.mcap", "whole"), part]);
}

#[test]
fn rewritten_file_is_locked_and_never_half_of_it() {
    let place = Place::new();
    for before in [false, true] {
        let path = place.at("a.plan.json");
        let mut growing = WholeFile::grow(&path).expect("begun");
        growing.rewrite(b"a long beginning").expect("written");
        growing.rewrite(b"end").expect("written");
        let at = if before {
            "a.plan.json.partial"
        } else {
            "a.plan.json"
        };
        assert!(place.files().contains(&pair(at, "end")));
        let error = WholeFile::grow(&path).expect_err("locked");
        assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
        growing.finish().expect("finished");
        assert_eq!(place.files(), [pair("a.plan.json", "end")]);
    }
}

#[test]
fn file_of_a_library_takes_its_name_with_its_first_bytes() {
    let place = Place::new();
    let path = place.at("a.pcapng");
    fs::write(&path, "old").expect("written");
    let mut growing = WholeFile::grow_in_place(&path).expect("begun");
    assert_eq!(fs::read_to_string(&path).expect("read"), "old");
    growing.write_all(b"new").expect("written");
    assert_eq!(place.files(), [pair("a.pcapng", "new")]);
    growing.write_all(b"er").expect("written");
    std::mem::forget(growing);
    assert_eq!(place.files(), [pair("a.pcapng", "newer")]);
}
