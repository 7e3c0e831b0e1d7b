//! Joining: refusals, and secrets that must not leave a machine.

use std::fs;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio::net::TcpListener;
use tokio::time::Instant;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::pki_types::ServerName;

use super::{Machines, PIPE, acceptor, files, request};
use crate::certificates::wire::{self, Answer, MAX_ANSWER_SIZE, MAX_REQUEST_SIZE, Request};
use crate::certificates::{
    Identity, Invitation, InvitationEnd, InvitationEvent, JoinError, Refusal, join, tls,
};

fn refusal(result: Result<impl std::fmt::Debug, JoinError>) -> Refusal {
    match result.unwrap_err() {
        JoinError::Refused(refusal) => refusal,
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn joining_does_not_send_the_private_key() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    assert_eq!((bench.site(), bench.machine()), ("lab", "bench-2"));
    assert_eq!(bench.fingerprint(), authority.fingerprint());
    let folder = machines.folder("bench-2");
    assert_eq!(files(&folder), ["ca.pem", "own.key", "own.pem"]);
    assert_eq!(bench.key_file(), folder.join("own.key"));
    assert_eq!(machines.identity("bench-2").machine(), "bench-2");
    #[cfg(unix)]
    for (path, mode) in [(folder.clone(), 0o700), (folder.join("own.key"), 0o600)] {
        use std::os::unix::fs::PermissionsExt;
        let permissions = fs::metadata(path).unwrap().permissions();
        assert_eq!(permissions.mode() & 0o777, mode);
    }
    let key = fs::read_to_string(bench.key_file()).unwrap();
    for file in files(&machines.folder("desk")) {
        let kept = fs::read_to_string(machines.folder("desk").join(&file)).unwrap();
        assert!(!kept.contains(key.lines().nth(1).unwrap()), "{file}");
    }
    let members = authority.members().unwrap();
    assert_eq!(members.len(), 2);
    assert_eq!(members[1].name, "bench-2");
    assert_eq!(members[1].ends, bench.ends());
}

#[tokio::test]
async fn joining_machine_gets_the_revocation_list() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    machines.join("desk", "bench-2").await;
    let list = authority.revoke("bench-2").unwrap();
    let bench = machines.join("desk", "bench-3").await;
    assert_eq!(bench.revoked(), list);
    assert_eq!(machines.identity("bench-3").revoked(), list);
}

#[tokio::test]
async fn the_same_name_from_the_same_machine_is_a_renewal() {
    let machines = Machines::new();
    machines.init("desk");
    let before = machines.join("desk", "bench-2").await;
    let certificate = fs::read(before.certificate_file()).unwrap();
    let key = fs::read(before.key_file()).unwrap();
    let invitation = machines.invite("desk", 1);
    let (joined, event) = machines.try_join(&invitation, "bench-2", "bench-2").await;
    assert!(joined.unwrap().is_renewal);
    assert!(matches!(
        event,
        Some(InvitationEvent::Joined {
            is_renewal: true,
            ..
        })
    ));
    assert_ne!(fs::read(before.certificate_file()).unwrap(), certificate);
    assert_eq!(fs::read(before.key_file()).unwrap(), key);
    // The authority's own machine may renew, too.
    let desk = machines.join("desk", "desk").await;
    assert_eq!(desk.machine(), "desk");
    machines.authority("desk");
}

#[tokio::test]
async fn member_cannot_join_under_another_name() {
    let machines = Machines::new();
    machines.init("desk");
    machines.join("desk", "bench-2").await;
    let invitation = machines.invite("desk", 1);
    let (refused, event) = machines.try_join(&invitation, "bench-2", "bench-3").await;
    let refused = refused.unwrap_err();
    assert!(
        matches!(&refused, JoinError::OtherName(name, _) if name == "bench-2"),
        "{refused:?}"
    );
    assert!(event.is_none(), "nothing was sent");
}

