//! A stranger on the network: the declarations it can make, the data it gets, and the harm it can
//! do.
//!
//! On a site with certificates it cannot connect. On a site without certificates it sees presence
//! and states, and the arms that it announces are shown as unproved.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use magician_site::carrier::ZenohSite;
use magician_site::certificates::{Authority, Identity};
use magician_site::{ArmAt, Site, SiteError, StationId};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use zenoh::query::Query;
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};

use crate::bench::{BENCH, Lab, OneArm, answers, free_port, request, wait_for_arm, wait_until};

const GHOST: StationId = StationId(0xbad);

fn ghost() -> ArmAt {
    ArmAt {
        arm: "ghost".to_owned(),
        station: GHOST,
    }
}

/// Everything that a stranger receives, as `key: payload`.
type ReceivedLog = Arc<Mutex<Vec<String>>>;

struct Stranger {
    _session: Session,
    heard: ReceivedLog,
    /// Declarations, which last as long as this value.
    _declared: Vec<Box<dyn Send>>,
}

impl Stranger {
    /// Subscribes to all keys, replies to every query with lies, and publishes lies: the arm
    /// `ghost`, another state of the arm `a`, and a roster without either.
    async fn start(config: &Path, lying_listener: std::net::SocketAddr) -> Self {
        let session = zenoh::open(Config::from_file(config).unwrap())
            .await
            .unwrap();
        let heard = ReceivedLog::default();
        let mut declared: Vec<Box<dyn Send>> = Vec::new();
        let hears = Arc::clone(&heard);
        let listen = move |sample: Sample| {
            let text = String::from_utf8_lossy(&sample.payload().to_bytes()).into_owned();
            let mut heard = hears.lock().unwrap();
            heard.push(format!("{}: {text}", sample.key_expr()));
            if let Some(attachment) = sample.attachment() {
                heard.push(format!("attachment {:?}", attachment.to_bytes()));
            }
        };
        let subscriber = session.declare_subscriber("magician/**").callback(listen);
        declared.push(Box::new(subscriber.await.unwrap()));
        let hears = Arc::clone(&heard);
        let lie = move |query: Query| {
            let asked = query.payload().map(|bytes| bytes.to_bytes().into_owned());
            let with = query
                .attachment()
                .map(|bytes| bytes.to_bytes().into_owned());
            hears
                .lock()
                .unwrap()
                .push(format!("asked {}: {asked:?} {with:?}", query.key_expr()));
            std::thread::spawn(move || {
                let said = r#"{"result": {"arms": [{"arm": "a", "stood": true}]}}"#;
                let _ = query.reply(query.key_expr().clone(), said).wait();
            });
        };
        let queryable = session.declare_queryable("magician/lab/**").callback(lie);
        declared.push(Box::new(queryable.await.unwrap()));
        // Two rosters: the first hides an arm, the second adds one.
        for (machine, said) in [
            ("liar-1", r#"{"arms": []}"#),
            ("liar-2", r#"{"arms": [{"arm": "phantom"}]}"#),
        ] {
            let key = format!("magician/lab/{machine}/roster");
            let roster = session.declare_queryable(key);
            let roster = roster.callback(move |query: Query| {
                std::thread::spawn(move || {
                    let _ = query.reply(query.key_expr().clone(), said).wait();
                });
            });
            declared.push(Box::new(roster.await.unwrap()));
        }
        let ghost = format!("magician/lab/{BENCH}/alive/ghost/{GHOST}");
        let token = session.liveliness().declare_token(ghost).await.unwrap();
        declared.push(Box::new(token));
        let state = json!({"station": GHOST.to_string(), "at": [lying_listener], "port": "sim",
            "virtual": true, "state": {"link": "up", "moving": false}});
        let key = format!("magician/lab/{BENCH}/state/ghost");
        let state = state.to_string();
        let publisher = session.declare_publisher(key.clone()).await.unwrap();
        publisher.put(state.clone()).await.unwrap();
        declared.push(Box::new(publisher));
        // Queried by hubs that join later or whose link comes up later.
        let queryable = session.declare_queryable(key);
        let queryable = queryable.callback(move |query: Query| {
            let state = state.clone();
            std::thread::spawn(move || {
                let _ = query.reply(query.key_expr().clone(), state).wait();
            });
        });
        declared.push(Box::new(queryable.await.unwrap()));
        Self {
            _session: session,
            heard,
            _declared: declared,
        }
    }

    fn heard(&self) -> Vec<String> {
        self.heard.lock().unwrap().clone()
    }
}

/// Listener of the stranger, with the bytes that it received.
async fn lying_listener() -> (std::net::SocketAddr, Arc<Mutex<Vec<u8>>>) {
    use tokio::io::AsyncReadExt;
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let at = listener.local_addr().unwrap();
    let received = Arc::new(Mutex::new(Vec::new()));
    let received_here = Arc::clone(&received);
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut bytes = [0; 4096];
            if let Ok(count) = stream.read(&mut bytes).await {
                received_here.lock().unwrap().extend(&bytes[..count]);
            }
        }
    });
    (at, received)
}

