//! The current arms of a site, and the distribution of changes to watchers.

use std::collections::BTreeMap;
use std::pin::pin;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::{ArmAt, ArmReport, SiteEvent, SiteEventSender, SiteEvents, StationId, event_channel};

/// Table of a site's arms with the last state of each. The transport fills it, and every change
/// goes to all watchers.
#[derive(Debug, Default)]
pub struct SiteView {
    inner: Mutex<Inner>,
    /// Notified whenever an arm leaves.
    departed: Notify,
}

#[derive(Debug, Default)]
struct Inner {
    arms: BTreeMap<ArmAt, Option<ArmReport>>,
    watchers: Vec<SiteEventSender>,
}

impl Inner {
    fn send_to_watchers(&mut self, event: &SiteEvent) {
        self.watchers.retain(|sender| sender.send(event.clone()));
    }
}

impl SiteView {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an arm. No effect if it is already present.
    pub fn arrived(&self, at: ArmAt) {
        let mut inner = self.lock();
        if inner.arms.contains_key(&at) {
            return;
        }
        inner.arms.insert(at.clone(), None);
        inner.send_to_watchers(&SiteEvent::Arrived(at));
    }

    /// Removes an arm. No effect if it is not present.
    pub fn left(&self, at: &ArmAt) {
        let mut inner = self.lock();
        if inner.arms.remove(at).is_some() {
            inner.send_to_watchers(&SiteEvent::Left(at.clone()));
            self.departed.notify_waiters();
        }
    }

    /// Waits until the station has no arm on the site.
    pub async fn wait_gone(&self, station: StationId) {
        loop {
            let mut departed = pin!(self.departed.notified());
            // Register before the check: otherwise a departure between the two would be missed.
            departed.as_mut().enable();
            if self.arm_of(station).is_none() {
                return;
            }
            departed.await;
        }
    }

    /// Stores the state of an arm. Ignored if the arm is not present, because a late message would
    /// otherwise bring back an arm that has left.
    pub fn report(&self, at: ArmAt, report: ArmReport) {
        let mut inner = self.lock();
        let Some(known) = inner.arms.get_mut(&at) else {
            return;
        };
        *known = Some(report.clone());
        inner.send_to_watchers(&SiteEvent::Report(at, report));
    }

    /// All arms present, each with its last state. `None` until the first state arrives.
    #[must_use]
    pub fn arms(&self) -> BTreeMap<ArmAt, Option<ArmReport>> {
        self.lock().arms.clone()
    }

    /// True if the arm is present.
    #[must_use]
    pub fn has(&self, at: &ArmAt) -> bool {
        self.lock().arms.contains_key(at)
    }

    /// Number of arms with this name.
    #[must_use]
    pub fn count_named(&self, arm: &str) -> usize {
        let inner = self.lock();
        inner.arms.keys().filter(|at| at.arm == arm).count()
    }

    /// Returns any arm of the station, or `None` if it has none on the site.
    #[must_use]
    pub fn arm_of(&self, station: StationId) -> Option<ArmAt> {
        let inner = self.lock();
        let mut arms = inner.arms.keys();
        arms.find(|at| at.station == station).cloned()
    }

    /// Subscribes to changes. The stream starts with the arms and states that are present.
    #[must_use]
    pub fn watch(&self) -> SiteEvents {
        let (sender, events) = event_channel();
        let mut inner = self.lock();
        for (at, report) in &inner.arms {
            sender.send(SiteEvent::Arrived(at.clone()));
            if let Some(report) = report {
                sender.send(SiteEvent::Report(at.clone(), report.clone()));
            }
        }
        inner.watchers.push(sender);
        events
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn at(arm: &str, station: u64) -> ArmAt {
        ArmAt {
            arm: arm.to_owned(),
            station: StationId(station),
        }
    }

    fn report(x: u32) -> ArmReport {
        ArmReport {
            machine: "here".to_owned(),
            port: "sim".to_owned(),
            is_virtual: true,
            state: json!({"x": x}),
        }
    }

    #[test]
    fn late_watcher_gets_the_present_arms() {
        let view = SiteView::default();
        view.arrived(at("a", 1));
        view.arrived(at("b", 2));
        view.report(at("a", 1), report(1));
        let mut early = view.watch();
        view.left(&at("b", 2));
        view.left(&at("b", 2));
        view.arrived(at("a", 1));
        let seen: Vec<_> = std::iter::from_fn(|| early.try_next()).collect();
        let expected = [
            SiteEvent::Arrived(at("a", 1)),
            SiteEvent::Report(at("a", 1), report(1)),
            SiteEvent::Arrived(at("b", 2)),
            SiteEvent::Left(at("b", 2)),
        ];
        assert_eq!(seen, expected);
    }

    #[test]
    fn state_of_an_absent_arm_is_ignored() {
        let view = SiteView::default();
        view.arrived(at("a", 1));
        let mut events = view.watch();
        events.try_next();
        view.report(at("a", 2), report(1));
        view.left(&at("a", 1));
        view.report(at("a", 1), report(1));
        assert_eq!(events.try_next(), Some(SiteEvent::Left(at("a", 1))));
        assert_eq!(events.try_next(), None);
        assert!(view.arms().is_empty());
    }
}