#[tokio::test]
async fn join_is_repeatable_after_a_lost_answer() {
    let machines = Machines::new();
    machines.init("desk");
    machines.join("desk", "bench-2").await;
    let folder = machines.folder("bench-2");
    // State after a kill: before the certificate was written, and before anything but the key.
    for lost in [&["own.pem"][..], &["own.pem", "ca.pem"]] {
        for file in lost {
            fs::remove_file(folder.join(file)).unwrap();
        }
        assert!(Identity::open(&folder).unwrap().is_none());
        let bench = machines.join("desk", "bench-2").await;
        assert_eq!(bench.machine(), "bench-2");
    }
}

#[tokio::test]
async fn taken_revoked_and_impossible_names_are_refused() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    machines.join("desk", "bench-2").await;
    machines.join("desk", "bench-3").await;
    authority.revoke("bench-3").unwrap();
    let invitation = machines.invite("desk", 1);
    for (name, expected) in [
        ("bench-2", Refusal::Taken),
        ("desk", Refusal::Taken),
        ("bench-3", Refusal::Revoked),
        ("Bench 4", Refusal::Name),
        ("", Refusal::Name),
    ] {
        let (refused, event) = machines.try_join(&invitation, "bench-4", name).await;
        assert_eq!(refusal(refused), expected, "{name}");
        let Some(InvitationEvent::Refused {
            name: told,
            refusal,
            error: None,
        }) = event
        else {
            panic!("{event:?}");
        };
        assert_eq!((&*told, refusal), (name, expected));
    }
    // A revoked machine that uses its own key.
    let (refused, _) = machines.try_join(&invitation, "bench-3", "bench-3").await;
    assert_eq!(refusal(refused), Refusal::Revoked);
    assert_eq!(invitation.joined(), 0);
    // The code is still valid after all these attempts.
    let (joined, _) = machines.try_join(&invitation, "bench-4", "bench-4").await;
    assert_eq!(joined.unwrap().identity.machine(), "bench-4");
}

/// Another authority takes the place of the authority that made the code. It learns nothing.
#[tokio::test]
async fn impostor_receives_no_request() {
    let (machines, others) = (Machines::new(), Machines::new());
    machines.init("desk");
    others.init("desk");
    let code = machines.invite("desk", 1).code("authority:1");
    let impostor = others.invite("desk", 1);
    let acceptor = acceptor(&impostor);
    let (here, there) = duplex(PIPE);
    let sites = machines.sites("bench-2");
    let joining = super::join_over(here, &code, &sites, None, "bench-2");
    let listening = async {
        let mut heard = Vec::new();
        // The handshake fails, or succeeds without any data after it.
        if let Ok(mut stream) = acceptor.accept(there).await {
            let _ = stream.read_to_end(&mut heard).await;
        }
        heard
    };
    let (refused, heard) = tokio::join!(joining, listening);
    assert!(
        matches!(refused, Err(JoinError::WrongAuthority(_))),
        "{refused:?}"
    );
    assert_eq!(heard, b"");
    assert!(!sites.exists(), "no key was made");
}

/// A machine of the site, revoked or not, cannot pose as its authority.
#[tokio::test]
async fn a_machine_of_the_site_is_not_its_authority() {
    let machines = Machines::new();
    machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    let code = machines.invite("desk", 1).code("authority:1");
    let pem = |file| fs::read(machines.folder("bench-2").join(file)).unwrap();
    use tokio_rustls::rustls::pki_types::pem::PemObject;
    let key = tokio_rustls::rustls::pki_types::PrivateKeyDer::from_pem_slice(&pem("own.key"));
    // The authority's certificate with the machine's own key: TLS refuses this pair.
    let forged = tls::invitation_server((bench.authority().clone(), key.unwrap().clone_key()));
    assert!(forged.is_err());
    let key = tokio_rustls::rustls::pki_types::PrivateKeyDer::from_pem_slice(&pem("own.key"));
    let own = tokio_rustls::rustls::pki_types::CertificateDer::from_pem_slice(&pem("own.pem"));
    let posing = tls::invitation_server((own.unwrap(), key.unwrap())).unwrap();
    let (here, there) = duplex(PIPE);
    let sites = machines.sites("bench-3");
    let joining = super::join_over(here, &code, &sites, None, "bench-3");
    let accepting = tokio_rustls::TlsAcceptor::from(Arc::new(posing));
    let (refused, accepted) = tokio::join!(joining, accepting.accept(there));
    assert!(
        matches!(refused, Err(JoinError::WrongAuthority(_))),
        "{refused:?}"
    );
    assert!(accepted.is_err());
}