/// Zenoh configuration of a stranger without a certificate.
fn plain_config(lab: &Lab, connects: u16) -> PathBuf {
    let config = json!({
        "listen": {"endpoints": ["tcp/127.0.0.1:0"]},
        "connect": {"endpoints": [format!("tcp/127.0.0.1:{connects}")]},
        "scouting": {"multicast": {"enabled": false}},
    });
    let path = lab.folder.path().join("stranger.json5");
    std::fs::write(&path, config.to_string()).unwrap();
    path
}

/// Zenoh configuration of a stranger with a certificate, of this site or of another authority.
fn tls_config(lab: &Lab, identity: &Identity, connects: u16) -> PathBuf {
    let (key, certificate) = (identity.key_file(), identity.certificate_file());
    let config = json!({
        "listen": {"endpoints": ["tls/127.0.0.1:0"]},
        "connect": {"endpoints": [format!("tls/127.0.0.1:{connects}")], "exit_on_failure": false},
        "scouting": {"multicast": {"enabled": false}},
        "transport": {"link": {"tls": {
            "root_ca_certificate": identity.authority_file(), "enable_mtls": true,
            "connect_private_key": key, "connect_certificate": certificate,
            "listen_private_key": key, "listen_certificate": certificate,
            "verify_name_on_connect": false,
        }}},
    });
    let path = lab.folder.path().join("stranger-tls.json5");
    std::fs::write(&path, config.to_string()).unwrap();
    path
}

/// Makes the requests of a teacher, with a token: everything that a stranger would like to
/// intercept.
async fn request_as_teacher(
    site: &ZenohSite,
    at: &ArmAt,
    lab: &Lab,
) -> Vec<Result<Option<String>, SiteError>> {
    let teacher = lab.teacher();
    let class =
        json!({"text": "[[pupil]]\nname = \"Ada\"\ncode = \"SECRET\"\n", "use_codes": true});
    let mut answers = Vec::new();
    for (method, params) in [
        ("class.set", class),
        ("arm.stop", json!({})),
        ("site.expect", json!({"arms": [{"arm": "a"}, {"arm": "b"}]})),
    ] {
        answers.push(site.call(at, &teacher, request(method, &params)).await);
    }
    answers
}

