//! A test site on this machine: an authority, stations with one virtual arm each, and observers.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::Arm;
use magician_site::carrier::{CarrierError, NodeOptions, ServedArm, SiteNode, ZenohSite};
use magician_site::certificates::{Authority, Identity, Invitation, join};
use magician_site::{ArmAt, Caller, Channel, FromStation, Site, SiteEvent, SiteEvents};
use magician_station::http::{JobFolder, TokenStore};
use magician_station::{ArmEntry, JournalLine, Role, RunningStation, StationConfig};
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::time::{Instant, timeout};

/// Timeout of every wait. Everything here normally takes milliseconds; the margin is for a machine
/// under load.
pub(crate) const WAIT_TIMEOUT: Duration = Duration::from_secs(30);
/// Machine of the authority, and of every station unless stated otherwise.
pub(crate) const BENCH: &str = "bench-1";

pub(crate) struct Lab {
    pub(crate) folder: TempDir,
    pub(crate) tokens: TokenStore,
    pub(crate) token: String,
    /// Journal lines of all stations.
    pub(crate) journal: Arc<Mutex<Vec<JournalLine>>>,
    /// `None` on a site without certificates.
    pub(crate) identity: Option<Identity>,
}

impl Lab {
    /// Creates a site whose machines have certificates.
    pub(crate) fn new() -> Self {
        let lab = Self::without_certificates();
        let authority = Authority::init(&lab.folder.path().join("lab"), "lab", BENCH).unwrap();
        Self {
            identity: Some(authority.identity().unwrap()),
            ..lab
        }
    }

    pub(crate) fn without_certificates() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let tokens = TokenStore::at(folder.path().join("tokens.toml"));
        let (_, token) = tokens.create(None, Role::Student).unwrap();
        Self {
            folder,
            tokens,
            token,
            journal: Arc::default(),
            identity: None,
        }
    }

    pub(crate) fn authority(&self) -> Authority {
        Authority::open(&self.folder.path().join("lab"))
            .unwrap()
            .unwrap()
    }

    /// Lets another machine join, and returns its identity.
    pub(crate) async fn machine(&self, name: &str) -> Identity {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let invitation = Arc::new(Invitation::new(self.authority(), 1).unwrap());
        let code = invitation.code(&listener.local_addr().unwrap().to_string());
        let inviting = invitation.run(listener, Instant::now() + WAIT_TIMEOUT, |_| {});
        let folders = self.folder.path().join(name);
        let joining = join(&code, &folders, Some(name), name);
        let (ended, joined) = tokio::join!(inviting, joining);
        ended.unwrap();
        joined.unwrap().identity
    }

    /// Writes the Zenoh configuration of one participant. Multicast is off, so that parallel tests
    /// do not see each other. Without `listens` the system chooses the port; such participants find
    /// each other through one with a known port.
    pub(crate) fn config(&self, name: &str, listens: Option<u16>, connects: &[u16]) -> PathBuf {
        let link = if self.identity.is_some() {
            "tls"
        } else {
            "tcp"
        };
        let at = |port: &u16| format!("{link}/127.0.0.1:{port}");
        let listens = [at(&listens.unwrap_or(0))];
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

    pub(crate) async fn node(&self, name: &str, config: &Path) -> (RunningStation, SiteNode) {
        let (station, joined) = self.try_node(name, config, self.identity.clone()).await;
        (station, joined.unwrap())
    }

    pub(crate) async fn try_node(
        &self,
        name: &str,
        config: &Path,
        identity: Option<Identity>,
    ) -> (RunningStation, Result<SiteNode, CarrierError>) {
        let arm = Arm::connect("sim").await.unwrap();
        let entries = vec![ArmEntry::simulated(name)];
        let jobs =
            JobFolder::open(config.with_extension("jobs"), &entries, &[String::new()]).unwrap();
        let config_of_station = StationConfig {
            jobs: Arc::new(jobs),
            ..StationConfig::new(entries, name)
        };
        let journal = Arc::clone(&self.journal);
        let write = Box::new(move |line| journal.lock().unwrap().push(line));
        let station = RunningStation::start(config_of_station, vec![arm], write);
        let options = NodeOptions {
            site: "lab".parse().unwrap(),
            machine: BENCH.to_owned(),
            arms: vec![ServedArm {
                name: name.to_owned(),
                port: "sim".to_owned(),
                is_virtual: true,
            }],
            config: Some(config.to_owned()),
            identity,
        };
        let joined = SiteNode::join(options, station.clone(), self.tokens.clone()).await;
        (station, joined)
    }

    pub(crate) async fn site(&self, connects: &[u16]) -> ZenohSite {
        self.site_of(self.identity.clone(), connects).await
    }

    pub(crate) async fn site_of(&self, identity: Option<Identity>, connects: &[u16]) -> ZenohSite {
        let config = self.config("hub", None, connects);
        let name = "lab".parse().unwrap();
        ZenohSite::join(name, Some(&config), identity)
            .await
            .unwrap()
    }

    pub(crate) fn caller(&self) -> Caller {
        Caller {
            token: Some(self.token.clone()),
        }
    }

    pub(crate) fn teacher(&self) -> Caller {
        let (_, token) = self.tokens.create(None, Role::Teacher).unwrap();
        Caller { token: Some(token) }
    }
}

