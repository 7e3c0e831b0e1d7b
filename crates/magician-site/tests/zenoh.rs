//! Stations and a program that looks at them, over a network of this machine.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::Duration;

use magician::Arm;
use magician_site::carrier::{
    CarrierError, LINGER_FLAW, NodeOptions, ServedArm, SiteNode, ZenohSite,
};
use magician_site::message::EXPECT;
use magician_site::{
    ArmAt, Caller, Channel, FromStation, Roster, Site, SiteError, SiteEvent, SiteEvents, ToStation,
};
use magician_station::http::TokenStore;
use magician_station::{ArmEntry, Role, RunningStation, StationConfig};
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::time::timeout;

/// Everything here takes milliseconds; a machine under load gets this.
const PATIENCE: Duration = Duration::from_secs(30);

#[test]
fn builds_of_the_repository_close_links_without_lingering() {
    assert_eq!(LINGER_FLAW, None);
}

struct Lab {
    folder: TempDir,
    tokens: TokenStore,
    token: String,
}

impl Lab {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let tokens = TokenStore::at(folder.path().join("tokens.toml"));
        let (_, token) = tokens.create(None, Role::Student).unwrap();
        Self {
            folder,
            tokens,
            token,
        }
    }

    /// Settings of Zenoh for one end: without multicast, so that tests beside each other do not meet.
    fn config(&self, name: &str, listens: Option<u16>, connects: &[u16]) -> PathBuf {
        let at = |port: &u16| format!("tcp/127.0.0.1:{port}");
        let listens: Vec<_> = listens.iter().map(at).collect();
        let connects: Vec<_> = connects.iter().map(at).collect();
        let config = json!({
            "listen": {"endpoints": listens},
            "connect": {"endpoints": connects},
            "scouting": {"multicast": {"enabled": false}},
        });
        let path = self.folder.path().join(format!("{name}.json5"));
        std::fs::write(&path, config.to_string()).unwrap();
        path
    }

    async fn node(&self, name: &str, config: &Path) -> (RunningStation, SiteNode) {
        let (station, joined) = self.try_node(name, config).await;
        (station, joined.unwrap())
    }

    async fn try_node(
        &self,
        name: &str,
        config: &Path,
    ) -> (RunningStation, Result<SiteNode, CarrierError>) {
        let arm = Arm::connect("sim").await.unwrap();
        let entries = vec![ArmEntry::simulated(name)];
        let station = RunningStation::start(
            StationConfig::new(entries, name),
            vec![arm],
            Box::new(|_| {}),
        );
        let options = NodeOptions {
            site: "lab".parse().unwrap(),
            machine: format!("machine-of-{name}"),
            arms: vec![ServedArm {
                name: name.to_owned(),
                port: "sim".to_owned(),
                is_virtual: true,
            }],
            config: Some(config.to_owned()),
            roster: Some(config.with_extension("roster")),
        };
        let joined = SiteNode::join(options, station.clone(), self.tokens.clone()).await;
        (station, joined)
    }

    async fn site(&self, connects: &[u16]) -> ZenohSite {
        let config = self.config("hub", None, connects);
        let name = "lab".parse().unwrap();
        ZenohSite::join(name, Some(&config)).await.unwrap()
    }

    fn caller(&self) -> Caller {
        Caller {
            token: Some(self.token.clone()),
            client: "test".to_owned(),
        }
    }
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

fn request(method: &str, params: &Value) -> String {
    json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).to_string()
}

async fn until<T>(events: &mut SiteEvents, mut wanted: impl FnMut(SiteEvent) -> Option<T>) -> T {
    let found = async {
        loop {
            if let Some(found) = wanted(events.next().await) {
                return found;
            }
        }
    };
    timeout(PATIENCE, found).await.unwrap()
}

/// Waits until an arm is there, with its state.
async fn arrives(events: &mut SiteEvents, arm: &str) -> (ArmAt, Value) {
    until(events, |event| match event {
        SiteEvent::News(at, news) if at.arm == arm && !news.state.is_null() => {
            assert_eq!(news.machine, format!("machine-of-{arm}"));
            Some((at, news.state))
        }
        _ => None,
    })
    .await
}

async fn next_text(channel: &mut Channel) -> Value {
    let next = timeout(PATIENCE, channel.receive()).await.unwrap();
    match next {
        FromStation::Text(text) => serde_json::from_str(&text).unwrap(),
        other => panic!("{other:?}"),
    }
}

