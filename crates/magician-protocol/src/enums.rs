//! Flags and enums of single bytes, open to values without a name: an unknown byte is kept and
//! written back unchanged.

use core::fmt;

use crate::check::{Number, RangeError, check_number};
use crate::layout::Field;
use crate::wire::{EnumInfo, FieldType, Reader, Variant, Wire, Writer};
use crate::{DecodeError, Range, row::same_name};

/// A byte where 0 is off and anything else is on. The original byte is kept.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Flag(pub u8);

impl Flag {
    /// Off.
    pub const OFF: Self = Self(0);
    /// On.
    pub const ON: Self = Self(1);

    /// True if the byte is not 0.
    #[must_use]
    pub const fn is_on(self) -> bool {
        self.0 != 0
    }
}

impl From<bool> for Flag {
    fn from(on: bool) -> Self {
        Self(on.into())
    }
}

impl fmt::Debug for Flag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            0 => f.write_str("off"),
            1 => f.write_str("on"),
            byte => write!(f, "on({byte})"),
        }
    }
}

impl Wire for Flag {
    const TYPE: FieldType = FieldType::Flag;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        u8::read(reader).map(Self)
    }

    fn write(&self, writer: &mut Writer<'_>) {
        self.0.write(writer);
    }
}

impl EnumInfo {
    /// Name of a value. `None` if the value has no name.
    #[must_use]
    pub fn name_of(&self, value: u8) -> Option<&'static str> {
        let variant = self.variants.iter().find(|v| v.value == value)?;
        Some(variant.name)
    }

    /// Value of a name, ignoring case, `-` and `_`. `None` if no value has that name.
    #[must_use]
    pub fn value_of(&self, name: &str) -> Option<u8> {
        let variant = self.variants.iter().find(|v| same_name(v.name, name))?;
        Some(variant.value)
    }
}

macro_rules! open_enums {
    ($(
        $(#[$meta:meta])*
        $name:ident { $( $value:literal $variant:ident $doc:literal, )+ }
    )+) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $( #[doc = $doc] $variant, )+
            /// A value without a name, kept as received.
            Unknown(u8),
        }

        impl $name {
            /// The named values.
            pub const INFO: &'static EnumInfo = &EnumInfo {
                name: stringify!($name),
                variants: &[$( Variant { value: $value, name: stringify!($variant), doc: $doc }, )+],
            };
        }

        impl From<u8> for $name {
            fn from(value: u8) -> Self {
                match value {
                    $( $value => Self::$variant, )+
                    other => Self::Unknown(other),
                }
            }
        }

        impl From<$name> for u8 {
            fn from(value: $name) -> u8 {
                match value {
                    $( $name::$variant => $value, )+
                    $name::Unknown(other) => other,
                }
            }
        }

        impl Wire for $name {
            const TYPE: FieldType = FieldType::Enum($name::INFO);

            #[inline]
            fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
                u8::read(reader).map(Self::from)
            }

            #[inline]
            fn write(&self, writer: &mut Writer<'_>) {
                u8::from(*self).write(writer);
            }

            #[inline]
            fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
                check_number(Number::Integer(u8::from(*self).into()), field, range)
            }
        }
    )+};
}