/// A site with one station and its arm `a`, seen by an observer.
pub(crate) struct OneArm {
    pub(crate) lab: Lab,
    pub(crate) station: RunningStation,
    pub(crate) node: SiteNode,
    /// Port through which other participants find the site.
    pub(crate) port: u16,
    pub(crate) site: ZenohSite,
    /// Events after the arm's first state.
    pub(crate) events: SiteEvents,
    pub(crate) at: ArmAt,
    pub(crate) state: Value,
}

impl OneArm {
    pub(crate) async fn new() -> Self {
        let lab = Lab::new();
        let port = free_port();
        let (station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
        let site = lab.site(&[port]).await;
        let mut events = site.watch();
        let (at, state) = wait_for_arm(&mut events, "a").await;
        Self {
            lab,
            station,
            node,
            port,
            site,
            events,
            at,
            state,
        }
    }
}

pub(crate) fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

pub(crate) fn request(method: &str, params: &Value) -> String {
    json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).to_string()
}

pub(crate) async fn wait_for_event<T>(
    events: &mut SiteEvents,
    mut wanted: impl FnMut(SiteEvent) -> Option<T>,
) -> T {
    let found = async {
        loop {
            if let Some(found) = wanted(events.next().await) {
                return found;
            }
        }
    };
    timeout(WAIT_TIMEOUT, found).await.unwrap()
}

/// Waits until an arm is present and its state is known.
pub(crate) async fn wait_for_arm(events: &mut SiteEvents, arm: &str) -> (ArmAt, Value) {
    wait_for_event(events, |event| match event {
        SiteEvent::Report(at, report) if at.arm == arm && !report.state.is_null() => {
            assert_eq!(report.machine, BENCH);
            Some((at, report.state))
        }
        _ => None,
    })
    .await
}

async fn next_text(channel: &mut Channel) -> Value {
    let next = timeout(WAIT_TIMEOUT, channel.receive()).await.unwrap();
    match next {
        FromStation::Text(text) => serde_json::from_str(&text).unwrap(),
        other => panic!("{other:?}"),
    }
}

pub(crate) async fn answer(channel: &mut Channel, id: u64) -> Value {
    loop {
        let text = next_text(channel).await;
        if text["id"] == id {
            return text;
        }
    }
}

/// Waits until a condition holds.
pub(crate) async fn wait_until(is_so: impl AsyncFn() -> bool) {
    let waiting = async {
        while !is_so().await {
            tokio::task::yield_now().await;
        }
    };
    timeout(WAIT_TIMEOUT, waiting).await.unwrap();
}

/// True if a request to the arm succeeds.
pub(crate) async fn answers(site: &ZenohSite, at: &ArmAt, caller: &Caller) -> bool {
    let asked = request("arm.state", &json!({"arm": at.arm}));
    matches!(site.call(at, caller, asked).await, Ok(Some(text)) if text.contains("\"result\""))
}