/// Sends a request with this secret, as a program that knows the authority but not the secret.
async fn guess(invitation: &Invitation, secret: &str) -> Refusal {
    let ask = Request {
        secret: secret.to_owned(),
        name: "bench-2".to_owned(),
        request: request(),
    };
    let talk = async |mut stream: TlsStream<_>| {
        wire::write(&mut stream, &ask).await.unwrap();
        wire::read(&mut stream, MAX_ANSWER_SIZE).await.unwrap()
    };
    match stranger(invitation, talk).await.0 {
        Answer::Refused(refusal) => refusal,
        other @ Answer::Joined { .. } => panic!("{other:?}"),
    }
}

/// Connects to an invitation, runs `talk`, and returns its result with the event of the invitation.
async fn stranger<T>(
    invitation: &Invitation,
    talk: impl AsyncFnOnce(TlsStream<tokio::io::DuplexStream>) -> T,
) -> (T, Option<InvitationEvent>) {
    let (here, there) = duplex(PIPE);
    let config = tls::joining_client(invitation.code("a:1")).unwrap();
    let talking = async {
        let name = ServerName::try_from("a").unwrap();
        let connector = TlsConnector::from(Arc::new(config));
        talk(connector.connect(name, here).await.unwrap()).await
    };
    let acceptor = acceptor(invitation);
    tokio::join!(
        talking,
        invitation.answer(&acceptor, there, std::future::pending())
    )
}

#[tokio::test]
async fn a_wrong_secret_is_refused_and_the_third_voids_the_code() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let invitation = machines.invite("desk", 1);
    let secret = invitation.code("a:1").secret().to_owned();
    let longer = secret.clone() + "0";
    for wrong in ["", &secret[1..], &longer] {
        assert_eq!(invitation.end(), None);
        assert_eq!(guess(&invitation, wrong).await, Refusal::Secret);
    }
    assert_eq!(invitation.end(), Some(InvitationEnd::Void));
    // Too late: the code is void even with the right secret.
    assert_eq!(guess(&invitation, &secret).await, Refusal::Over);
    let (refused, _) = machines.try_join(&invitation, "bench-2", "bench-2").await;
    assert_eq!(refusal(refused), Refusal::Over);
    assert_eq!(authority.members().unwrap().len(), 1);
}

#[tokio::test]
async fn code_admits_its_number_of_machines_only() {
    let machines = Machines::new();
    machines.init("desk");
    let invitation = machines.invite("desk", 2);
    for name in ["bench-2", "bench-2", "bench-3"] {
        assert_eq!(invitation.end(), None, "{name}");
        let (joined, _) = machines.try_join(&invitation, name, name).await;
        joined.unwrap();
    }
    assert_eq!(invitation.end(), Some(InvitationEnd::Full));
    let (refused, _) = machines.try_join(&invitation, "bench-4", "bench-4").await;
    assert_eq!(refusal(refused), Refusal::Over);
    assert_eq!(machines.authority("desk").members().unwrap().len(), 3);
}

/// The number of certificates is bounded: revoking a machine lists all of them, and the size of the
/// list is bounded.
#[tokio::test]
async fn certificates_per_machine_are_bounded_for_an_invitation() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let invitation = machines.invite("desk", 2);
    let ask = async || machines.try_join(&invitation, "bench-2", "bench-2").await.0;
    for _ in 0..8 {
        assert_eq!(ask().await.unwrap().identity.machine(), "bench-2");
    }
    assert_eq!(refusal(ask().await), Refusal::Over);
    assert_eq!(invitation.end(), None);
    let (other, _) = machines.try_join(&invitation, "bench-3", "bench-3").await;
    assert_eq!(other.unwrap().identity.machine(), "bench-3");
    authority.revoke("bench-2").unwrap();
}

#[tokio::test]
async fn code_of_an_earlier_invitation_is_refused() {
    let machines = Machines::new();
    machines.init("desk");
    let earlier = machines.invite("desk", 1).code("authority:1");
    let invitation = machines.invite("desk", 1);
    // The right authority, but the secret of an earlier invitation: it counts as a wrong guess.
    let (refused, _) = machines.try_code(&invitation, &earlier, "b", "b").await;
    assert_eq!(refusal(refused), Refusal::Secret);
}

