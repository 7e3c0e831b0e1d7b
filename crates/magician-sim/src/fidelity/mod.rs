//! Assumptions behind each answer: facts about the real arm, and choices where no fact is known.
//!
//! Every behaviour of the virtual arm has an [`Assumption`] with a [`Confidence`]. The controller
//! counts the assumptions of its answers ([`Controller::fidelity`](crate::Controller::fidelity)). A
//! strict controller ([`Strictness`]) does not carry out what relies on a choice alone, so a
//! program that runs on it depends on known behaviour only.

mod assumptions;

pub use assumptions::Assumption;

use std::fmt;

/// Confidence that the real arm behaves as assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Confidence {
    /// Measured on real arms.
    Measured,
    /// The vendor's document or code for this arm.
    Vendor,
    /// The vendor's code for the sibling arm.
    Sibling,
    /// Third-party code or text.
    ThirdParty,
    /// No source: a choice of this project.
    Choice,
}

impl Confidence {
    /// All levels, highest confidence first.
    pub const ALL: [Self; 5] = [
        Self::Measured,
        Self::Vendor,
        Self::Sibling,
        Self::ThirdParty,
        Self::Choice,
    ];

    /// Letter in the firmware profile: M, V, VL, T, G.
    #[must_use]
    pub const fn letter(self) -> &'static str {
        match self {
            Self::Measured => "M",
            Self::Vendor => "V",
            Self::Sibling => "VL",
            Self::ThirdParty => "T",
            Self::Choice => "G",
        }
    }
}

/// Reaction of a strict controller to an assumption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strictness {
    /// Carried out: it is a fact.
    Fact,
    /// Refused: it is a choice that decides an action or an answer.
    Refused,
    /// Carried out although it is a choice, for the reason in the text.
    Kept(&'static str),
}

/// Document that states an assumption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Authority {
    /// A section of the reference model of the arm: `docs/reference/MODEL.md` of the repository.
    Model(&'static str),
    /// An erratum to the vendor's protocol document: `docs/reference/ERRATA.md` of the repository.
    Erratum(&'static str),
    /// No source: a choice of this project.
    NoSource,
}

impl Authority {
    const fn of(section: &'static str) -> Self {
        match section.as_bytes() {
            [b'0'..=b'9', ..] => Self::Model(section),
            [b'E', ..] => Self::Erratum(section),
            // `(none)`: neither document says anything.
            _ => Self::NoSource,
        }
    }

    /// Page and anchor below `docs/reference` in the repository: `MODEL.md#section-7`,
    /// `ERRATA.md#e07`. `None` without a source.
    #[must_use]
    pub fn link(self) -> Option<String> {
        match self {
            Self::Model(section) => Some(format!("MODEL.md#section-{section}")),
            Self::Erratum(number) => Some(format!("ERRATA.md#{}", number.to_lowercase())),
            Self::NoSource => None,
        }
    }
}

impl fmt::Display for Authority {
    /// Formats a citation: `model 7`, `errata E07`, `no source`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&match self {
            Self::Model(section) => format!("model {section}"),
            Self::Erratum(number) => format!("errata {number}"),
            Self::NoSource => "no source".to_owned(),
        })
    }
}

