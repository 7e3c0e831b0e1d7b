//! The API of a station for the machines of its site: a listener that asks for their certificates.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_station::RunningStation;
use magician_station::http::{Admission, HttpOptions, Listener, SignsOfLife, Tls, TokenStore};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::sleep;

use super::CarrierError;
use crate::certificates::{Identity, machine_of};

/// Any port that is free, of all addresses of the machine.
const ANYWHERE: &str = "0.0.0.0:0";
/// Another program may have taken the port meanwhile: it is tried again after this.
const AGAIN: Duration = Duration::from_secs(1);

/// A listener for the machines of the site.
pub(super) struct SiteApi {
    identity: Identity,
    station: RunningStation,
    tokens: TokenStore,
    port: u16,
    state: Mutex<State>,
    /// Held while it listens anew.
    renewing: tokio::sync::Mutex<()>,
    runtime: tokio::runtime::Handle,
}

#[derive(Default)]
struct State {
    /// The listener that is at work now.
    serving: Option<Serving>,
    /// True once it is closed for good.
    closed: bool,
}

struct Serving {
    over: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl SiteApi {
    /// Listens on the present runtime.
    pub(super) async fn open(
        identity: &Identity,
        station: &RunningStation,
        tokens: &TokenStore,
    ) -> Result<Arc<Self>, CarrierError> {
        let listener = listen(ANYWHERE, identity).await?;
        let port = listener.addresses().first().map_or(0, SocketAddr::port);
        let api = Arc::new(Self {
            identity: identity.clone(),
            station: station.clone(),
            tokens: tokens.clone(),
            port,
            state: Mutex::default(),
            renewing: tokio::sync::Mutex::default(),
            runtime: tokio::runtime::Handle::current(),
        });
        api.serve(listener);
        Ok(api)
    }

    /// Addresses of the listener: all IPv4 addresses of the machine, loopback last.
    pub(super) fn addresses(&self) -> Vec<SocketAddr> {
        let interfaces = if_addrs::get_if_addrs().unwrap_or_default().into_iter();
        let addresses = interfaces.map(|interface| interface.ip());
        let of_others = addresses.filter(|ip| ip.is_ipv4() && !ip.is_loopback());
        let own = IpAddr::V4(Ipv4Addr::LOCALHOST);
        let all = of_others.chain([own]);
        all.map(|ip| SocketAddr::new(ip, self.port)).collect()
    }

    /// Listens anew, by the newest list of revoked certificates: connections of machines that are not
    /// revoked come back.
    pub(super) fn renew(self: &Arc<Self>) {
        let api = Arc::clone(self);
        self.runtime.spawn(async move {
            // Of two lists that come at once the later one is served: it waits here, and is read then.
            let _turn = api.renewing.lock().await;
            api.end().await;
            while !api.state().closed {
                match listen(&format!("0.0.0.0:{}", api.port), &api.identity).await {
                    Ok(listener) => return api.serve(listener),
                    Err(error) => {
                        tracing::error!(%error, "the site cannot reach this station: trying again");
                    }
                }
                sleep(AGAIN).await;
            }
        });
    }

    fn serve(&self, listener: Listener) {
        let options = HttpOptions {
            admission: Admission {
                hosts: vec![self.identity.machine().to_owned()],
                // A certificate of the site is no token, wherever its holder is.
                tokens_always: true,
                ..Admission::default()
            },
            signs: SignsOfLife::Hub,
            ..HttpOptions::new(self.tokens.clone(), env!("CARGO_PKG_VERSION"))
        };
        let mut state = self.state();
        if state.closed {
            return;
        }
        let (over, ends) = watch::channel(false);
        let serving = listener.serve(self.station.clone(), options, ends);
        let task = self.runtime.spawn(serving);
        state.serving = Some(Serving { over, task });
    }

    /// Closes it for good.
    pub(super) async fn close(&self) {
        self.state().closed = true;
        self.end().await;
    }

    /// Ends the listener with its connections.
    async fn end(&self) {
        let serving = self.state().serving.take();
        if let Some(Serving { over, task }) = serving {
            let _ = over.send(true);
            let _ = task.await;
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

async fn listen(at: &str, identity: &Identity) -> Result<Listener, CarrierError> {
    let tls = identity.server();
    let tls = tls.map_err(|error| CarrierError::Certificate(error.to_string()))?;
    let listener = Listener::bind(Some(at)).await;
    let listener = listener.map_err(|error| CarrierError::Network(error.to_string()))?;
    Ok(listener.encrypted(Tls::with_clients(tls, machine_of)))
}