open_enums! {
    /// Travel and target of a point-to-point move (document 1.10.5, errata E28).
    PtpMode {
        0 JumpXyz "Lift, joint transfer, descend; absolute x y z r.",
        1 MovjXyz "All joints together; absolute x y z r.",
        2 MovlXyz "Straight line; absolute x y z r.",
        3 JumpAngle "Lift, joint transfer, descend; absolute J1 to J4.",
        4 MovjAngle "All joints together; absolute J1 to J4.",
        5 MovlAngle "Straight line; absolute J1 to J4.",
        6 MovjAngleInc "All joints together; J1 to J4 relative to the start of the move.",
        7 MovlXyzInc "Straight line; x y z r relative to the start of the move.",
        8 MovjXyzInc "All joints together; x y z r relative to the start of the move.",
        9 JumpMovlXyz "Lift, straight transfer, descend; absolute x y z r.",
    }

    /// Direction of a jog; the axis is a joint or a coordinate (document 1.9.4, errata E25).
    JogCommand {
        0 Stop "Decelerate and stop.",
        1 Axis1Plus "J1 or x, positive.",
        2 Axis1Minus "J1 or x, negative.",
        3 Axis2Plus "J2 or y, positive.",
        4 Axis2Minus "J2 or y, negative.",
        5 Axis3Plus "J3 or z, positive.",
        6 Axis3Minus "J3 or z, negative.",
        7 Axis4Plus "J4 or r, positive.",
        8 Axis4Minus "J4 or r, negative.",
        9 RailPlus "Rail, positive.",
        10 RailMinus "Rail, negative.",
    }

    /// Reference of the numbers of a continuous-path segment (document 1.11.2).
    CpMode {
        0 Relative "Relative to the end of the previous segment.",
        1 Absolute "Coordinates in the base frame.",
    }

    /// Generation of the sliding rail (errata E15).
    RailVersion {
        0 V1 "First generation.",
        1 V2 "Second generation.",
    }

    /// Generation of a colour or infrared sensor (errata E42, E43).
    SensorVersion {
        0 V1 "First generation.",
        1 V2 "Second generation.",
    }

    /// Condition on which hand teaching reports a point (document 1.7.1).
    TeachTrigger {
        0 OnRelease "Once, on release of the unlock key.",
        1 Periodic "Periodically, while the unlock key is held.",
    }

    /// Function of an EIO pin (document 1.15.1, errata E40).
    IoFunction {
        0 None "No function.",
        1 DigitalOutput "Digital output.",
        2 Pwm "PWM output.",
        3 DigitalInput "Digital input.",
        4 AnalogInput "Analog input.",
        5 DigitalInputPullUp "Digital input with pull-up.",
        6 DigitalInputPullDown "Digital input with pull-down.",
    }

    /// Connector that a sensor is plugged into (errata E42).
    Port {
        0 Gp1 "GP1, on the base.",
        1 Gp2 "GP2, on the base.",
        2 Gp4 "GP4, on the forearm.",
        3 Gp5 "GP5, on the forearm.",
    }

    /// External motor output (document 1.15.6).
    Stepper {
        0 Stepper1 "First motor output.",
        1 Stepper2 "Second motor output.",
    }

    /// Signal that a trigger observes (document 1.14.1).
    TriggerMode {
        0 Level "Digital level.",
        1 Analog "Analog value.",
    }

    /// Comparison of a trigger (document 1.14.1, errata E35).
    TriggerCondition {
        0 EqualOrBelow "Digital level equal to the threshold; analog value below it.",
        1 DifferentOrAtMost "Digital level different from the threshold; analog value at or below it.",
        2 AtLeast "Analog value at or above the threshold.",
        3 Above "Analog value above the threshold.",
    }

    /// Elbow side of a SCARA arm; meaningless on the Magician.
    Handedness {
        0 Left "Left-handed.",
        1 Right "Right-handed.",
    }
}

impl PtpMode {
    /// True if the numbers are a pose (x, y, z and r), absolute or relative. False for an unknown
    /// mode.
    #[must_use]
    pub const fn is_pose(self) -> bool {
        matches!(
            self,
            Self::JumpXyz
                | Self::MovjXyz
                | Self::MovlXyz
                | Self::MovlXyzInc
                | Self::MovjXyzInc
                | Self::JumpMovlXyz
        )
    }

    /// True if the numbers are joint angles, absolute or relative. False for an unknown mode.
    #[must_use]
    pub const fn is_joint(self) -> bool {
        matches!(
            self,
            Self::JumpAngle | Self::MovjAngle | Self::MovlAngle | Self::MovjAngleInc
        )
    }

    /// True if the numbers and the rail position are added to the start of the move. False for an
    /// unknown mode.
    #[must_use]
    pub const fn is_relative(self) -> bool {
        matches!(
            self,
            Self::MovjAngleInc | Self::MovlXyzInc | Self::MovjXyzInc
        )
    }

    /// True if the end of the move follows from the numbers alone. False for an unknown mode.
    #[must_use]
    pub const fn is_absolute(self) -> bool {
        (self.is_pose() || self.is_joint()) && !self.is_relative()
    }

    /// True if the numbers are the pose at the end of the move. False for an unknown mode.
    #[must_use]
    pub const fn is_absolute_pose(self) -> bool {
        self.is_pose() && self.is_absolute()
    }

    /// True if the move lifts, travels and descends. False for an unknown mode.
    #[must_use]
    pub const fn is_jump(self) -> bool {
        matches!(self, Self::JumpXyz | Self::JumpAngle | Self::JumpMovlXyz)
    }

    /// True if the tool moves on a straight line from start to end. False for an unknown mode.
    #[must_use]
    pub const fn is_line(self) -> bool {
        matches!(self, Self::MovlXyz | Self::MovlAngle | Self::MovlXyzInc)
    }
}

impl JogCommand {
    /// Axis index, from 0 for J1 or x, and true for the positive direction. `None` for a stop, for
    /// the rail and for unknown values.
    #[must_use]
    pub const fn axis(self) -> Option<(usize, bool)> {
        Some(match self {
            Self::Axis1Plus => (0, true),
            Self::Axis1Minus => (0, false),
            Self::Axis2Plus => (1, true),
            Self::Axis2Minus => (1, false),
            Self::Axis3Plus => (2, true),
            Self::Axis3Minus => (2, false),
            Self::Axis4Plus => (3, true),
            Self::Axis4Minus => (3, false),
            // Stop and unknown values have no axis; the rail is not one of the four.
            _ => return None,
        })
    }
}
