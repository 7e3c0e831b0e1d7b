//! Handlers of all commands, by chapter of the document, with their assumptions.
//!
//! A command without a handler does not compile, and neither does a handler that names no
//! assumption. Most parameter sets need no code of their own: the macros `stored`, `kept` and
//! `not_simulated` make their handlers.

mod alarm;
mod arc;
mod calibration;
mod cp;
mod home;
mod info;
mod io;
mod jog;
mod lost_step;
mod motion;
mod pose;
mod ptp;
mod queue;
mod teach;
mod tool;
mod trigger;
mod wait;
mod wifi;

use magician_protocol::{Ctrl, EncodeError, FrameBuf, Get, Readable, Set, Writable};

use super::context::Context;
use super::effect::{Effects, ExecMode};
use crate::fidelity::{Assumption, AssumptionSet};

/// A value that can be read.
pub(crate) trait Report: Readable {
    /// Assumption that always applies to the value.
    const ASSUMPTION: Assumption;

    /// All assumptions behind the value at present. A strict controller does not report a value
    /// that relies on a choice without a source.
    fn assumptions(_cx: &mut Context<'_>, _query: &Self::Query) -> AssumptionSet {
        Self::ASSUMPTION.into()
    }

    /// Returns the value at the present instant. Reading may have side effects: a pin becomes the
    /// one addressed last.
    fn report(cx: &mut Context<'_>, query: &Self::Query) -> Self;
}

/// A command that can be set or executed.
pub(crate) trait Apply: Writable {
    /// Assumption that always applies to the command.
    const ASSUMPTION: Assumption;

    /// All assumptions behind the command at present, as far as they are known before it is carried
    /// out. A strict controller does not carry out a command that relies on a choice without a
    /// source.
    fn assumptions(&self, _cx: &Context<'_>, _mode: ExecMode) -> AssumptionSet {
        Self::ASSUMPTION.into()
    }

