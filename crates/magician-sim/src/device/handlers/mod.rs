//! What each command does, by chapter of the document, and what that rests on. A command that has
//! no handler, or a handler that names no assumption, does not compile.

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

/// A value that the controller can be asked for.
pub(crate) trait Report: Readable {
    /// What the value rests on, whatever else.
    const RESTS_ON: Assumption;

    /// All that the value rests on now: a strict controller reports none that rests on a choice
    /// alone.
    fn assumptions(_cx: &mut Context<'_>, _query: &Self::Query) -> AssumptionSet {
        Self::RESTS_ON.into()
    }

    /// The value at the present instant. Some reads leave a trace: a pin becomes the one addressed
    /// last.
    fn report(cx: &mut Context<'_>, query: &Self::Query) -> Self;
}

/// Something that can be set or ordered.
pub(crate) trait Apply: Writable {
    /// What it rests on, whatever else.
    const RESTS_ON: Assumption;

    /// All that it rests on now, as far as that shows before it is done: a strict controller does
    /// nothing that rests on a choice alone.
    fn assumptions(&self, _cx: &Context<'_>, _mode: ExecMode) -> AssumptionSet {
        Self::RESTS_ON.into()
    }

    /// Does it at the present instant, to what it is lent; the effects on the rest of the arm come
    /// after it.
    fn apply(&self, cx: &mut Context<'_>, mode: ExecMode) -> Effects;
}

/// The reply to a get: without parameters where a strict controller has no value to report.
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
        /// The reply to a get.
        pub(crate) fn report(
            cx: &mut Context<'_>,
            get: &Get,
            ctrl: Ctrl,
        ) -> Result<FrameBuf, EncodeError> {
            use magician_protocol::commands::*;
            match get {
                $( Get::$value(query) => reply::<$value>(cx, query, ctrl), )+
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
    };
}

macro_rules! apply {
    ($($command:ident)+) => {
        /// Counts what a set rests on; whether it is carried out.
        pub(crate) fn allows(cx: &mut Context<'_>, set: &Set, mode: ExecMode) -> bool {
            let assumptions = match set {
                $( Set::$command(command) => command.assumptions(cx, mode), )+
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            };
            cx.record.allows_all(set.row().id, assumptions)
        }

        /// Carries out a set; its effects on the rest of the arm are still to be applied.
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

/// A parameter set that is read from one expression and written by another. What was never set may
/// read as another assumption says. What is beyond a ceiling of motions is stored all the same, or
/// as the ceiling.
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
            const RESTS_ON: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

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
            const RESTS_ON: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

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

/// Parameter sets that are stored and read back, and have no other effect on the spot: each with
/// what it rests on.
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

/// Parameter sets as [`stored`], but kept in the flash.
macro_rules! kept {
    ($( $layout:ident in $field:ident: $assumption:ident $(, at first $default:ident)?; )+) => {$(
        $crate::device::handlers::parameter!(
            $layout: $assumption,
            |cx| cx.store.flash().$field,
            |value| cx.store.write_flash(|flash| flash.$field = value)
            $(, if cx.store.flash().$field == cx.new_flash().$field => $default)?
        );
    )+};
}

/// Commands that this simulation accepts, answers and finishes, and does not act on.
macro_rules! not_simulated {
    ($( $layout:ident: $assumption:ident; )+) => {$(
        impl $crate::device::handlers::Apply for $layout {
            const RESTS_ON: $crate::fidelity::Assumption = $crate::fidelity::Assumption::$assumption;

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
