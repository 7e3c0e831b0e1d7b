//! Settings of the arm that a program changes temporarily and restores however it ends. If its
//! process is killed, the next program that moves or sets restores them.
//!
//! A job saves a setting before it changes it. The values are in memory and, for an arm that
//! outlives the process, in a file that the process keeps locked (`ledger`). A file without a lock
//! means that its process died: the next program restores it.

#[cfg(feature = "files")]
mod ledger;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Arm, Result, Set, SettingsBackup};
#[cfg(feature = "files")]
use tracing::{info, warn};

#[cfg(feature = "files")]
use self::ledger::{ClaimedEntries, Entry, Ledger};

/// Settings that a program has to restore. Clones share them.
///
/// With the feature `files` they are also stored in a file, if the arm outlives the process and
/// reports a serial number. If this process is killed, the next program that moves or sets restores
/// them ([`recover`](Self::recover)).
///
/// ```
/// use magician::commands::PtpCommonParams;
/// use magician::{Arm, build};
/// use magician_job::SavedSettings;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// # let arm = Arm::connect("sim").await?;
/// let saved = SavedSettings::default();
/// saved.save(&arm, arm.get::<PtpCommonParams>().await?).await;
/// arm.set_any(&build::speed(80.0, 80.0)).await?;
/// saved.restore(&arm).await?;
/// assert_eq!(arm.get::<PtpCommonParams>().await?.velocity_ratio, 50.0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct SavedSettings(Arc<Mutex<SavedState>>);

#[derive(Debug, Default)]
struct SavedState {
    settings: SettingsBackup,
    /// File of these settings, if the arm outlives this process.
    #[cfg(feature = "files")]
    entry: Option<Entry>,
}

/// Kind of access that a program has to the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Access {
    /// Only reads.
    Reads,
    /// Moves or sets something, or may.
    Sets,
    /// Ends something dangerous: nothing may delay that.
    Stops,
}

impl Access {
    /// [`Sets`](Self::Sets) if `sets`, else [`Reads`](Self::Reads).
    #[must_use]
    pub const fn sets_if(sets: bool) -> Self {
        if sets { Self::Sets } else { Self::Reads }
    }
}

/// Result of restoring settings that dead processes left changed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum RecoveredSettings {
    /// No settings to restore, or the arm does not report its serial number.
    Nothing,
    /// Names of the settings that were restored.
    Restored(Vec<&'static str>),
    /// Names of the settings that are still to be restored.
    Outstanding(Vec<&'static str>),
    /// Names of the settings to restore once the arm's queue is empty.
    Deferred(Vec<&'static str>),
    /// The file with the settings is damaged.
    Damaged(String),
}

impl SavedSettings {
    /// Saves a setting to restore later. It is stored before this returns: change it afterwards.
    pub async fn save(&self, arm: &Arm, setting: impl Into<Set>) {
        let mut settings = SettingsBackup::default();
        settings.save(setting);
        self.save_all(arm, settings).await;
    }

    /// Saves several settings, as [`save`](Self::save).
    pub async fn save_all(&self, arm: &Arm, settings: SettingsBackup) {
        if settings.is_empty() {
            return;
        }
        self.lock().settings.append(settings);
        #[cfg(feature = "files")]
        if let Some((ledger, serial)) = ledger_of(arm).await {
            self.store(&ledger, &serial);
        }
        #[cfg(not(feature = "files"))]
        let _ = arm;
    }

    /// True if a setting of this kind is saved.
    pub(crate) fn has(&self, id: u8) -> bool {
        let saved = self.lock();
        let mut settings = saved.settings.settings().iter();
        settings.any(|setting| setting.row().id == id)
    }

    /// True if nothing has to be restored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lock().settings.is_empty()
    }

    /// Stores the settings in a file. A failure is only logged: this process restores them all the
    /// same.
    #[cfg(feature = "files")]
    fn store(&self, ledger: &Ledger, serial: &str) {
        let mut saved = self.lock();
        let before = saved.entry.take().filter(|entry| entry.is_of(serial));
        match ledger.store(serial, &saved.settings, before) {
            Ok(entry) => saved.entry = Some(entry),
            Err(error) => {
                warn!(%error, "the arm's previous settings cannot be saved: they are not restored \
                    if this process is killed");
            }
        }
    }

    /// Forgets the settings: commands in the arm's queue restore them.
    pub fn forget(&self) {
        self.take().remove();
    }

    /// Leaves the settings to the next program, with the file as it is.
    pub fn leave(&self) {
        self.take();
    }

    /// Restores the settings. If the future is dropped early, nothing is forgotten and all can be
    /// restored again.
    ///
    /// # Errors
    /// Same as [`Arm::set`], at the first setting that the arm refuses; the remaining ones are not
    /// restored.
    pub async fn restore(&self, arm: &Arm) -> Result<()> {
        let restoring = Restoring {
            owner: self,
            saved: Some(self.take()),
        };
        let mut settings = restoring.settings();
        let restored = settings.restore(arm).await;
        let saved = restoring.release();
        restored?;
        saved.remove();
        Ok(())
    }

    /// Restores after a failure: stops the arm first, so that no pending command follows, then
    /// restores as far as the arm allows. Errors are ignored, since the caller reports the failure
    /// itself.
    pub async fn restore_after_failure(&self, arm: &Arm) {
        if self.is_empty() {
            return;
        }
        match arm.stop().await {
            Ok(()) => drop(self.restore(arm).await),
            Err(_) => self.leave(),
        }
    }

    fn take(&self) -> SavedState {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, SavedState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Settings being restored. If dropped early they return to the owner: a stop may cancel the
/// restore.
struct Restoring<'a> {
    owner: &'a SavedSettings,
    saved: Option<SavedState>,
}

impl Restoring<'_> {
    fn settings(&self) -> SettingsBackup {
        let saved = self.saved.as_ref();
        saved.map_or_else(SettingsBackup::default, |saved| saved.settings.clone())
    }

    /// Takes the settings out: they are not returned to the owner.
    fn release(mut self) -> SavedState {
        self.saved.take().unwrap_or_default()
    }
}

impl Drop for Restoring<'_> {
    fn drop(&mut self) {
        if let Some(saved) = self.saved.take() {
            self.owner.lock().merge_earlier(saved);
        }
    }
}

