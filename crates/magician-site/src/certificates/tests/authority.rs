//! Creation of a site, signing and revocation.

use std::fs;

use super::{Machines, files, request};
use crate::certificates::list::RevocationList;
use crate::certificates::x509::{read_authority, read_machine};
use crate::certificates::{Authority, CertificateError, Identity, is_machine_name, machine_of};

const ALL: [&str; 5] = ["ca.key", "ca.pem", "members.json", "own.key", "own.pem"];

fn has_name(error: &CertificateError) -> Option<&str> {
    match error {
        CertificateError::Taken(name) | CertificateError::Revoked(name) => Some(name),
        _ => None,
    }
}

#[test]
fn init_creates_a_site_once() {
    let machines = Machines::new();
    let folder = machines.folder("desk");
    assert!(Identity::open(&folder).unwrap().is_none());
    assert!(Authority::open(&folder).unwrap().is_none());
    let made = machines.init("desk");
    assert_eq!(files(&folder), ALL);
    let before = fs::read(folder.join("ca.key")).unwrap();
    let again = Authority::init(&folder, "lab", "desk").unwrap_err();
    assert!(matches!(again, CertificateError::Exists(_)), "{again}");
    assert_eq!(fs::read(folder.join("ca.key")).unwrap(), before);

    let opened = machines.authority("desk");
    let identity = machines.identity("desk");
    assert_eq!((opened.site(), identity.site()), ("lab", "lab"));
    assert_eq!(identity.machine(), "desk");
    assert_eq!(made.fingerprint(), opened.fingerprint());
    assert_eq!(made.fingerprint(), identity.fingerprint());
    assert_eq!(made.ends(), opened.ends());
    assert_eq!(identity.fingerprint().len(), 16 * 5 - 1);
    assert!(identity.revoked().is_empty() && !identity.is_revoked());
    let members = opened.members().unwrap();
    assert_eq!(members.len(), 1);
    assert_eq!((&*members[0].name, members[0].revoked), ("desk", None));
    assert_eq!(members[0].ends, identity.ends());
}

#[test]
fn certificates_have_their_validity_and_distinct_serials() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let signed = authority.sign(&request(), "bench-2").unwrap();
    let pem = signed.certificate.as_bytes();
    let der: tokio_rustls::rustls::pki_types::CertificateDer<'_> =
        tokio_rustls::rustls::pki_types::pem::PemObject::from_pem_slice(pem).unwrap();
    let details = read_machine(&der).unwrap();
    // 825 days of validity and one day of margin before them.
    assert_eq!(details.ends - details.begins, 826 * 86_400);
    assert_eq!(details.serial.len(), 16);
    assert_eq!(machine_of(&der).as_deref(), Some("bench-2"));
    assert!(authority.ends() - details.ends > 17 * 365 * 86_400);
    assert_eq!(read_authority(&der), None, "CA:FALSE");
    assert_eq!(machine_of(authority.certificate()), None);
    let (_, parsed) = x509_parser::parse_x509_certificate(&der).unwrap();
    let usage = parsed.extended_key_usage().unwrap().unwrap().value;
    assert!(usage.server_auth && usage.client_auth);
    assert!(!parsed.is_ca() && parsed.basic_constraints().unwrap().is_some());
}

#[test]
fn init_completes_after_a_kill_at_any_point() {
    for parts in 0..ALL.len() {
        let machines = Machines::new();
        machines.init("desk");
        let folder = machines.folder("desk");
        // Files in the order in which they are written.
        let written = ["ca.key", "ca.pem", "members.json", "own.key", "own.pem"];
        for missing in &written[parts..] {
            fs::remove_file(folder.join(missing)).unwrap();
        }
        assert!(Identity::open(&folder).unwrap().is_none(), "{parts}");
        assert!(Authority::open(&folder).unwrap().is_none(), "{parts}");
        machines.init("desk");
        assert_eq!(machines.identity("desk").machine(), "desk", "{parts}");
        machines.authority("desk").sign(&request(), "b").unwrap();
    }
}