#[tokio::test]
async fn invalid_requests_get_no_answer_and_change_nothing() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let invitation = machines.invite("desk", 1);
    let secret = invitation.code("a:1").secret().to_owned();
    let ask = Request {
        secret,
        name: "bench-2".to_owned(),
        request: request(),
    };
    let good = serde_json::to_vec(&ask).unwrap();
    let length = u32::try_from(good.len()).unwrap();
    let with = |length: u32, body: &[u8]| [&length.to_be_bytes(), body].concat();
    for (what, bytes) in [
        ("nothing", Vec::new()),
        ("half a length", vec![0, 0]),
        ("truncated", with(length, &good[..good.len() - 1])),
        ("cut", with(length - 1, &good[..good.len() - 1])),
        ("huge", with(u32::MAX, &good)),
        ("too large", with(MAX_REQUEST_SIZE + 1, &good)),
        ("no JSON", with(4, b"\xff\xfe{}")),
        ("other JSON", with(2, b"[]")),
        ("HTTP", b"GET / HTTP/1.1\r\n\r\n".to_vec()),
        ("deep", with(8000, &[b'['; 8000])),
    ] {
        let (heard, event) = stranger(&invitation, async |mut stream| {
            stream.write_all(&bytes).await.unwrap();
            let _ = stream.shutdown().await;
            let mut heard = Vec::new();
            let _ = stream.read_to_end(&mut heard).await;
            heard
        })
        .await;
        assert_eq!(heard, b"", "{what}");
        assert!(event.is_none(), "{what}: {event:?}");
    }
    assert_eq!(authority.members().unwrap().len(), 1);
    // No TLS at all.
    let (mut here, there) = duplex(PIPE);
    here.write_all(b"GET / HTTP/1.1\r\n\r\n").await.unwrap();
    let acceptor = acceptor(&invitation);
    assert!(
        invitation
            .answer(&acceptor, there, std::future::pending())
            .await
            .is_none()
    );
    let (joined, _) = machines.try_join(&invitation, "bench-2", "bench-2").await;
    joined.unwrap();
}

#[tokio::test(start_paused = true)]
async fn silent_client_times_out_before_and_after_the_handshake() {
    let machines = Machines::new();
    machines.init("desk");
    let invitation = machines.invite("desk", 1);
    let begun = Instant::now();
    let (_here, there) = duplex(PIPE);
    let acceptor = acceptor(&invitation);
    assert!(
        invitation
            .answer(&acceptor, there, std::future::pending())
            .await
            .is_none()
    );
    assert_eq!(begun.elapsed().as_secs(), 10);
    let begun = Instant::now();
    let (heard, event) = stranger(&invitation, async |mut stream| stream.read_u8().await).await;
    assert!(heard.is_err() && event.is_none());
    assert_eq!(begun.elapsed().as_secs(), 10);
}

#[tokio::test(start_paused = true)]
async fn join_times_out_at_a_silent_invitation() {
    let machines = Machines::new();
    machines.init("desk");
    // A listener that accepts the connection and never answers.
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let code = machines.invite("desk", 1).code(&address);
    let refused = join(&code, &machines.sites("b"), None, "b").await;
    assert!(matches!(refused, Err(JoinError::Silent(_))), "{refused:?}");
}

#[tokio::test(start_paused = true)]
async fn a_code_expires() {
    let machines = Machines::new();
    machines.init("desk");
    let invitation = Arc::new(machines.invite("desk", 1));
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let code = invitation.code(&address);
    let until = Instant::now() + Duration::from_secs(600);
    let ended = invitation
        .run(listener, until, |event| panic!("{event:?}"))
        .await;
    assert_eq!(ended.unwrap(), InvitationEnd::Expired);
    assert_eq!(Instant::now(), until);
    let refused = join(&code, &machines.sites("b"), None, "b").await;
    assert!(
        matches!(refused, Err(JoinError::Connection(..))),
        "{refused:?}"
    );
}

