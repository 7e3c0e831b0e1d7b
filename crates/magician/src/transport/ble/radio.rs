//! Bluetooth adapter of this computer, and the connection to the system's Bluetooth service.

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

/// Longest time for the system's Bluetooth to answer. Choice.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);

/// Session kept between lines. The library never closes its connection to the system, so a process
/// that searches for a lost arm for hours must not make one each time.
static KEPT: Mutex<Kept> = Mutex::new(Kept {
    session: None,
    devices: None,
});

struct Kept {
    session: Option<Session>,
    /// Device found last for each name.
    devices: Option<HashMap<String, PeripheralId>>,
}

/// Session, valid in the runtime that created it.
struct Session {
    runtime: Id,
    manager: Manager,
    adapter: Option<Adapter>,
}

fn kept() -> MutexGuard<'static, Kept> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the first adapter that is switched on. None is switched on here: it may be off for a
/// reason.
pub(super) async fn adapter() -> Result<Adapter> {
    match timeout(ANSWER_TIMEOUT, choose()).await {
        Ok(chosen) => chosen,
        Err(_) => {
            // The service may have hung up on the session; the next attempt starts a new one.
            kept().session = None;
            Err(trouble::silent(ANSWER_TIMEOUT))
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
        // An adapter may have been switched off since.
        && adapter.adapter_state().await.ok() == Some(CentralState::PoweredOn)
    {
        return Ok(adapter);
    }
    let adapters = manager.adapters().await;
    let mut on = None;
    for adapter in adapters.iter().flatten() {
        // Some systems report the state of an adapter only after a while.
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

/// Remembers the device for a name, in case several have it.
pub(super) fn remember(wanted: &str, device: PeripheralId) {
    let mut kept = kept();
    let devices = kept.devices.get_or_insert_default();
    devices.insert(wanted.to_owned(), device);
}

/// Returns the device last found for a name.
pub(super) fn remembered(wanted: &str) -> Option<PeripheralId> {
    kept().devices.as_ref()?.get(wanted).cloned()
}

/// Runs a final task for callers that cannot wait: started at once, and completed by the runtime if
/// that continues.
pub(super) fn see_off(runtime: &Handle, last: impl Future<Output = ()> + Send + 'static) {
    let begun = Handle::try_current().is_ok_and(|current| current.id() == runtime.id());
    let mut last = Box::pin(last);
    // The runtime may have ended, and a future that needs its clock must not be polled outside.
    if begun {
        let mut cx = Context::from_waker(Waker::noop());
        if last.as_mut().poll(&mut cx).is_ready() {
            return;
        }
    }
    runtime.spawn(last);
}