async fn answer(channel: &mut Channel, id: u64) -> Value {
    loop {
        let text = next_text(channel).await;
        if text["id"] == id {
            return text;
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_site_sees_its_arms_and_what_they_do() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let site = lab.site(&[port]).await;
    let mut events = site.watch();
    let (at, state) = arrives(&mut events, "a").await;
    assert_eq!(at.station, node.id());
    assert_eq!(state["link"], "up");
    assert_eq!(state["holder"], Value::Null);

    let stop = request("arm.stop", &json!({}));
    let nobody = Caller::default();
    let refused = site.call(&at, &nobody, stop.clone()).await;
    assert!(matches!(refused, Err(SiteError::Refused(_))), "{refused:?}");
    let wrong = Caller {
        token: Some("x".repeat(40)),
        ..Caller::default()
    };
    let refused = site.call(&at, &wrong, stop.clone()).await;
    assert!(matches!(refused, Err(SiteError::Refused(_))), "{refused:?}");
    let stopped = site.call(&at, &lab.caller(), stop).await.unwrap().unwrap();
    assert!(stopped.contains("\"result\""), "{stopped}");

    let moved = request("arm.move", &json!({"arm": "a", "to": [220, 0, 50, 0]}));
    let moved = site.call(&at, &lab.caller(), moved).await.unwrap().unwrap();
    assert!(moved.contains("\"x\":220"), "{moved}");
    until(&mut events, |event| match event {
        SiteEvent::News(_, news) => (news.state["x"] == 220.0).then_some(()),
        _ => None,
    })
    .await;

    node.leave().await;
    until(&mut events, |event| {
        (event == SiteEvent::Left(at.clone())).then_some(())
    })
    .await;
    let gone = request("arm.stop", &json!({}));
    let gone = site.call(&at, &lab.caller(), gone).await;
    assert_eq!(gone, Err(SiteError::Gone));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_name_is_on_a_site_once() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let (_other, refused) = lab.try_node("a", &lab.config("b", None, &[port])).await;
    match refused {
        Err(CarrierError::Taken {
            arm,
            station,
            machine,
            ..
        }) => {
            assert_eq!((arm.as_str(), station), ("a", node.id()));
            assert_eq!(machine.as_deref(), Some("machine-of-a"));
        }
        other => panic!("{other:?}"),
    }
    // Another name is welcome, and a name that is free again is, too.
    let (_third, beside) = lab.node("c", &lab.config("c", None, &[port])).await;
    beside.leave().await;
    let (_again, _node) = lab.node("c", &lab.config("d", None, &[port])).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_is_the_equal_of_a_socket() {
    let lab = Lab::new();
    let port = free_port();
    let (station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let site = lab.site(&[port]).await;
    let mut events = site.watch();
    arrives(&mut events, "a").await;
    let before = station.sockets();

    let mut channel = site.open(node.id()).await.unwrap();
    let hello = json!({"client": {"name": "pupil"}, "token": lab.token});
    channel
        .send(ToStation::Text(request("session.hello", &hello)))
        .await;
    let greeted = answer(&mut channel, 1).await;
    assert_eq!(greeted["result"]["role"], "student", "{greeted}");
    assert_eq!(station.sockets(), before + 1);
    let lease = request("lease.acquire", &json!({"arm": "a"}));
    channel.send(ToStation::Text(lease)).await;
    answer(&mut channel, 1).await;
    until(&mut events, |event| match event {
        SiteEvent::News(_, news) => (news.state["holder"]["name"] == "pupil").then_some(()),
        _ => None,
    })
    .await;

    // More frames than are on their way at once: they are taken, and others follow.
    let subscribe = json!({"arm": "a", "rate": 50, "frame": "binary"});
    channel
        .send(ToStation::Text(request("arm.subscribe", &subscribe)))
        .await;
    let mut frames = 0;
    while frames < 150 {
        match timeout(PATIENCE, channel.receive()).await.unwrap() {
            FromStation::Frame(bytes) => {
                assert_eq!(bytes.len(), magician_station::FRAME);
                frames += 1;
            }
            FromStation::Text(_) => {}
            FromStation::Closed(closed) => panic!("{closed}"),
        }
    }
    // The end of the channel is the end of the socket, and the lease is free again.
    drop(channel);
    until(&mut events, |event| match event {
        SiteEvent::News(_, news) => news.state["holder"].is_null().then_some(()),
        _ => None,
    })
    .await;
    assert_eq!(station.sockets(), before);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_token_closes_a_session_with_its_code() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let site = lab.site(&[port]).await;
    let mut events = site.watch();
    arrives(&mut events, "a").await;
    let mut channel = site.open(node.id()).await.unwrap();
    let hello = json!({"client": {"name": "pupil"}, "token": "x".repeat(40)});
    channel
        .send(ToStation::Text(request("session.hello", &hello)))
        .await;
    loop {
        if let FromStation::Closed(closed) = timeout(PATIENCE, channel.receive()).await.unwrap() {
            assert_eq!(closed.code, 4401, "{closed}");
            return;
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn roster_is_kept_by_stations_and_a_stranger_only_adds_to_it() {
    let lab = Lab::new();
    let port = free_port();
    let config = lab.config("a", Some(port), &[]);
    let (_station, node) = lab.node("a", &config).await;
    let site = lab.site(&[port]).await;
    let mut events = site.watch();
    let (at, _) = arrives(&mut events, "a").await;
    assert!(site.roster().await.is_empty());

    let expected = json!({"arms": [{"arm": "a", "machine": "m"}, {"arm": "b", "machine": "m"}]});
    let write = |params: &Value| request(EXPECT, params);
    let student = lab.caller();
    let refused = site.call(&at, &student, write(&expected)).await;
    assert!(refused.unwrap().unwrap().contains("-32001"));
    assert!(site.roster().await.is_empty());
    let (_, token) = lab.tokens.create(None, Role::Teacher).unwrap();
    let teacher = Caller {
        token: Some(token),
        client: "desk".to_owned(),
    };
    let wrong = json!({"arms": [{"arm": "*"}]});
    let refused = site.call(&at, &teacher, write(&wrong)).await;
    assert!(refused.unwrap().unwrap().contains("-32602"));
    let written = site.call(&at, &teacher, write(&expected)).await;
    assert!(written.unwrap().unwrap().contains("result"));
    let names =
        |roster: &Roster| -> Vec<_> { roster.arms().map(|(arm, _)| arm.to_owned()).collect() };
    assert_eq!(names(&site.roster().await), ["a", "b"]);
    // It is on disk.
    let kept = std::fs::read_to_string(config.with_extension("roster")).unwrap();
    assert_eq!(Roster::parse(&kept).unwrap(), site.roster().await);

    // Somebody on the network with rosters of their own: one that hides, one that adds, one that is none.
    let stranger = lab.config("stranger", Some(free_port()), &[port]);
    let stranger = zenoh::open(zenoh::Config::from_file(stranger).unwrap());
    let stranger = stranger.await.unwrap();
    let mut declared = Vec::new();
    for (station, said) in [
        (1, r#"{"arms": []}"#),
        (
            2,
            r#"{"arms": [{"arm": "a", "machine": "elsewhere"}, {"arm": "ghost"}]}"#,
        ),
        (3, r#"{"arms": [{"arm": "c", "gone": "a"}]}"#),
        (4, "no roster"),
    ] {
        let key = format!("magician/lab/@roster/{station:016x}");
        let said = said.to_owned();
        let answer = move |query: zenoh::query::Query| {
            let said = said.clone();
            std::thread::spawn(move || {
                let _ = zenoh::Wait::wait(query.reply(query.key_expr().clone(), said));
            });
        };
        declared.push(
            stranger
                .declare_queryable(key)
                .callback(answer)
                .await
                .unwrap(),
        );
    }
    let ghost = async {
        while !site.roster().await.has("ghost") {
            tokio::task::yield_now().await;
        }
    };
    timeout(PATIENCE, ghost).await.unwrap();
    let roster = site.roster().await;
    assert_eq!(names(&roster), ["a", "b", "ghost"]);
    drop(declared);
    node.leave().await;
    // A station that starts again has what it was told.
    let (_station, _node) = lab.node("a", &config).await;
    let back = async {
        while names(&site.roster().await) != ["a", "b"] {
            tokio::task::yield_now().await;
        }
    };
    timeout(PATIENCE, back).await.unwrap();
}