impl SavedState {
    /// Merges settings that were saved before the present ones.
    fn merge_earlier(&mut self, before: Self) {
        let since = std::mem::replace(self, before);
        // Restored in order: the oldest value has to come last.
        let first = std::mem::replace(&mut self.settings, since.settings);
        self.settings.append(first);
        #[cfg(feature = "files")]
        if self.entry.is_none() {
            self.entry = since.entry;
        }
    }

    fn remove(self) {
        #[cfg(feature = "files")]
        remove(self.entry);
    }
}

#[cfg(not(feature = "files"))]
impl SavedSettings {
    /// Restores settings that dead processes left changed. Without the feature `files` none are
    /// known.
    #[allow(clippy::unused_async, reason = "as with the feature `files`")]
    pub async fn recover(_arm: &Arm, _access: Access) -> RecoveredSettings {
        RecoveredSettings::Nothing
    }
}

#[cfg(feature = "files")]
impl SavedSettings {
    /// Restores settings that dead processes left changed (killed, or the line was lost).
    ///
    /// Waits for another time while a live process has settings of the arm changed, or commands in
    /// the queue may still change some. Errors are only logged: the work that follows fails too and
    /// reports it better.
    pub async fn recover(arm: &Arm, access: Access) -> RecoveredSettings {
        if access == Access::Stops {
            return RecoveredSettings::Nothing;
        }
        let Some((ledger, serial)) = ledger_if_used(arm).await else {
            return RecoveredSettings::Nothing;
        };
        let ClaimedEntries { entries, others } = ledger.claim(&serial);
        let mut all = SettingsBackup::default();
        let (mut whole, mut damaged) = (Vec::new(), None);
        for (entry, settings) in entries {
            match settings {
                Some(settings) => {
                    all.append(settings);
                    whole.push(entry);
                }
                None => {
                    damaged = Some(entry.path().display().to_string());
                    if access == Access::Sets {
                        remove(Some(entry));
                    }
                }
            }
        }
        // A live process restores its settings itself; restoring them now would undo its changes.
        if whole.is_empty() || others {
            return damaged.map_or(RecoveredSettings::Nothing, RecoveredSettings::Damaged);
        }
        let mut names: Vec<_> = all.settings().iter().map(|set| set.row().name).collect();
        names.sort_unstable();
        names.dedup();
        if access == Access::Reads {
            return RecoveredSettings::Outstanding(names);
        }
        match restore_if_idle(arm, all).await {
            Ok(true) => {
                whole.into_iter().for_each(|entry| remove(Some(entry)));
                RecoveredSettings::Restored(names)
            }
            Ok(false) => RecoveredSettings::Deferred(names),
            Err(error) => {
                info!(%error, "the arm's previous settings cannot be restored");
                RecoveredSettings::Outstanding(names)
            }
        }
    }
}

/// Restores the settings if the arm's queue is empty; returns if it is.
#[cfg(feature = "files")]
async fn restore_if_idle(arm: &Arm, mut settings: SettingsBackup) -> Result<bool> {
    let (_, places) = arm.stats().await?;
    let empty = arm.queue().left_space().await? >= places;
    if empty {
        settings.restore(arm).await?;
    }
    Ok(empty)
}

#[cfg(feature = "files")]
fn remove(entry: Option<Entry>) {
    let Some(entry) = entry else {
        return;
    };
    let path = entry.path().display().to_string();
    if let Err(error) = entry.remove() {
        warn!(%error, "{path} cannot be removed: its settings will be restored once more");
    }
}

/// Ledger and serial number for this arm. `None` for an arm that ends with this process or has no
/// serial number.
#[cfg(feature = "files")]
async fn ledger_of(arm: &Arm) -> Option<(Ledger, String)> {
    if arm.front_end().is_in_process() {
        return None;
    }
    let ledger = Ledger::at(crate::dirs::state()?.join("debts"));
    let serial = match arm.get::<magician::commands::DeviceSn>().await {
        Ok(serial) => serial.device_sn.to_string(),
        Err(error) => {
            info!(%error, "the arm does not report its serial number: its settings are not saved");
            return None;
        }
    };
    let serial = serial.trim();
    (!serial.is_empty()).then(|| (ledger, serial.to_owned()))
}

/// Like `ledger_of`, but without a request to the arm if no settings of any arm are stored.
#[cfg(feature = "files")]
async fn ledger_if_used(arm: &Arm) -> Option<(Ledger, String)> {
    let ledger = Ledger::at(crate::dirs::state()?.join("debts"));
    if arm.front_end().is_in_process() || ledger.is_empty() {
        return None;
    }
    ledger_of(arm).await
}
