//! Settings that a verb changes for its own time and owes the arm back, however it ends: also when the process is killed, then
//! by the next verb that moves or sets.

mod ledger;

use std::cell::RefCell;
use std::rc::Rc;

use magician::commands::DeviceSn;
use magician::{Arm, Owed, Set};
use tracing::{info, warn};

use self::ledger::{Entry, Ledger, Left};
use crate::dirs;
use crate::failure::Failure;

/// What is owed. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Debts(Rc<RefCell<Owing>>);

#[derive(Debug, Default)]
struct Owing {
    owed: Owed,
    /// The file that says so, where the arm outlives this process.
    kept: Option<Entry>,
}

/// What a verb does with the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// It only reads.
    Reads,
    /// It moves or sets something, or may.
    Sets,
    /// It ends something that may be dangerous: nothing comes before that.
    Stops,
}

impl Access {
    /// Of what moves or sets only then.
    pub(crate) const fn sets_if(sets: bool) -> Self {
        match sets {
            true => Self::Sets,
            false => Self::Reads,
        }
    }
}

/// What came of the debts of processes that have ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Settled {
    /// Nothing is owed, or the arm does not tell its serial number.
    Nothing,
    /// These settings are given back.
    GivenBack(Vec<&'static str>),
    /// These are still owed.
    Owed(Vec<&'static str>),
    /// These are owed until the arm has done what is in its queue.
    Later(Vec<&'static str>),
    /// The file that says what is owed is damaged.
    Damaged(String),
}

impl Debts {
    /// Owes the arm this setting. It is kept before this returns, so the setting is changed after.
    pub(crate) async fn owe(&self, arm: &Arm, setting: impl Into<Set>) {
        let mut owed = Owed::default();
        owed.owe(setting);
        self.owe_all(arm, owed).await;
    }

    /// Owes the arm these settings, as [`owe`](Self::owe).
    pub(crate) async fn owe_all(&self, arm: &Arm, owed: Owed) {
        if owed.is_empty() {
            return;
        }
        self.0.borrow_mut().owed.append(owed);
        if let Some((ledger, serial)) = of(arm).await {
            self.keep(&ledger, &serial);
        }
    }

    /// The work goes on without: what is not kept is given back at the end of this process all the same.
    fn keep(&self, ledger: &Ledger, serial: &str) {
        let mut owing = self.0.borrow_mut();
        let before = owing.kept.take().filter(|kept| kept.is_of(serial));
        match ledger.keep(serial, &owing.owed, before) {
            Ok(entry) => owing.kept = Some(entry),
            Err(error) => {
                warn!(%error, "the arm's settings of before cannot be kept: if this is killed, nobody gives them back");
            }
        }
    }

    /// The queue gives back what is owed.
    pub(crate) fn forget(&self) {
        let Owing { kept, .. } = self.0.take();
        remove(kept);
    }

    /// This verb does not give it back: what is kept is for the next one.
    pub(crate) fn leave(&self) {
        self.0.take();
    }

    /// Gives the arm back what is owed.
    pub(crate) async fn pay(&self, arm: &Arm) -> Result<(), Failure> {
        let Owing { mut owed, kept } = self.0.take();
        owed.give_back(arm).await?;
        remove(kept);
        Ok(())
    }

    /// After a verb that ended badly: what it set going ends, so that nothing of it comes later,
    /// and the settings are given back as far as the arm takes them. The failure that is on its
    /// way to the user is the better story, so no other is told.
    pub(crate) async fn pay_after_failure(&self, arm: &Arm) {
        if self.0.borrow().owed.is_empty() {
            return;
        }
        match arm.stop().await {
            Ok(_) => drop(self.pay(arm).await),
            Err(_) => self.leave(),
        }
    }

    /// Gives the arm back what verbs owe it that have ended without: the process was killed, the line lost. Not while another
    /// process owes it something, nor while the arm has commands in its queue, which may change the settings yet.
    /// An arm that fails here fails in the work too, which says it better.
    pub(crate) async fn settle(arm: &Arm, access: Access) -> Settled {
        if access == Access::Stops {
            return Settled::Nothing;
        }
        let Some((ledger, serial)) = of_debtor(arm).await else {
            return Settled::Nothing;
        };
        let Left { entries, others } = ledger.left(&serial);
        let mut owed = Owed::default();
        let (mut whole, mut damaged) = (Vec::new(), None);
        for (entry, settings) in entries {
            match settings {
                Some(settings) => {
                    owed.append(settings);
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
        let mut names: Vec<_> = owed.settings().iter().map(|set| set.row().name).collect();
        names.sort_unstable();
        names.dedup();
        if access == Access::Reads {
            return Settled::Owed(names);
        }
        match give_back(arm, owed).await {
            Ok(true) => {
                whole.into_iter().for_each(|entry| remove(Some(entry)));
                Settled::GivenBack(names)
            }
            Ok(false) => Settled::Later(names),
            Err(error) => {
                info!(%error, "the arm does not take its settings of before");
                Settled::Owed(names)
            }
        }
    }
}

impl Settled {
    /// The note for the user.
    pub(crate) fn text(&self) -> Option<String> {
        let before = "an earlier command ended without giving back the arm's settings";
        Some(match self {
            Self::Nothing => return None,
            Self::GivenBack(names) => format!("{before}; given back now: {}", names.join(", ")),
            Self::Owed(names) => format!(
                "{before}; the next command that moves or sets gives back: {}",
                names.join(", ")
            ),
            Self::Later(names) => format!(
                "{before}; the first command after the arm's queue is empty gives back: {}",
                names.join(", ")
            ),
            Self::Damaged(path) => format!(
                "{before}, and {path} is damaged: compare the speeds with `magician get PTPCommonParams` and `magician get CPParams`"
            ),
        })
    }
}

/// Gives the settings back to an arm whose queue is empty; whether it is.
async fn give_back(arm: &Arm, mut owed: Owed) -> Result<bool, magician::Error> {
    let (_, places) = arm.stats().await?;
    let empty = arm.left_space().await? >= places;
    if empty {
        owed.give_back(arm).await?;
    }
    Ok(empty)
}

fn remove(entry: Option<Entry>) {
    let Some(entry) = entry else {
        return;
    };
    let path = entry.path().display().to_string();
    if let Err(error) = entry.remove() {
        warn!(%error, "{path} cannot be removed: the arm gets settings back that it has");
    }
}

/// Where debts to this arm are kept, and under which serial number. Nowhere for an arm that ends with this process, and one
/// without a serial number.
async fn of(arm: &Arm) -> Option<(Ledger, String)> {
    if arm.is_virtual() {
        return None;
    }
    let ledger = Ledger::at(dirs::state()?.join("debts"));
    let serial = match arm.get::<DeviceSn>().await {
        Ok(serial) => serial.device_sn.to_string(),
        Err(error) => {
            info!(%error, "the arm does not tell its serial number: what it is owed is not kept");
            return None;
        }
    };
    let serial = serial.trim();
    (!serial.is_empty()).then(|| (ledger, serial.to_owned()))
}

/// The same, if anybody owes any arm anything: nothing is asked otherwise.
async fn of_debtor(arm: &Arm) -> Option<(Ledger, String)> {
    let ledger = Ledger::at(dirs::state()?.join("debts"));
    match arm.is_virtual() || ledger.is_empty() {
        true => None,
        false => of(arm).await,
    }
}