#[test]
fn init_refuses_to_replace_an_authority_with_members() {
    let machines = Machines::new();
    machines.init("desk").sign(&request(), "bench-2").unwrap();
    let folder = machines.folder("desk");
    fs::remove_file(folder.join("own.pem")).unwrap();
    let before = fs::read(folder.join("ca.key")).unwrap();
    let refused = Authority::init(&folder, "lab", "desk").unwrap_err();
    assert!(matches!(
        refused,
        CertificateError::Incomplete(_, "own.pem")
    ));
    assert_eq!(fs::read(folder.join("ca.key")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn only_the_owner_reads_keys_and_folder() {
    use std::os::unix::fs::PermissionsExt;

    let machines = Machines::new();
    let folder = machines.folder("desk");
    fs::create_dir_all(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
    machines.init("desk");
    let mode = |path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(folder.clone()), 0o700);
    for file in ALL {
        assert_eq!(mode(folder.join(file)), 0o600, "{file}");
    }
}

#[test]
fn machine_names_are_valid_host_names() {
    for name in ["desk", "a", "bench-2", "pi_", "0xq", "7a", &"x".repeat(32)] {
        assert!(is_machine_name(name), "{name}");
    }
    let machines = Machines::new();
    let authority = machines.init("desk");
    for wrong in [
        "",
        "7",
        "42",
        "0x1f",
        "bench-",
        "-a",
        "Desk",
        "a.b",
        "a/b",
        "*",
        "ä",
        &"x".repeat(33),
    ] {
        assert!(!is_machine_name(wrong), "{wrong}");
        let refused = authority.sign(&request(), wrong).unwrap_err();
        assert!(matches!(refused, CertificateError::Name(_)), "{wrong}");
        let refused = Authority::init(&machines.folder("other"), "lab", wrong).unwrap_err();
        assert!(matches!(refused, CertificateError::Name(_)), "{wrong}");
        assert!(!machines.folder("other").exists(), "{wrong}");
    }
    let refused = Authority::init(&machines.folder("other"), "L/b", "desk").unwrap_err();
    assert!(matches!(refused, CertificateError::Name(_)));
}

#[test]
fn a_name_belongs_to_a_key() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = request();
    assert!(!authority.sign(&bench, "bench-2").unwrap().is_renewal);
    assert!(authority.sign(&bench, "bench-2").unwrap().is_renewal);
    for taken in ["bench-2", "desk"] {
        let refused = authority.sign(&request(), taken).unwrap_err();
        assert!(matches!(refused, CertificateError::Taken(_)), "{refused}");
        assert_eq!(has_name(&refused), Some(taken));
    }
    assert_eq!(authority.members().unwrap().len(), 2);
}

#[test]
fn name_and_key_of_a_revoked_machine_stay_refused() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = request();
    authority.sign(&bench, "bench-2").unwrap();
    authority.revoke("bench-2").unwrap();
    for (request, name) in [
        (&bench, "bench-2"),
        (&request(), "bench-2"),
        (&bench, "bench-3"),
    ] {
        let refused = authority.sign(request, name).unwrap_err();
        assert!(matches!(refused, CertificateError::Revoked(_)), "{refused}");
        assert_eq!(has_name(&refused), Some("bench-2"));
    }
    let members = authority.members().unwrap();
    assert_eq!(members.len(), 2);
    assert!(members[1].revoked.is_some());
}

#[test]
fn damaged_requests_are_refused_and_add_no_member() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let good = request();
    let body: Vec<_> = good.lines().collect();
    // Change the name after signing. The last line is part of the signature.
    let mut forged: Vec<_> = body.clone();
    let swapped = forged[1].replacen('M', "N", 1);
    forged[1] = &swapped;
    for wrong in [
        "",
        "no PEM",
        "-----BEGIN CERTIFICATE REQUEST-----\n-----END CERTIFICATE REQUEST-----\n",
        "-----BEGIN CERTIFICATE REQUEST-----\nAAAA\n-----END CERTIFICATE REQUEST-----\n",
        &good[..good.len() / 2],
        &forged.join("\n"),
        &good.replacen("CERTIFICATE REQUEST", "CERTIFICATE", 2)[..40],
    ] {
        let refused = authority.sign(wrong, "bench-2").unwrap_err();
        assert!(matches!(refused, CertificateError::Request), "{wrong}");
    }
    // A key of another kind than the site uses.
    let key = rcgen::KeyPair::generate_for(&rcgen::PKCS_ED25519).unwrap();
    let other = rcgen::CertificateParams::default().serialize_request(&key);
    let refused = authority.sign(&other.unwrap().pem().unwrap(), "bench-2");
    assert!(matches!(refused, Err(CertificateError::Request)));
    assert_eq!(authority.members().unwrap().len(), 1);
}

