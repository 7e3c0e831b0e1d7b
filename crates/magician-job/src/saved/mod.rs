//! Settings of the arm that a program changes for its own time and restores, however it ends: also when the process is
//! killed, then by the next program that moves or sets.

#[cfg(feature = "files")]
mod ledger;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Arm, Result, Set, SettingsBackup};
#[cfg(feature = "files")]
use tracing::{info, warn};

#[cfg(feature = "files")]
use self::ledger::{Entry, Ledger, Left};

/// The settings that a program has to restore. Clones share them.
///
/// With the feature `files` they are also kept in a file, for an arm that outlives the process and tells its serial number: the
/// next program that moves or sets restores them ([`settle`](Self::settle)) when this one was killed.
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
pub struct SavedSettings(Arc<Mutex<Saved>>);

#[derive(Debug, Default)]
struct Saved {
    settings: SettingsBackup,
    /// The file that says so, where the arm outlives this process.
    #[cfg(feature = "files")]
    kept: Option<Entry>,
}

/// What a program does with the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Access {
    /// It only reads.
    Reads,
    /// It moves or sets something, or may.
    Sets,
    /// It ends something that may be dangerous: nothing comes before that.
    Stops,
}

impl Access {
    /// Of a program that moves or sets only then.
    #[must_use]
    pub const fn sets_if(sets: bool) -> Self {
        if sets { Self::Sets } else { Self::Reads }
    }
}

/// What became of the settings that ended processes have left changed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Settled {
    /// There are none, or the arm does not tell its serial number.
    Nothing,
    /// These settings are restored.
    Restored(Vec<&'static str>),
    /// These are still to be restored.
    Left(Vec<&'static str>),
    /// These are to be restored when the arm has done what is in its queue.
    Later(Vec<&'static str>),
    /// The file that names them is damaged.
    Damaged(String),
}

impl SavedSettings {
    /// Has this setting restored. It is kept before this returns, so change it after.
    pub async fn save(&self, arm: &Arm, setting: impl Into<Set>) {
        let mut settings = SettingsBackup::default();
        settings.save(setting);
        self.save_all(arm, settings).await;
    }

    /// Has these settings restored, as [`save`](Self::save).
    pub async fn save_all(&self, arm: &Arm, settings: SettingsBackup) {
        if settings.is_empty() {
            return;
        }
        self.lock().settings.append(settings);
        #[cfg(feature = "files")]
        if let Some((ledger, serial)) = of(arm).await {
            self.keep(&ledger, &serial);
        }
        #[cfg(not(feature = "files"))]
        let _ = arm;
    }

    /// True if a setting of this kind is to be restored.
    pub(crate) fn has(&self, id: u8) -> bool {
        let saved = self.lock();
        let mut settings = saved.settings.settings().iter();
        settings.any(|setting| setting.row().id == id)
    }

    /// Whether nothing has to be restored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lock().settings.is_empty()
    }

    /// The work goes on without: what is not kept is restored at the end of this process all the same.
    #[cfg(feature = "files")]
    fn keep(&self, ledger: &Ledger, serial: &str) {
        let mut saved = self.lock();
        let before = saved.kept.take().filter(|kept| kept.is_of(serial));
        match ledger.keep(serial, &saved.settings, before) {
            Ok(entry) => saved.kept = Some(entry),
            Err(error) => {
                warn!(%error, "the arm's previous settings cannot be saved: they are not restored \
                    if this process is killed");
            }
        }
    }

    /// The arm's queue restores them.
    pub fn forget(&self) {
        self.take().remove();
    }

    /// This program does not restore them: what is kept is for the next one.
    pub fn leave(&self) {
        self.take();
    }

    /// Restores them. If the future is dropped before its end nothing is forgotten, and all of them can be restored once more.
    ///
    /// # Errors
    /// As [`Arm::set`], at the first setting that the arm does not take; the others are not restored then.
    pub async fn restore(&self, arm: &Arm) -> Result<()> {
        let restoring = Restoring {
            of: self,
            saved: Some(self.take()),
        };
        let mut settings = restoring.settings();
        let restored = settings.restore(arm).await;
        let saved = restoring.over();
        restored?;
        saved.remove();
        Ok(())
    }

    /// After a failure: what was set going ends, so that nothing of it comes later, and the settings are restored as far as the
    /// arm takes them. The failure that is on its way to the user is the better story, so no other is told.
    pub async fn restore_after_failure(&self, arm: &Arm) {
        if self.is_empty() {
            return;
        }
        match arm.stop().await {
            Ok(()) => drop(self.restore(arm).await),
            Err(_) => self.leave(),
        }
    }

    fn take(&self) -> Saved {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, Saved> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Settings on their way to the arm. Dropped before they are there, it gives them back: a stop may end the wait for them.
struct Restoring<'a> {
    of: &'a SavedSettings,
    saved: Option<Saved>,
}

impl Restoring<'_> {
    fn settings(&self) -> SettingsBackup {
        let saved = self.saved.as_ref();
        saved.map_or_else(SettingsBackup::default, |saved| saved.settings.clone())
    }

    /// What was saved: it is not given back any more.
    fn over(mut self) -> Saved {
        self.saved.take().unwrap_or_default()
    }
}

impl Drop for Restoring<'_> {
    fn drop(&mut self) {
        if let Some(saved) = self.saved.take() {
            self.of.lock().gets_back(saved);
        }
    }
}

