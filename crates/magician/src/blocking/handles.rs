//! Blocking versions of the parts of an arm: queue, laser, homing, pins, motor outputs.

use magician_protocol::{AlarmSet, Set, Stepper};

use super::Arm;
use crate::{QueueIndex, Result, RunSummary};

/// Defines handles with blocking versions of the async methods.
macro_rules! handles {
    ($( $(#[$meta:meta])* $handle:ident by $hand_out:ident {
        $( $name:ident ( $( $arg:ident : $type:ty ),* ) -> $returns:ty; )*
    } )+) => {
        $(
            #[doc = concat!("See [`crate::", stringify!($handle), "`].")]
            #[derive(Clone, Copy, Debug)]
            pub struct $handle<'a> {
                arm: &'a Arm,
            }

            impl Arm {
                #[doc = concat!("See [`crate::Arm::", stringify!($hand_out), "`].")]
                $(#[$meta])*
                #[must_use]
                pub const fn $hand_out(&self) -> $handle<'_> {
                    $handle { arm: self }
                }
            }

            impl $handle<'_> {
                $(
                    #[doc = concat!("See [`crate::", stringify!($handle), "::", stringify!($name), "`].")]
                    ///
                    /// # Errors
                    /// As there.
                    pub fn $name(self $(, $arg: $type)*) -> Result<$returns> {
                        self.arm.block(|arm| arm.$hand_out().$name($($arg),*))
                    }
                )*
            }
        )+
    };
}

handles! {
    Queue by queue {
        start() -> ();
        start_if_empty() -> bool;
        clear() -> ();
        left_space() -> u32;
        current_index() -> QueueIndex;
    }
    Laser by laser {
        is_on() -> Option<bool>;
        check_off() -> ();
        switch_off() -> ();
    }
    Homing by homing {
        is_homed() -> Option<bool>;
        check() -> ();
    }
    Pins by pins {
        input(address: u8) -> bool;
        wait_for_input(address: u8, high: bool) -> RunSummary;
        drive(command: &Set) -> ();
    }
    Motors by motors {
        stop() -> ();
    }
    #[doc(hidden)]
    FrontEnd by front_end {
        tool_is_unknown(alarms: &AlarmSet) -> bool;
    }
}

impl Motors<'_> {
    /// See [`crate::Motors::running`].
    #[must_use]
    pub fn running(self) -> Vec<Stepper> {
        self.arm.owner.arm.motors().running()
    }
}