#[test]
fn each_revocation_increments_the_list_number_once() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    for name in ["bench-2", "bench-3"] {
        authority.sign(&request(), name).unwrap();
    }
    let first = authority.revoke("bench-2").unwrap();
    assert_eq!(authority.revoke("bench-2").unwrap(), first);
    let identity = machines.identity("desk");
    assert_eq!(identity.revoked(), first);
    let second = authority.revoke("bench-3").unwrap();
    assert_ne!(first, second);
    // Another process of this machine has written the newer list.
    assert_eq!(identity.revoked(), second);
    assert!(!identity.learn(&first).unwrap());

    let unknown = authority.revoke("bench-9").unwrap_err();
    assert!(matches!(unknown, CertificateError::Unknown(_)), "{unknown}");
    let own = authority.revoke("desk").unwrap_err();
    assert!(matches!(own, CertificateError::Own(_)), "{own}");
}

#[test]
fn revocation_completes_after_a_kill_before_the_list() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = request();
    authority.sign(&bench, "bench-2").unwrap();
    authority.revoke("bench-2").unwrap();
    fs::remove_file(machines.folder("desk").join("revoked.pem")).unwrap();
    let refused = authority.sign(&bench, "bench-2").unwrap_err();
    assert!(matches!(refused, CertificateError::Revoked(_)));
    assert!(machines.identity("desk").revoked().is_empty());
    let list = authority.revoke("bench-2").unwrap();
    assert_eq!(machines.identity("desk").revoked(), list);
}

#[test]
fn damaged_authority_is_refused() {
    for (file, content) in [
        ("ca.key", "no key"),
        ("ca.pem", "no certificate"),
        ("members.json", "{"),
    ] {
        let machines = Machines::new();
        machines.init("desk").sign(&request(), "bench-2").unwrap();
        let path = machines.folder("desk").join(file);
        fs::write(&path, content).unwrap();
        let opened = Authority::open(&machines.folder("desk"));
        let error = match opened {
            Ok(authority) => authority.unwrap().sign(&request(), "b").unwrap_err(),
            Err(error) => error,
        };
        assert!(error.to_string().contains(file), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
    }
    // A key that belongs to another authority.
    let (machines, others) = (Machines::new(), Machines::new());
    machines.init("desk");
    others.init("desk");
    let key = |machines: &Machines| machines.folder("desk").join("ca.key");
    fs::copy(key(&others), key(&machines)).unwrap();
    let error = Authority::open(&machines.folder("desk")).unwrap_err();
    assert!(error.to_string().contains("ca.key"), "{error}");
}

#[test]
fn list_of_a_restored_authority_is_newer_and_complete() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    for name in ["bench-2", "bench-3"] {
        authority.sign(&request(), name).unwrap();
    }
    let members = machines.folder("desk").join("members.json");
    let copy = fs::read(&members).unwrap();
    let read = |list: &[u8]| RevocationList::read(list, authority.certificate()).unwrap();
    let before = read(&authority.revoke("bench-2").unwrap());
    // The restored copy does not contain it, but the list has come back from other machines.
    fs::write(&members, copy).unwrap();
    let list = read(&authority.revoke("bench-3").unwrap());
    assert!(list.number > before.number);
    assert_eq!(list.serials.len(), 2);
    assert!(list.serials.is_superset(&before.serials));
    // Without the list, numbers must not start at 1 again: machines would refuse the new one.
    fs::remove_file(machines.folder("desk").join("revoked.pem")).unwrap();
    let begun = u64::try_from(authority.identity().unwrap().begins()).unwrap();
    let anew = read(&authority.revoke("bench-3").unwrap());
    assert!(anew.number > begun, "{}", anew.number);
}
