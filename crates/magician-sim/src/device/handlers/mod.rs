//! What each command does, by chapter of the document. A command that has no handler does not compile.

mod alarm;
mod arc;
mod calibration;
mod cp;
mod home;
mod info;
mod io;
mod jog;
mod lost_step;
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

/// A value that the controller can be asked for.
pub(crate) trait Report: Readable {
    /// The value at the present instant. Some reads leave a trace: a pin becomes the one addressed last.
    fn report(cx: &mut Context<'_>, query: &Self::Query) -> Self;
}

/// Something that can be set or ordered.
pub(crate) trait Apply: Writable {
    /// Does it at the present instant, to what it is lent; the effects on the rest of the arm come after it.
    fn apply(&self, cx: &mut Context<'_>, mode: ExecMode) -> Effects;
}

macro_rules! report {
    ($($value:ident)+) => {
        /// The reply to a get.
        pub(crate) fn report(
            cx: &mut Context<'_>,
            get: &Get,
            id: u8,
            ctrl: Ctrl,
        ) -> Result<FrameBuf, EncodeError> {
            use magician_protocol::commands::*;
            match get {
                $( Get::$value(query) => FrameBuf::encode(id, ctrl, &$value::report(cx, query)), )+
            }
        }
    };
}

macro_rules! apply {
    ($($command:ident)+) => {
        /// Carries out a set; its effects on the rest of the arm are still to be applied.
        pub(crate) fn apply(cx: &mut Context<'_>, set: &Set, mode: ExecMode) -> Effects {
            match set {
                $( Set::$command(command) => command.apply(cx, mode), )+
            }
        }
    };
}

magician_protocol::for_each_readable!(report);
magician_protocol::for_each_writable!(apply);

/// A parameter set that is read from one expression and written by another.
macro_rules! parameter {
    ($layout:ident, |$cx:ident| $read:expr, |$value:ident| $write:expr) => {
        impl $crate::device::handlers::Report for $layout {
            fn report(
                $cx: &mut $crate::device::context::Context<'_>,
                _: &magician_protocol::NoArgs,
            ) -> Self {
                $read
            }
        }

        impl $crate::device::handlers::Apply for $layout {
            fn apply(
                &self,
                $cx: &mut $crate::device::context::Context<'_>,
                _: $crate::device::effect::ExecMode,
            ) -> $crate::device::effect::Effects {
                let $value = *self;
                $write;
                $crate::device::effect::Effects::none()
            }
        }
    };
}

/// Parameter sets that are stored and read back, and have no other effect on the spot.
macro_rules! stored {
    ($($layout:ident in $field:ident),+ $(,)?) => {$(
        $crate::device::handlers::parameter!(
            $layout,
            |cx| cx.store.settings.$field,
            |value| cx.store.settings.$field = value
        );
    )+};
}

/// Parameter sets as [`stored`], but kept in the flash.
macro_rules! kept {
    ($($layout:ident in $field:ident),+ $(,)?) => {$(
        $crate::device::handlers::parameter!(
            $layout,
            |cx| cx.store.flash().$field,
            |value| cx.store.write_flash(|flash| flash.$field = value)
        );
    )+};
}

/// Commands that this simulation accepts, answers and finishes, and does not act on.
macro_rules! not_simulated {
    ($($layout:ident),+ $(,)?) => {$(
        impl $crate::device::handlers::Apply for $layout {
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
