//! Methods that a first program needs: connect, home, move, stop.

use magician_protocol::Set;
use magician_protocol::commands::Pose;

use super::Arm;
use crate::{IntoTarget, Options, Result, RunSummary};

/// Defines blocking methods that forward their arguments and wait.
macro_rules! same {
    ($( $name:ident ( $( $arg:ident : $type:ty ),* ) -> $returns:ty; )+) => {
        impl Arm {
            $(
                #[doc = concat!("See [`crate::Arm::", stringify!($name), "`].")]
                ///
                /// # Errors
                /// As there.
                pub fn $name(&self $(, $arg: $type)*) -> Result<$returns> {
                    self.block(|arm| arm.$name($($arg),*))
                }
            )+
        }
    };
}
pub(super) use same;

impl Arm {
    /// See [`crate::Arm::connect`].
    ///
    /// # Errors
    /// As there, and [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) inside an async
    /// runtime.
    pub fn connect(target: impl IntoTarget) -> Result<Self> {
        Self::connect_with(target, Options::default())
    }
}

same! {
    home() -> ();
    pose() -> Pose;
    move_to(x: f32, y: f32, z: f32, r: f32) -> RunSummary;
    line_to(x: f32, y: f32, z: f32, r: f32) -> RunSummary;
    jump_to(x: f32, y: f32, z: f32, r: f32) -> RunSummary;
    run(commands: &[Set]) -> RunSummary;
    stop() -> ();
}