#[tokio::test(flavor = "multi_thread")]
async fn without_certificates_a_stranger_gets_presence_and_states_but_no_requests() {
    let lab = Lab::without_certificates();
    let port = free_port();
    let (_station, _node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let (at_liar, received) = lying_listener().await;
    let stranger = Stranger::start(&plain_config(&lab, port), at_liar).await;
    let site = lab.site(&[port]).await;
    assert!(!site.is_proved());
    let mut events = site.watch();
    let (at, _) = wait_for_arm(&mut events, "a").await;
    let ghost = ghost();
    wait_until(async || site.arms().contains_key(&ghost)).await;
    // Nothing is sent to any station, because none has proved its identity.
    for at in [&at, &ghost] {
        let answers = request_as_teacher(&site, at, &lab).await;
        assert!(
            answers
                .iter()
                .all(|answer| matches!(answer, Err(SiteError::Unproved(_)))),
            "{answers:?}"
        );
        assert!(matches!(
            site.open(at.station).await,
            Err(SiteError::Unproved(_))
        ));
    }
    assert!(received.lock().unwrap().is_empty());
    // A forged roster can add a name but not remove one.
    wait_until(async || site.roster().await.has("phantom")).await;
    for heard in stranger.heard() {
        let key = heard.split(": ").next().unwrap_or_default();
        let is_open = ["state/", "alive/", "/roster", "/revoked"]
            .iter()
            .any(|one| key.contains(one));
        assert!(is_open, "{heard}");
        assert!(
            !heard.contains(&lab.token) && !heard.contains("SECRET"),
            "{heard}"
        );
        assert!(!heard.contains("attachment"), "{heard}");
    }
    let states = stranger
        .heard()
        .iter()
        .filter(|heard| heard.contains("/state/a: "))
        .count();
    assert!(states > 0, "it may look");
}

#[tokio::test(flavor = "multi_thread")]
async fn with_certificates_a_stranger_receives_nothing_and_is_not_listed() {
    let OneArm {
        lab,
        station: _station,
        node,
        port,
        site,
        at,
        ..
    } = OneArm::new().await;
    let (at_liar, _) = lying_listener().await;

    // First without a certificate, then with one of a forged authority.
    let plain = plain_config(&lab, port);
    let forged = Authority::init(&lab.folder.path().join("forged"), "lab", "bench-2").unwrap();
    let forged = forged.identity().unwrap();
    let with_forged = tls_config(&lab, &forged, port);
    let strangers = [
        Stranger::start(&plain, at_liar).await,
        Stranger::start(&with_forged, at_liar).await,
    ];
    for answer in request_as_teacher(&site, &at, &lab).await {
        assert!(
            answer.as_ref().is_ok_and(|text| text
                .as_ref()
                .is_some_and(|text| text.contains("\"result\""))),
            "{answer:?}"
        );
    }
    assert!(
        site.arms().keys().all(|at| at.arm == "a"),
        "{:?}",
        site.arms()
    );
    assert!(!site.roster().await.has("phantom"));
    for stranger in &strangers {
        // The stranger hears only its own lies.
        let own = |heard: &String| heard.contains("/ghost: ");
        assert!(stranger.heard().iter().all(own), "{:?}", stranger.heard());
    }

    // At the station's own listener: TLS fails without a certificate, so no request gets through.
    let at_api = node
        .addresses()
        .into_iter()
        .find(|at| at.ip().is_loopback())
        .unwrap();
    let dial =
        magician_station::client::StationDial::new(BENCH, vec![at_api], forged.client().unwrap());
    let refused = dial
        .post(Some(&lab.token), request("arm.stop", &json!({})))
        .await;
    assert!(refused.is_err(), "{refused:?}");
    let anonymous = plain_request(at_api).await;
    assert!(!anonymous.starts_with("HTTP"), "{anonymous}");
}

/// Sends a request without TLS and returns the reply.
async fn plain_request(at: std::net::SocketAddr) -> String {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = tokio::net::TcpStream::connect(at).await.unwrap();
    let request = format!("GET /healthz HTTP/1.1\r\nHost: {BENCH}\r\n\r\n");
    let _ = stream.write_all(request.as_bytes()).await;
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes).await;
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A machine with a valid certificate announces another machine's station at its own address. It
/// cannot show the certificate of that machine, so it is sent nothing.
#[tokio::test(flavor = "multi_thread")]
async fn announced_address_is_only_a_hint() {
    let OneArm {
        lab,
        station: _station,
        node: _node,
        port,
        site,
        at,
        ..
    } = OneArm::new().await;
    let thief = lab.machine("thief").await;
    let (at_liar, received) = lying_listener().await;
    let config = tls_config(&lab, &thief, port);
    let _stranger = Stranger::start(&config, at_liar).await;
    let ghost = ghost();
    wait_until(async || matches!(site.arms().get(&ghost), Some(Some(_)))).await;
    let stolen = site
        .call(&ghost, &lab.teacher(), request("arm.stop", &json!({})))
        .await;
    assert!(stolen.is_err(), "{stolen:?}");
    // The stranger gets at most a TLS greeting, which contains no secret.
    let sent: Value = json!(String::from_utf8_lossy(&received.lock().unwrap()));
    assert!(!sent.to_string().contains("Bearer"), "{sent}");
    assert!(answers(&site, &at, &lab.caller()).await);
}

/// A machine of the site that announces another one's station gets no token, and hides no arm when
/// it leaves.
#[tokio::test(flavor = "multi_thread")]
async fn machine_that_poses_as_another_one_gets_no_requests() {
    let OneArm {
        lab,
        station: _station,
        node,
        port,
        site,
        at,
        ..
    } = OneArm::new().await;
    let thief = lab.machine("thief").await;
    let session = zenoh::open(Config::from_file(tls_config(&lab, &thief, port)).unwrap());
    let session = session.await.unwrap();
    let key = format!("magician/lab/thief/alive/a/{}", node.id());
    let token = session.liveliness().declare_token(key).await.unwrap();
    let ask = async || {
        site.call(&at, &lab.teacher(), request("arm.stop", &json!({})))
            .await
    };
    wait_until(
        async || matches!(ask().await, Err(SiteError::Unproved(why)) if why.contains("thief")),
    )
    .await;
    assert!(site.open(at.station).await.is_err());
    token.undeclare().await.unwrap();
    wait_until(async || answers(&site, &at, &lab.caller()).await).await;
    assert!(site.arms().contains_key(&at));
}
