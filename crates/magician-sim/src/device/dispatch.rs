//! From a command to the chapter that knows it. A command that no chapter knows does not compile.

use magician_protocol::{Ctrl, EncodeError, FrameBuf, Get, Readable, Set, Writable};

use crate::Micros;
use crate::device::Device;
use crate::device::handlers::trigger::Trigger;

/// A value that the controller can be asked for.
pub(crate) trait Report: Readable {
    /// The value at the present instant. Some reads leave a trace: a pin becomes the one addressed last.
    fn report(core: &mut Device, query: &Self::Query) -> Self;
}

/// Something that can be set or ordered.
pub(crate) trait Apply: Writable {
    /// Does it at the present instant.
    fn apply(&self, core: &mut Device, turn: Turn) -> Step;
}

/// How a command came to be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// On arrival.
    Immediate,
    /// At its place in the queue.
    Queued,
}

/// What a command leaves behind for the queue to wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing: it has finished.
    Done,
    /// The motion that it began.
    Moving,
    /// An instant.
    Waiting(Micros),
    /// An input.
    Triggered(Trigger),
    /// A stepper output that counts pulses.
    Turning(usize),
}

macro_rules! report {
    ($($value:ident)+) => {
        /// The reply to a get.
        pub(crate) fn report(
            core: &mut Device,
            get: &Get,
            id: u8,
            ctrl: Ctrl,
        ) -> Result<FrameBuf, EncodeError> {
            use magician_protocol::commands::*;
            match get {
                $( Get::$value(query) => FrameBuf::encode(id, ctrl, &$value::report(core, query)), )+
            }
        }
    };
}

macro_rules! apply {
    ($($order:ident)+) => {
        /// Carries out a set.
        pub(crate) fn apply(core: &mut Device, set: &Set, turn: Turn) -> Step {
            match set {
                $( Set::$order(order) => order.apply(core, turn), )+
            }
        }
    };
}

magician_protocol::for_each_readable!(report);
magician_protocol::for_each_writable!(apply);

/// A parameter set that is read from one expression and written by another.
macro_rules! parameter {
    ($layout:ident, |$core:ident| $read:expr, |$value:ident| $write:expr) => {
        impl $crate::device::dispatch::Report for $layout {
            fn report($core: &mut $crate::device::Device, _: &magician_protocol::NoArgs) -> Self {
                $read
            }
        }

        impl $crate::device::dispatch::Apply for $layout {
            fn apply(
                &self,
                $core: &mut $crate::device::Device,
                _: $crate::device::dispatch::Turn,
            ) -> $crate::device::dispatch::Step {
                let $value = *self;
                $write;
                $crate::device::dispatch::Step::Done
            }
        }
    };
}

/// Parameter sets that are stored and read back, and have no other effect on the spot.
macro_rules! stored {
    ($($layout:ident in $field:ident),+ $(,)?) => {$(
        $crate::device::dispatch::parameter!(
            $layout,
            |core| core.settings.$field,
            |value| core.settings.$field = value
        );
    )+};
}

/// Parameter sets as [`stored`], but kept in the flash.
macro_rules! kept {
    ($($layout:ident in $field:ident),+ $(,)?) => {$(
        $crate::device::dispatch::parameter!(
            $layout,
            |core| core.flash.$field,
            |value| core.write_flash(|flash| flash.$field = value)
        );
    )+};
}

/// Commands that this simulation accepts, answers and finishes, and does not act on.
macro_rules! not_simulated {
    ($($layout:ident),+ $(,)?) => {$(
        impl $crate::device::dispatch::Apply for $layout {
            fn apply(
                &self,
                core: &mut $crate::device::Device,
                _: $crate::device::dispatch::Turn,
            ) -> $crate::device::dispatch::Step {
                core.not_simulated(<Self as magician_protocol::Writable>::ROW)
            }
        }
    )+};
}

pub(crate) use {kept, not_simulated, parameter, stored};
