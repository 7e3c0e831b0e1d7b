//! The computer's side: its adapter, and the connection to what the system has for Bluetooth.

use std::collections::HashMap;
use std::future::Future;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::{Context, Waker};
use std::time::Duration;

use btleplug::api::{Central, CentralState, Manager as _};
use btleplug::platform::{Adapter, Manager, PeripheralId};
use tokio::runtime::{Handle, Id};
use tokio::time::timeout;

use super::trouble;
use crate::Result;

/// How long the system's Bluetooth may take to answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// What is kept between lines. A connection to the system is never closed by the library that makes it, so a process
/// that looks for a lost arm all night must not make one each time.
static KEPT: Mutex<Kept> = Mutex::new(Kept {
    session: None,
    devices: None,
});

struct Kept {
    session: Option<Session>,
    /// The device that a name led to last.
    devices: Option<HashMap<String, PeripheralId>>,
}

/// It lives in the runtime that it was made in.
struct Session {
    runtime: Id,
    manager: Manager,
    adapter: Option<Adapter>,
}

fn kept() -> MutexGuard<'static, Kept> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The first adapter that is switched on. None is ever switched on here: it may be off for a reason.
pub(super) async fn adapter() -> Result<Adapter> {
    match timeout(PATIENCE, choose()).await {
        Ok(chosen) => chosen,
        Err(_) => {
            kept().session = None;
            Err(trouble::silent(PATIENCE))
        }
    }
}

async fn choose() -> Result<Adapter> {
    let runtime = Handle::current().id();
    let session = kept()
        .session
        .as_ref()
        .filter(|session| session.runtime == runtime)
        .map(|session| (session.manager.clone(), session.adapter.clone()));
    let (manager, known) = match session {
        Some(session) => session,
        None => (Manager::new().await.map_err(trouble::of_system)?, None),
    };
    if let Some(adapter) = known
        && adapter.adapter_state().await.ok() == Some(CentralState::PoweredOn)
    {
        return Ok(adapter);
    }
    let adapters = manager.adapters().await;
    let mut on = None;
    for adapter in adapters.iter().flatten() {
        // Some systems say what it is like only after a while.
        if adapter.adapter_state().await.ok() != Some(CentralState::PoweredOff) {
            on = Some(adapter.clone());
            break;
        }
    }
    kept().session = Some(Session {
        runtime,
        manager,
        adapter: on.clone(),
    });
    let adapters = adapters.map_err(trouble::of_system)?;
    on.ok_or_else(|| match adapters.as_slice() {
        [] => trouble::no_adapter(),
        _ => trouble::switched_off(),
    })
}

/// A name leads to the same device again, should several have it.
pub(super) fn remember(wanted: &str, device: PeripheralId) {
    let mut kept = kept();
    let devices = kept.devices.get_or_insert_default();
    devices.insert(wanted.to_owned(), device);
}

/// The device that a name led to before.
pub(super) fn remembered(wanted: &str) -> Option<PeripheralId> {
    kept().devices.as_ref()?.get(wanted).cloned()
}

/// Runs a last task for callers that cannot wait: begun at once, carried through by the runtime if that goes on.
pub(super) fn see_off(runtime: &Handle, last: impl Future<Output = ()> + Send + 'static) {
    let begun = Handle::try_current().is_ok_and(|current| current.id() == runtime.id());
    let mut last = Box::pin(last);
    // Outside the runtime it may have ended, and what needs its clock must not be begun.
    if begun {
        let mut cx = Context::from_waker(Waker::noop());
        if last.as_mut().poll(&mut cx).is_ready() {
            return;
        }
    }
    runtime.spawn(last);
}