macro_rules! list_assumptions {
    ($( $name:ident $confidence:ident $section:literal $says:literal $($strict:ident $($why:literal)?)?; )+) => {
        /// An assumption about the behaviour of the arm.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Assumption {
            $( #[doc = concat!("Here ", $says, " (", $section, ").")] $name, )+
        }

        impl Assumption {
            /// All assumptions, by chapter.
            pub const ALL: &'static [Self] = &[ $( Self::$name, )+ ];

            /// Name of the assumption.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $( Self::$name => stringify!($name), )+ }
            }

            /// Confidence that the real arm behaves as assumed.
            #[must_use]
            pub const fn confidence(self) -> $crate::fidelity::Confidence {
                match self { $( Self::$name => $crate::fidelity::Confidence::$confidence, )+ }
            }

            /// Section of the reference model, erratum (`E07`), or `(none)`.
            #[must_use]
            pub const fn section(self) -> &'static str {
                match self { $( Self::$name => $section, )+ }
            }

            /// Document that states the assumption.
            #[must_use]
            pub const fn authority(self) -> $crate::fidelity::Authority {
                $crate::fidelity::Authority::of(self.section())
            }

            /// Behaviour of the virtual arm, a sentence without a full stop.
            #[must_use]
            pub const fn says(self) -> &'static str {
                match self { $( Self::$name => $says, )+ }
            }

            /// Reaction of a strict controller.
            #[must_use]
            pub const fn strictness(self) -> $crate::fidelity::Strictness {
                match self { $( Self::$name => $crate::fidelity::list_assumptions!(@ $($strict $($why)?)?), )+ }
            }
        }
    };
    (@) => { $crate::fidelity::Strictness::Fact };
    (@ refused) => { $crate::fidelity::Strictness::Refused };
    (@ kept $why:literal) => { $crate::fidelity::Strictness::Kept($why) };
}

use list_assumptions;

/// A set of assumptions: one bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct AssumptionSet([u64; Self::WORDS]);

impl AssumptionSet {
    const WORDS: usize = Assumption::ALL.len().div_ceil(64);

    /// Adds an assumption.
    pub(crate) fn and(mut self, assumption: Assumption) -> Self {
        let at = assumption as usize;
        if let Some(word) = self.0.get_mut(at / 64) {
            *word |= 1 << (at % 64);
        }
        self
    }

    /// Adds an assumption if a condition holds.
    pub(crate) fn and_if(self, condition: bool, assumption: Assumption) -> Self {
        if condition {
            self.and(assumption)
        } else {
            self
        }
    }

    /// Returns the union of both sets.
    pub(crate) fn union(mut self, other: Self) -> Self {
        for (word, more) in self.0.iter_mut().zip(other.0) {
            *word |= more;
        }
        self
    }

    /// Removes the first assumption, in the order of the list.
    pub(crate) fn take(&mut self) -> Option<Assumption> {
        let at = self.0.iter().position(|word| *word != 0)?;
        let word = self.0.get_mut(at)?;
        let bit = word.trailing_zeros() as usize;
        // Clears the lowest bit.
        *word &= *word - 1;
        Assumption::ALL.get(at * 64 + bit).copied()
    }
}

impl From<Assumption> for AssumptionSet {
    fn from(assumption: Assumption) -> Self {
        Self::default().and(assumption)
    }
}

/// Number of uses of each assumption since power-up.
#[derive(Clone, Debug)]
pub struct Fidelity {
    uses: [u64; Assumption::ALL.len()],
}

impl Default for Fidelity {
    fn default() -> Self {
        let uses = [0; Assumption::ALL.len()];
        Self { uses }
    }
}

impl Fidelity {
    /// Number of uses of an assumption. A strict controller also counts the uses that it refused.
    #[must_use]
    pub fn uses(&self, assumption: Assumption) -> u64 {
        self.uses
            .get(assumption as usize)
            .copied()
            .unwrap_or_default()
    }

    /// Assumptions that were used, with their number of uses, by chapter.
    pub fn iter(&self) -> impl Iterator<Item = (Assumption, u64)> + '_ {
        let all = Assumption::ALL
            .iter()
            .map(|assumption| (*assumption, self.uses(*assumption)));
        all.filter(|(_, uses)| *uses > 0)
    }

    /// Counts a use and returns true for the first.
    pub(crate) fn count(&mut self, assumption: Assumption) -> bool {
        let Some(uses) = self.uses.get_mut(assumption as usize) else {
            return false;
        };
        // A soak run may count for weeks.
        *uses = uses.saturating_add(1);
        *uses == 1
    }
}
