//! TLS listener through which members of the site reach the API of a station.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_station::RunningStation;
use magician_station::http::{Admission, HttpOptions, KeepAliveSource, Listener, Tls, TokenStore};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::sleep;

use super::CarrierError;
use crate::certificates::{Identity, machine_of};

/// Any free port on all addresses. The port is announced in state messages, so it need not be
/// fixed.
const ANY_ADDRESS: &str = "0.0.0.0:0";
/// Pause before the port is bound again after a failure: another program may hold it for a moment.
const REBIND_DELAY: Duration = Duration::from_secs(1);

/// Listener for members of the site.
pub(super) struct SiteApi {
    identity: Identity,
    station: RunningStation,
    tokens: TokenStore,
    port: u16,
    state: Mutex<State>,
    /// Held while the listener is replaced.
    renewing: tokio::sync::Mutex<()>,
    runtime: tokio::runtime::Handle,
}

#[derive(Default)]
struct State {
    /// Listener that is running now.
    serving: Option<Serving>,
    /// True after [`SiteApi::close`]: no listener is started any more.
    closed: bool,
}

struct Serving {
    over: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl SiteApi {
    /// Binds a free port and starts to serve on the current runtime.
    pub(super) async fn open(
        identity: &Identity,
        station: &RunningStation,
        tokens: &TokenStore,
    ) -> Result<Arc<Self>, CarrierError> {
        let listener = listen(ANY_ADDRESS, identity).await?;
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

    /// Addresses of the listener: all IPv4 addresses of the machine, with loopback last because it
    /// is of use on this machine only.
    pub(super) fn addresses(&self) -> Vec<SocketAddr> {
        let interfaces = if_addrs::get_if_addrs().unwrap_or_default().into_iter();
        let addresses = interfaces.map(|interface| interface.ip());
        let of_others = addresses.filter(|ip| ip.is_ipv4() && !ip.is_loopback());
        let own = IpAddr::V4(Ipv4Addr::LOCALHOST);
        let all = of_others.chain([own]);
        all.map(|ip| SocketAddr::new(ip, self.port)).collect()
    }

    /// Restarts the listener on the same port with the newest list of revoked certificates. All
    /// connections are closed; all machines but the revoked ones connect again.
    pub(super) fn restart(self: &Arc<Self>) {
        let api = Arc::clone(self);
        self.runtime.spawn(async move {
            // One restart at a time: a list that arrives meanwhile gets a restart after this one.
            let _turn = api.renewing.lock().await;
            api.stop().await;
            while !api.state().closed {
                match listen(&format!("0.0.0.0:{}", api.port), &api.identity).await {
                    Ok(listener) => return api.serve(listener),
                    Err(error) => {
                        tracing::error!(%error, "the site cannot reach this station: trying again");
                    }
                }
                sleep(REBIND_DELAY).await;
            }
        });
    }

    fn serve(&self, listener: Listener) {
        let options = HttpOptions {
            admission: Admission {
                hosts: vec![self.identity.machine().to_owned()],
                // A certificate proves the machine, not the user: even loopback clients need a
                // token here.
                tokens_always: true,
                ..Admission::default()
            },
            // The caller may be a hub, which would answer pings even if its client is gone.
            keep_alives: KeepAliveSource::Hub,
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

    /// Stops the listener permanently.
    pub(super) async fn close(&self) {
        self.state().closed = true;
        self.stop().await;
    }

    /// Stops the listener and waits for its connections to close.
    async fn stop(&self) {
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
