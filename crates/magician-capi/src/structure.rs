//! The C structures, packed, and the rows of the protocol that they are laid out as in the vendor's headers.
//!
//! They are bytes here. What the bytes mean is written once, in the protocol's table; their members have names in the
//! C headers and in the Python modules.
#![allow(unsafe_code)]

use magician::commands;
use magician::protocol::{DecodeError, Layout, PoList, Writer};

use crate::code::Fault;
use crate::pointer::Plain;

/// Bytes of the caller's that are no value.
pub(crate) fn unfit(error: DecodeError) -> Fault {
    Fault::invalid(error.to_string())
}

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

/// The bytes of a row; more than any structure has, should their number not be fixed.
const fn size_of_row<T: Layout>() -> usize {
    match T::INFO.size() {
        Some(size) => size,
        None => usize::MAX,
    }
}

/// A C structure, its bytes and, where it is one, its row.
macro_rules! structures {
    ($( $name:ident $size:tt $(= $row:ident)?; )*) => {
        $(
            #[doc = concat!("`", stringify!($name), "`, `", stringify!($size), "` bytes.")]
            #[derive(Clone, Copy, Debug)]
            #[repr(transparent)]
            #[allow(unused_parens)]
            pub struct $name(pub [u8; $size]);

            // SAFETY: an array of bytes.
            unsafe impl Plain for $name {}

            $(
                const _: () = assert!(size_of_row::<commands::$row>() == $size);

                impl Structure for $name {
                    type Row = commands::$row;

                    fn row(&self) -> Result<Self::Row, Fault> {
                        Self::Row::decode(&self.0).map_err(unfit)
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
    Kinematics 8 = Kinematics;
    HOMEParams 16 = HomeParams;
    HOMECmd 4 = HomeCmd;
    AutoLevelingCmd 5 = SetAutoLeveling;
    EndEffectorParams 12 = EndEffectorParams;
    JOGJointParams 32 = JogJointParams;
    JOGCoordinateParams 32 = JogCoordinateParams;
    JOGLParams 8 = JogLParams;
    JOGCommonParams 8 = JogCommonParams;
    JOGCmd 2 = JogCmd;
    PTPJointParams 32 = PtpJointParams;
    PTPCoordinateParams 16 = PtpCoordinateParams;
    PTPLParams 8 = PtpLParams;
    PTPJumpParams 8 = PtpJumpParams;
    PTPJump2Params 12 = PtpJump2Params;
    PTPCommonParams 8 = PtpCommonParams;
    PTPCmd 17 = PtpCmd;
    PTPWithLCmd 21 = PtpWithLCmd;
    ParallelOutputCmd 4;
    CPParams 13 = CpParams;
    CPCmd 17 = CpCmd;
    CP2Cmd 17;
    CPCommonParams 8 = CpCommonParams;
    ARCParams 16 = ArcParams;
    ARCCmd 32 = ArcCmd;
    CircleCmd 36 = CircleCmd;
    ARCCommonParams 8 = ArcCommonParams;
    WAITCmd 4 = WaitCmd;
    TRIGCmd 5 = TrigCmd;
    IOMultiplexing 2 = IoMultiplexing;
    IODO 2 = IoDo;
    IOPWM 9 = IoPwm;
    IODI 2 = IoDi;
    IOADC 3 = IoAdc;
    EMotor 6 = EMotor;
    EMotorS 10 = EMotorS;
    WIFIIPAddress 5 = WifiIpAddress;
    WIFINetmask 4 = WifiNetmask;
    WIFIGateway 4 = WifiGateway;
    WIFIDNS 4 = WifiDns;
    FirmwareParams 1;
    FirmwareMode 2 = FirmwareMode;
    PluseCmd 24 = PulseMode;
    UserParams 32 = UserParams;
    PID 22;
    DeviceID 12 = DeviceId;
    DeviceVersion 8;
    // Two facts disagree, 16 bytes and, on Windows, 12. The wrappers that could be read have 16; and one with 12 is
    // not overrun either, for Python's `ctypes` keeps no structure in less than 16 bytes.
    DeviceCountInfo 16 = DeviceInfo;
    UpgradeFWReadyCmd (4 + size_of::<usize>());
    DevInfo 112;
    ConnectInfo 336;
}

/// The order that a structure and the outputs to switch on its way make together.
pub trait Switching: Structure {
    /// The order's row.
    type With: Layout;

    /// Puts the outputs to it.
    fn with(row: Self::Row, po: PoList) -> Self::With;
}

impl Switching for PTPCmd {
    type With = commands::PtpPoCmd;

    fn with(row: commands::PtpCmd, po: PoList) -> commands::PtpPoCmd {
        let commands::PtpCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
        } = row;
        commands::PtpPoCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
            po,
        }
    }
}

impl Switching for PTPWithLCmd {
    type With = commands::PtpPoWithLCmd;

    fn with(row: commands::PtpWithLCmd, po: PoList) -> commands::PtpPoWithLCmd {
        let commands::PtpWithLCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
            l,
        } = row;
        commands::PtpPoWithLCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
            l,
            po,
        }
    }
}

impl DeviceVersion {
    /// What the arm tells: three numbers of its firmware, and nothing certain of its hardware (errata E16).
    #[must_use]
    pub const fn of(row: &commands::DeviceVersion) -> Self {
        Self([
            row.major_version,
            row.minor_version,
            row.revision,
            0,
            0,
            0,
            0,
            0,
        ])
    }
}
