//! The C structures, packed, and the rows of the protocol that they are laid out as (interface section 3).
//!
//! They are bytes here. What the bytes mean is written once, in the protocol's table; their members have names in the
//! C headers and in the Python modules.
#![allow(unsafe_code)]

use magician::commands;
use magician::protocol::{Layout, Writer};

use crate::code::Fault;
use crate::pointer::Plain;

/// A C structure that is laid out as a row of the protocol.
pub trait Structure: Plain {
    /// The row's value.
    type Row: Layout;

    /// What the bytes say.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams), should they fit no value.
    fn row(&self) -> Result<Self::Row, Fault>;

    /// The bytes that say it.
    fn of(row: &Self::Row) -> Self;
}

/// A C structure, its bytes and, where it is one, its row.
macro_rules! structures {
    ($( $name:ident $size:literal $(= $row:ident)?; )*) => {
        $(
            #[doc = concat!("`", stringify!($name), "`, ", stringify!($size), " bytes.")]
            #[derive(Clone, Copy, Debug)]
            #[repr(transparent)]
            pub struct $name(pub [u8; $size]);

            // SAFETY: an array of bytes.
            unsafe impl Plain for $name {}

            $(
                const _: () = assert!(matches!(<commands::$row as Layout>::INFO.size(), Some($size)));

                impl Structure for $name {
                    type Row = commands::$row;

                    fn row(&self) -> Result<Self::Row, Fault> {
                        Self::Row::decode(&self.0).map_err(|error| Fault::invalid(error.to_string()))
                    }

                    fn of(row: &Self::Row) -> Self {
                        let mut bytes = [0; $size];
                        row.encode(&mut Writer::new(&mut bytes));
                        Self(bytes)
                    }
                }
            )?
        )*

        /// Every structure by its C name, with its bytes.
        pub const STRUCTURES: &[(&str, usize)] = &[$((stringify!($name), $size)),*];
    };
}

structures! {
    Pose 32 = Pose;
    HOMEParams 16 = HomeParams;
    HOMECmd 4 = HomeCmd;
    JOGCmd 2 = JogCmd;
    PTPCmd 17 = PtpCmd;
    PTPCommonParams 8 = PtpCommonParams;
    ConnectInfo 336;
}
