//! Identities of machines, and the lists that they learn.

use std::fs;

use super::Machines;
use crate::certificates::{CertificateError, Identity};

#[tokio::test]
async fn newer_list_is_shared_by_all_clones_and_stored() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    let clone = bench.clone();
    machines.join("desk", "bench-3").await;
    let first = authority.revoke("bench-3").unwrap();
    let second = authority.revoke("bench-2").unwrap();

    assert!(bench.learn(&first).unwrap());
    assert!(!bench.learn(&first).unwrap(), "no news");
    assert!(!clone.is_revoked());
    assert!(bench.learn(&second).unwrap());
    assert!(clone.is_revoked());
    assert!(!bench.learn(&first).unwrap(), "older");
    assert_eq!(clone.revoked(), second);
    let opened = machines.identity("bench-2");
    assert_eq!(opened.revoked(), second);
    assert!(opened.is_revoked());
}

#[tokio::test]
async fn lists_of_another_authority_are_refused() {
    let (machines, others) = (Machines::new(), Machines::new());
    let authority = machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    // Another site with the same names and a higher list number.
    let other = others.init("desk");
    others.join("desk", "bench-2").await;
    others.join("desk", "bench-3").await;
    other.revoke("bench-3").unwrap();
    let foreign = other.revoke("bench-2").unwrap();
    machines.join("desk", "bench-3").await;
    let list = authority.revoke("bench-3").unwrap();
    let mut longer = list.clone();
    longer.push(0);
    let mut changed = list.clone();
    // Change serial number or time of the revoked certificate, which the signature covers.
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    for wrong in [
        &b""[..],
        b"garbage",
        &list[..list.len() - 1],
        &longer,
        &changed,
        &foreign,
        &vec![0x30; 1_000_000],
    ] {
        let refused = bench.learn(wrong).unwrap_err();
        assert!(matches!(refused, CertificateError::List), "{refused}");
    }
    assert!(bench.revoked().is_empty());
    assert!(!machines.folder("bench-2").join("revoked.pem").exists());
    assert!(bench.learn(&list).unwrap());
}

/// Every changed bit is detected, and none makes the parser panic.
#[tokio::test]
async fn a_list_with_any_damaged_byte_is_refused() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    let list = authority.revoke("bench-2").unwrap();
    for at in 0..list.len() {
        let mut damaged = list.clone();
        damaged[at] ^= 0x81;
        assert!(bench.learn(&damaged).is_err(), "{at}");
    }
}

#[tokio::test]
async fn list_that_cannot_be_stored_still_applies() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    let list = authority.revoke("bench-2").unwrap();
    // A directory at the path of the file.
    fs::create_dir(machines.folder("bench-2").join("revoked.pem")).unwrap();
    assert!(bench.learn(&list).is_err());
    assert!(bench.is_revoked());
}

#[tokio::test]
async fn mismatched_files_are_no_identity() {
    let (machines, others) = (Machines::new(), Machines::new());
    machines.init("desk");
    machines.join("desk", "bench-2").await;
    machines.join("desk", "bench-3").await;
    others.init("desk");
    let folder = machines.folder("bench-2");
    let good = |file: &str| fs::read(folder.join(file)).unwrap();
    let foreign = |file: &str| fs::read(others.folder("desk").join(file)).unwrap();
    let colleague = |file: &str| fs::read(machines.folder("bench-3").join(file)).unwrap();
    for (file, content) in [
        ("own.key", colleague("own.key")),
        ("own.pem", colleague("own.pem")),
        ("ca.pem", foreign("ca.pem")),
        ("own.pem", foreign("own.pem")),
        ("own.pem", good("ca.pem")),
        ("ca.pem", good("own.pem")),
        ("own.pem", b"garbage".to_vec()),
        ("own.key", good("own.pem")),
        ("revoked.pem", b"garbage".to_vec()),
        ("revoked.pem", good("own.pem")),
    ] {
        let before = fs::read(folder.join(file)).ok();
        fs::write(folder.join(file), content).unwrap();
        let opened = Identity::open(&folder);
        assert!(opened.is_err(), "{file}: {opened:?}");
        match before {
            Some(before) => fs::write(folder.join(file), before).unwrap(),
            None => fs::remove_file(folder.join(file)).unwrap(),
        }
        assert!(Identity::open(&folder).unwrap().is_some());
    }
    for file in ["ca.pem", "own.key"] {
        let before = good(file);
        fs::remove_file(folder.join(file)).unwrap();
        let error = Identity::open(&folder).unwrap_err();
        assert!(error.to_string().contains(file), "{error}");
        fs::write(folder.join(file), before).unwrap();
    }
}
