//! The packed C structures of the vendor's headers, and the rows of the protocol with the same
//! layout.
//!
//! Here they are plain bytes. Their meaning is defined once, in the protocol's table; the names of
//! their members are in the C headers and the Python modules.
#![allow(unsafe_code)]

use magician::commands;
use magician::protocol::{DecodeError, Layout, PoList, Writer};

use crate::code::Fault;
use crate::pointer::Plain;

/// Converts a decoding error of the caller's bytes into a fault.
pub(crate) fn decode_fault(error: DecodeError) -> Fault {
    Fault::invalid(error.to_string())
}

/// C structure with the layout of a protocol row.
pub trait Structure: Plain {
    /// Value of that row.
    type Row: Layout;

    /// Decodes the bytes.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) if the bytes are no valid value.
    fn row(&self) -> Result<Self::Row, Fault>;

    /// Encodes a row.
    fn of(row: &Self::Row) -> Self;
}

/// Size of a row in bytes. `usize::MAX` if it is variable, which fits no structure.
const fn size_of_row<T: Layout>() -> usize {
    match T::INFO.size() {
        Some(size) => size,
        None => usize::MAX,
    }
}

/// Declares C structures: name, size in bytes, and the row if there is one.
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
                        Self::Row::decode(&self.0).map_err(decode_fault)
                    }

                    fn of(row: &Self::Row) -> Self {
                        let mut bytes = [0; $size];
                        row.encode(&mut Writer::new(&mut bytes));
                        Self(bytes)
                    }
                }
            )?
        )*

        /// All structures: C name and size in bytes.
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
    // Sources disagree: 16 bytes, or 12 on Windows. The wrappers that could be read have 16. One
    // with 12 is not overrun either, because Python's `ctypes` allocates at least 16 bytes for a
    // structure.
    DeviceCountInfo 16 = DeviceInfo;
    UpgradeFWReadyCmd (4 + size_of::<usize>());
    DevInfo 112;
    ConnectInfo 336;
}

/// Structure that, together with a list of outputs, makes a move that switches outputs on its way.
pub trait Switching: Structure {
    /// Row of the combined command.
    type With: Layout;

    /// Combines the move with the outputs.
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
    /// Converts the version reported by the arm: three numbers of the firmware. The hardware
    /// version is 0, because nothing certain is known of it (errata E16).
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
