//! Constructors for the rows of the option table.

use super::super::WorkOption;
use super::{Change, DefaultValue, Need, OptionGroup, OptionKind, OptionSpec};
use crate::Format;

/// Row with only kind, group and unit.
const fn row(kind: OptionKind, group: OptionGroup, unit: &'static str) -> OptionSpec {
    OptionSpec {
        name: "",
        kind,
        unit,
        choices: &[],
        default: None,
        least: None,
        above: None,
        most: None,
        with: None,
        when: &[],
        group,
        usual: false,
        about: "",
        detail: "",
        off: "",
        usually: "",
        expects: "",
        placeholder: "",
        work: None,
        needs: None,
        contradicts: &[],
        formats: &[],
        usual_for: &[],
        changes: &[],
    }
}

pub(in crate::options) const fn number(group: OptionGroup, unit: &'static str) -> OptionSpec {
    row(OptionKind::Number, group, unit)
}

pub(in crate::options) const fn integer(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Integer, group, "")
}

pub(in crate::options) const fn point(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Point, group, "mm")
}

pub(in crate::options) const fn place(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Place, group, "mm")
}

pub(in crate::options) const fn area(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Area, group, "px")
}

/// Switch that is off by default.
pub(in crate::options) const fn switch(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Switch, group, "").default_value(DefaultValue::Switch(false))
}

/// Switch that is on by default; `off` describes the purpose of switching it off.
pub(in crate::options) const fn switch_off(group: OptionGroup, off: &'static str) -> OptionSpec {
    OptionSpec {
        off,
        ..row(OptionKind::Switch, group, "").default_value(DefaultValue::Switch(true))
    }
}

pub(in crate::options) const fn text(group: OptionGroup, unit: &'static str) -> OptionSpec {
    row(OptionKind::Text, group, unit)
}

pub(in crate::options) const fn list(group: OptionGroup) -> OptionSpec {
    row(OptionKind::List, group, "")
}

pub(in crate::options) const fn pens(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Pens, group, "")
}

pub(in crate::options) const fn choice(
    group: OptionGroup,
    choices: &'static [&'static str],
) -> OptionSpec {
    OptionSpec {
        choices,
        ..row(OptionKind::Choice, group, "")
    }
}

/// Choice whose default is the first word.
pub(in crate::options) const fn first_of(
    group: OptionGroup,
    choices: &'static [&'static str],
) -> OptionSpec {
    match choices {
        [first, ..] => choice(group, choices).default_value(DefaultValue::Word(first)),
        [] => choice(group, choices),
    }
}

/// Builder methods for a row.
impl OptionSpec {
    pub(in crate::options) const fn named(
        self,
        name: &'static str,
        about: &'static str,
        detail: &'static str,
    ) -> Self {
        Self {
            name,
            about,
            detail,
            ..self
        }
    }

    pub(in crate::options) const fn default_value(self, default: DefaultValue) -> Self {
        Self {
            default: Some(default),
            ..self
        }
    }

    pub(in crate::options) const fn default_text(self, usually: &'static str) -> Self {
        Self { usually, ..self }
    }

    pub(in crate::options) const fn above(self, number: f64) -> Self {
        Self {
            above: Some(number),
            ..self
        }
    }

    pub(in crate::options) const fn at_least(self, least: f64) -> Self {
        Self {
            least: Some(least),
            ..self
        }
    }

    pub(in crate::options) const fn at_most(self, most: f64) -> Self {
        Self {
            most: Some(most),
            ..self
        }
    }

    pub(in crate::options) const fn expects(
        self,
        expects: &'static str,
        placeholder: &'static str,
    ) -> Self {
        Self {
            expects,
            placeholder,
            ..self
        }
    }

    /// Makes another option a requirement: without it this one is refused.
    pub(in crate::options) const fn needs(
        self,
        name: &'static str,
        values: &'static [&'static str],
    ) -> Self {
        Self {
            needs: Some(Need { name, values }),
            ..self.with(name, values)
        }
    }

    /// Binds the option to another one, without which it has no effect.
    pub(in crate::options) const fn with(
        self,
        name: &'static str,
        when: &'static [&'static str],
    ) -> Self {
        Self {
            with: Some(name),
            when,
            ..self
        }
    }

    pub(in crate::options) const fn contradicts(self, names: &'static [&'static str]) -> Self {
        Self {
            contradicts: names,
            ..self
        }
    }

    /// Assigns the option to a kind of work; the other kind refuses it.
    pub(in crate::options) const fn of_work(self, work: WorkOption) -> Self {
        Self {
            work: Some(work),
            ..self
        }
    }

    pub(in crate::options) const fn for_formats(self, formats: &'static [Format]) -> Self {
        Self { formats, ..self }
    }

    pub(in crate::options) const fn usual_for(self, usual_for: &'static [Format]) -> Self {
        Self { usual_for, ..self }
    }

    pub(in crate::options) const fn changes(
        self,
        changes: &'static [(&'static [Format], Change)],
    ) -> Self {
        Self { changes, ..self }
    }
}