impl Saved {
    /// Has what was saved before as well.
    fn gets_back(&mut self, before: Self) {
        let since = std::mem::replace(self, before);
        // Restored in order: what was there first is restored last.
        let first = std::mem::replace(&mut self.settings, since.settings);
        self.settings.append(first);
        #[cfg(feature = "files")]
        if self.kept.is_none() {
            self.kept = since.kept;
        }
    }

    fn remove(self) {
        #[cfg(feature = "files")]
        remove(self.kept);
    }
}

#[cfg(not(feature = "files"))]
impl SavedSettings {
    /// Restores what ended processes have left changed: nothing is known of them without the feature `files`.
    #[allow(clippy::unused_async, reason = "as with the feature `files`")]
    pub async fn settle(_arm: &Arm, _access: Access) -> Settled {
        Settled::Nothing
    }
}

#[cfg(feature = "files")]
impl SavedSettings {
    /// Restores what ended processes have left changed: the process was killed, the line lost. Not while another process has the
    /// arm's settings changed, nor while the arm has commands in its queue, which may change them yet.
    /// An arm that fails here fails in the work too, which says it better.
    pub async fn settle(arm: &Arm, access: Access) -> Settled {
        if access == Access::Stops {
            return Settled::Nothing;
        }
        let Some((ledger, serial)) = of_any(arm).await else {
            return Settled::Nothing;
        };
        let Left { entries, others } = ledger.left(&serial);
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
        if whole.is_empty() || others {
            return damaged.map_or(Settled::Nothing, Settled::Damaged);
        }
        let mut names: Vec<_> = all.settings().iter().map(|set| set.row().name).collect();
        names.sort_unstable();
        names.dedup();
        if access == Access::Reads {
            return Settled::Left(names);
        }
        match restore_if_idle(arm, all).await {
            Ok(true) => {
                whole.into_iter().for_each(|entry| remove(Some(entry)));
                Settled::Restored(names)
            }
            Ok(false) => Settled::Later(names),
            Err(error) => {
                info!(%error, "the arm's previous settings cannot be restored");
                Settled::Left(names)
            }
        }
    }
}

/// Restores the settings of an arm whose queue is empty; whether it is.
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

/// Where the settings of this arm are kept, and under which serial number. Nowhere for an arm that ends with this process, and
/// one without a serial number.
#[cfg(feature = "files")]
async fn of(arm: &Arm) -> Option<(Ledger, String)> {
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

/// The same, if the settings of any arm are kept: nothing is asked otherwise.
#[cfg(feature = "files")]
async fn of_any(arm: &Arm) -> Option<(Ledger, String)> {
    let ledger = Ledger::at(crate::dirs::state()?.join("debts"));
    if arm.front_end().is_in_process() || ledger.is_empty() {
        return None;
    }
    of(arm).await
}