    /// Carries the command out on the borrowed parts, and returns its effects on the rest of the
    /// arm.
    fn apply(&self, cx: &mut Context<'_>, mode: ExecMode) -> Effects;
}

/// Encodes the reply to a get; without parameters if a strict controller does not report the value.
fn reply<T: Report>(
    cx: &mut Context<'_>,
    query: &T::Query,
    ctrl: Ctrl,
) -> Result<FrameBuf, EncodeError> {
    let id = T::ROW.id;
    let assumptions = T::assumptions(cx, query);
    if cx.record.allows_all(id, assumptions) {
        FrameBuf::encode(id, ctrl, &T::report(cx, query))
    } else {
        FrameBuf::new(id, ctrl, &[])
    }
}

macro_rules! report {
    ($($value:ident)+) => {
        /// Encodes the reply to a get.
        pub(crate) fn report(
            cx: &mut Context<'_>,
            get: &Get,
            ctrl: Ctrl,
        ) -> Result<FrameBuf, EncodeError> {
            use magician_protocol::commands::*;
            match get {
                $( Get::$value(query) => reply::<$value>(cx, query, ctrl), )+
                // Outside of this workspace the enum may grow, but our crates depend on each other
                // by exact version.
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
    };
}

macro_rules! apply {
    ($($command:ident)+) => {
        /// Counts the assumptions of a set and returns true if it may be carried out.
        pub(crate) fn allows(cx: &mut Context<'_>, set: &Set, mode: ExecMode) -> bool {
            let assumptions = match set {
                $( Set::$command(command) => command.assumptions(cx, mode), )+
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            };
            cx.record.allows_all(set.row().id, assumptions)
        }

        /// Carries out a set and returns its effects on the rest of the arm.
        pub(crate) fn apply(cx: &mut Context<'_>, set: &Set, mode: ExecMode) -> Effects {
            match set {
                $( Set::$command(command) => command.apply(cx, mode), )+
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
    };
}

magician_protocol::for_each_readable!(report);
magician_protocol::for_each_writable!(apply);

/// Makes the handlers of a parameter set with a read and a write expression.
///
/// `if` names the assumption of a value that was never set. `beyond` and `capped` select the
/// treatment of values above a ceiling: stored as sent, or stored as the ceiling (model section 6).
macro_rules! parameter {
    (
        $layout:ident: $assumption:ident,
        |$cx:ident| $read:expr,
        |$value:ident| $write:expr
        $(, if $unset:expr => $default:ident)?
        $(, beyond |$set:ident| $beyond:expr)?
        $(, capped |$capped:ident, $most:ident| $cap:expr)?
    ) => {
        impl $crate::device::handlers::Report for $layout {
            const ASSUMPTION: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

            $(
                fn assumptions(
                    $cx: &mut $crate::device::context::Context<'_>,
                    _: &magician_protocol::NoArgs,
                ) -> $crate::fidelity::AssumptionSet {
                    use $crate::fidelity::Assumption;
                    if $unset { Assumption::$default } else { Assumption::$assumption }.into()
                }
            )?

            fn report(
                $cx: &mut $crate::device::context::Context<'_>,
                _: &magician_protocol::NoArgs,
            ) -> Self {
                $read
            }
        }

        impl $crate::device::handlers::Apply for $layout {
            const ASSUMPTION: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

            $(
                fn assumptions(
                    &self,
                    _: &$crate::device::context::Context<'_>,
                    _: $crate::device::effect::ExecMode,
                ) -> $crate::fidelity::AssumptionSet {
                    let $set = self;
                    $crate::fidelity::AssumptionSet::from($crate::fidelity::Assumption::$assumption)
                        .and_if($beyond, $crate::fidelity::Assumption::BeyondCeilings)
                }
            )?

            $(
                fn assumptions(
                    &self,
                    cx: &$crate::device::context::Context<'_>,
                    _: $crate::device::effect::ExecMode,
                ) -> $crate::fidelity::AssumptionSet {
                    let ($capped, $most) = (&mut self.clone(), &cx.firmware.model.ceilings);
                    let beyond: bool = $cap;
                    $crate::fidelity::AssumptionSet::from($crate::fidelity::Assumption::$assumption)
                        .and_if(beyond, $crate::fidelity::Assumption::CappedWhenSet)
                }
            )?

            fn apply(
                &self,
                $cx: &mut $crate::device::context::Context<'_>,
                _: $crate::device::effect::ExecMode,
            ) -> $crate::device::effect::Effects {
                let $value = *self;
                $(
                    // The value is capped after its assumptions were counted on a copy.
                    let (mut $value, $most) = ($value, &$cx.firmware.model.ceilings);
                    let $capped = &mut $value;
                    let _: bool = $cap;
                )?
                $write;
                $crate::device::effect::Effects::none()
            }
        }
    };
}

/// Makes the handlers of parameter sets that are stored and read back without another effect at
/// once.
macro_rules! stored {
    ($(
        $layout:ident in $($field:ident).+: $assumption:ident
        $(, at first $default:ident)?
        $(, beyond |$set:ident| $beyond:expr)?
        $(, capped |$capped:ident, $most:ident| $cap:expr)?;
    )+) => {$(
        $crate::device::handlers::parameter!(
            $layout: $assumption,
            |cx| cx.store.settings.$($field).+,
            |value| cx.store.settings.$($field).+ = value
            $(, if !cx.was_set::<$layout>() => $default)?
            $(, beyond |$set| $beyond)?
            $(, capped |$capped, $most| $cap)?
        );
    )+};
}

/// Like [`stored`], but kept in the flash.
macro_rules! kept {
    ($( $layout:ident in $field:ident: $assumption:ident $(, at first $default:ident)?; )+) => {$(
        $crate::device::handlers::parameter!(
            $layout: $assumption,
            |cx| cx.store.flash().$field,
            |value| cx.store.write_flash(|flash| flash.$field = value)
            // The flash does not record what was set, so compare with that of a new arm.
            $(, if cx.store.flash().$field == cx.new_flash().$field => $default)?
        );
    )+};
}

/// Makes the handlers of commands that are accepted, answered and finished, but not simulated.
macro_rules! not_simulated {
    ($( $layout:ident: $assumption:ident; )+) => {$(
        impl $crate::device::handlers::Apply for $layout {
            const ASSUMPTION: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

            fn apply(
                &self,
                _: &mut $crate::device::context::Context<'_>,
                _: $crate::device::effect::ExecMode,
            ) -> $crate::device::effect::Effects {
                $crate::device::effect::Effect::NotSimulated.into()
            }
        }
    )+};
}

pub(crate) use {kept, not_simulated, parameter, stored};