/// Over real sockets, with more machines than were invited at once, and silent connections among
/// them.
#[tokio::test]
async fn an_invitation_ends_when_all_have_joined() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let invitation = Arc::new(machines.invite("desk", 3));
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let code = invitation.code(&address);
    let mut silent = Vec::new();
    // More than may be silent at once, and fewer than fit the system's backlog.
    for _ in 0..120 {
        silent.push(tokio::net::TcpStream::connect(&address).await.unwrap());
    }
    let until = Instant::now() + Duration::from_secs(600);
    let mut names = Vec::new();
    let running = invitation.run(listener, until, |event| match event {
        InvitationEvent::Joined { name, .. } => names.push(name),
        InvitationEvent::Refused { .. } => {}
    });
    let place = |machine| (code.clone(), machines.sites(machine), machine);
    let joining = ["b1", "b2", "b3", "b4"]
        .map(place)
        .map(async |(code, sites, name)| join(&code, &sites, None, name).await.is_ok());
    let [b1, b2, b3, b4] = joining;
    let (ended, b1, b2, b3, b4) = tokio::join!(running, b1, b2, b3, b4);
    assert_eq!(ended.unwrap(), InvitationEnd::Full);
    let joined = [b1, b2, b3, b4]
        .into_iter()
        .filter(|joined| *joined)
        .count();
    assert_eq!((joined, names.len()), (3, 3));
    assert_eq!(authority.members().unwrap().len(), 4);
}

#[tokio::test]
async fn existing_site_of_the_same_name_is_not_overwritten() {
    let (machines, others) = (Machines::new(), Machines::new());
    machines.init("desk");
    machines.join("desk", "bench-2").await;
    others.init("desk");
    let invitation = others.invite("desk", 2);
    let code = invitation.code("authority:1");
    let before = fs::read(machines.folder("bench-2").join("own.pem")).unwrap();
    for machine in ["bench-2", "desk"] {
        let (here, there) = duplex(PIPE);
        let sites = machines.sites(machine);
        let acceptor = acceptor(&invitation);
        let joining = super::join_over(here, &code, &sites, None, machine);
        let (refused, event) = tokio::join!(
            joining,
            invitation.answer(&acceptor, there, std::future::pending())
        );
        assert!(matches!(refused, Err(JoinError::Other(_))), "{refused:?}");
        assert!(event.is_none(), "{event:?}");
    }
    // An unfinished authority.
    let begun = machines.folder("new");
    fs::create_dir_all(&begun).unwrap();
    fs::write(begun.join("ca.key"), "any").unwrap();
    let (refused, _) = machines.try_join(&invitation, "new", "new").await;
    assert!(matches!(refused, Err(JoinError::Other(_))), "{refused:?}");
    let after = fs::read(machines.folder("bench-2").join("own.pem")).unwrap();
    assert_eq!(before, after);
}

/// Replies that break the rules are refused, even from the right authority.
#[tokio::test]
async fn invalid_answers_are_not_stored() {
    let machines = Machines::new();
    let authority = machines.init("desk");
    let invitation = machines.invite("desk", 1);
    let code = invitation.code("authority:1");
    let bench_3 = authority.sign(&request(), "bench-3").unwrap().certificate;
    for (what, certificate, revoked) in [
        ("of another key", bench_3.clone(), String::new()),
        ("no certificate", "garbage".to_owned(), String::new()),
        ("no list", bench_3, "garbage".to_owned()),
    ] {
        let answer = Answer::Joined {
            certificate,
            revoked,
        };
        let (here, there) = duplex(PIPE);
        let sites = machines.sites("bench-3");
        let joining = super::join_over(here, &code, &sites, None, "bench-3");
        let acceptor = acceptor(&invitation);
        let answering = async {
            let mut stream = acceptor.accept(there).await.unwrap();
            let _: Request = wire::read(&mut stream, MAX_REQUEST_SIZE).await.unwrap();
            wire::write(&mut stream, &answer).await.unwrap();
        };
        let (refused, ()) = tokio::join!(joining, answering);
        assert!(refused.is_err(), "{what}");
        assert_eq!(files(&machines.folder("bench-3")), ["own.key"], "{what}");
    }
}
