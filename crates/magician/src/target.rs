//! Addresses of arms, in the text form of `--port`.

use std::fmt;
use std::str::FromStr;

use magician_protocol::UDP_PORT;

use crate::ports::{self, Port};
use crate::{Error, ErrorCode, Result, Setting, SettingValue, message};

/// Address of an arm, in the text form of `--port`.
///
/// ```
/// use magician::{SimSpeed, Target};
///
/// assert_eq!("sim".parse::<Target>()?, Target::Sim(SimSpeed::Max));
/// assert_eq!("udp:192.168.1.5".parse::<Target>()?.to_string(), "udp:192.168.1.5:8899");
/// assert_eq!("/dev/ttyUSB0".parse::<Target>()?, Target::Serial("/dev/ttyUSB0".into()));
/// # Ok::<(), magician::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Target {
    /// `sim[:SPEED]`: a virtual arm inside this process.
    Sim(SimSpeed),
    /// A serial port: `/dev/ttyUSB0`, `COM3`, or the path of a pseudo-terminal.
    Serial(String),
    /// `usb:VENDOR:PRODUCT[:SERIAL]`: the serial port of a USB adapter, by its ids and, if there
    /// are several, its serial number, as in `usb:10c4:ea60`. After a replug it is found again
    /// under any name.
    Usb {
        /// Vendor id, four hexadecimal digits as text.
        vendor: u16,
        /// Product id, four hexadecimal digits as text.
        product: u16,
        /// Serial number of the adapter, not of the arm.
        serial: Option<String>,
    },
    /// `arm:SERIAL`: the arm with this serial number (GetDeviceSN), on any serial port with an
    /// arm's adapter; the ports are queried one after the other.
    Arm(String),
    /// `udp:HOST[:PORT]`: Wi-Fi; the port is 8899 unless given (errata E45).
    Udp {
        /// Host name or IP address.
        host: String,
        /// Port.
        port: u16,
    },
    /// `tcp:HOST:PORT`: a virtual arm, or a TCP bridge to a serial port.
    Tcp {
        /// Host name or IP address.
        host: String,
        /// Port.
        port: u16,
    },
    /// `ble:NAME`: Bluetooth LE, by name or address, in a build with the feature `ble`.
    Ble(String),
}

/// Conversion into a [`Target`], from a target or its text.
///
/// ```
/// use magician::{IntoTarget, Target};
///
/// assert_eq!("COM3".into_target()?, Target::Serial("COM3".into()));
/// assert!("nowhere".into_target().is_err());
/// # Ok::<(), magician::Error>(())
/// ```
pub trait IntoTarget {
    /// Returns the target.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) if the text is not a target.
    fn into_target(self) -> Result<Target>;
}

impl IntoTarget for Target {
    fn into_target(self) -> Result<Target> {
        Ok(self)
    }
}

impl IntoTarget for &Target {
    fn into_target(self) -> Result<Target> {
        Ok(self.clone())
    }
}

impl IntoTarget for &str {
    fn into_target(self) -> Result<Target> {
        self.parse()
    }
}

impl IntoTarget for &String {
    fn into_target(self) -> Result<Target> {
        self.parse()
    }
}

impl IntoTarget for String {
    fn into_target(self) -> Result<Target> {
        self.parse()
    }
}

/// Speed of a virtual arm's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimSpeed {
    /// Motion, waits and homing take no wall-clock time.
    Max,
    /// Factor over real time.
    Times(f64),
}

/// Accepted forms, for the error message.
const FORMS: &str = "sim[:SPEED], a serial path such as /dev/ttyUSB0 or COM3, usb:VENDOR:PRODUCT[:SERIAL], arm:SERIAL, udp:HOST[:PORT], tcp:HOST:PORT, ble:NAME";

impl FromStr for Target {
    type Err = Error;

    /// Parses as [`Target::parse`] does; a bare `sim` runs at full speed.
    fn from_str(text: &str) -> Result<Self> {
        Self::parse(text, SimSpeed::Max)
    }
}

impl Target {
    /// Parses a target. A virtual arm without a speed gets `speed`.
    ///
    /// ```
    /// use magician::{SimSpeed, Target};
    ///
    /// let visible = SimSpeed::Times(1.0);
    /// assert_eq!(Target::parse("sim", visible)?, Target::Sim(visible));
    /// assert_eq!(Target::parse("sim:max", visible)?, Target::Sim(SimSpeed::Max));
    /// # Ok::<(), magician::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) if the text is not a target.
    pub fn parse(text: &str, speed: SimSpeed) -> Result<Self> {
        // A Windows path such as `C:\x` also has a colon; its scheme is unknown, so it falls
        // through to the paths.
        let (scheme, rest) = match text.split_once(':') {
            Some((scheme, rest)) => (scheme, Some(rest)),
            None => (text, None),
        };
        match (scheme.to_ascii_lowercase().as_str(), rest) {
            ("sim", None) => Ok(Self::Sim(speed)),
            ("sim", Some(speed)) => parse_speed(speed).map(Self::Sim),
            ("udp", Some(address)) => {
                let (host, port) = split_port(address, "udp:HOST[:PORT]")?;
                // The port of the arm's Wi-Fi module (errata E45).
                let port = port.unwrap_or(UDP_PORT);
                Ok(Self::Udp { host, port })
            }
            ("tcp", Some(address)) => match split_port(address, "tcp:HOST:PORT")? {
                (host, Some(port)) => Ok(Self::Tcp { host, port }),
                (host, None) => Err(Error::new(
                    ErrorCode::InvalidPort,
                    message!("'{text}' has no port: write tcp:{host}:PORT", text, host),
                )),
            },
            ("ble", Some(name)) if !name.is_empty() => Ok(Self::Ble(name.to_owned())),
            ("usb", Some(ids)) => parse_usb(ids).ok_or_else(|| bad(text)),
            ("arm", Some(serial)) if !serial.is_empty() => Ok(Self::Arm(serial.to_owned())),
            // A known scheme with a bad rest is its own error, never a path.
            ("usb" | "arm" | "udp" | "tcp" | "ble", _) => Err(bad(text)),
            _ if is_serial(text) => Ok(Self::Serial(port_name(text).to_owned())),
            _ => Err(bad(text)),
        }
    }
}

fn bad(text: &str) -> Error {
    Error::new(
        ErrorCode::InvalidPort,
        message!("'{text}' is not a port; use {forms}", text, forms = FORMS),
    )
}

fn is_serial(text: &str) -> bool {
    is_com(text) || text.contains(['/', '\\'])
}

/// True for the name of a Windows port: `COM3`.
fn is_com(text: &str) -> bool {
    let com = text
        .get(..3)
        .is_some_and(|head| head.eq_ignore_ascii_case("com"));
    com && text.len() > 3 && text.bytes().skip(3).all(|byte| byte.is_ascii_digit())
}

/// Returns a port name as the system lists it. Windows needs `\\.\COM10` to open a port above 9,
/// and lists it as `COM10`.
fn port_name(text: &str) -> &str {
    let device = text.strip_prefix(r"\\.\");
    device.filter(|name| is_com(name)).unwrap_or(text)
}

/// Parses `VENDOR:PRODUCT[:SERIAL]`.
fn parse_usb(ids: &str) -> Option<Target> {
    let (vendor, rest) = ids.split_once(':')?;
    let (product, serial) = match rest.split_once(':') {
        Some((product, serial)) => (product, Some(serial)),
        None => (rest, None),
    };
    let id = |text: &str| {
        let digits =
            // Leading zeros may be missing, as in the output of some tools.
            (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        // `from_str_radix` also accepts a sign, which the digits check excludes.
        u16::from_str_radix(text, 16).ok().filter(|_| digits)
    };
    Some(Target::Usb {
        vendor: id(vendor)?,
        product: id(product)?,
        serial: match serial {
            Some("") => return None,
            serial => serial.map(str::to_owned),
        },
    })
}

fn parse_speed(text: &str) -> Result<SimSpeed> {
    if text.eq_ignore_ascii_case("max") {
        return Ok(SimSpeed::Max);
    }
    let number = text.strip_suffix('x').unwrap_or(text).parse::<f64>();
    match number {
        Ok(times) if times.is_finite() && times > 0.0 => Ok(SimSpeed::Times(times)),
        _ => Err(Error::new(
            ErrorCode::InvalidPort,
            message!(
                "'{text}' is not a speed for the virtual arm: write sim:max, or sim:N with a number above 0",
                text
            ),
        )),
    }
}

/// Splits `HOST`, `HOST:PORT`, `[V6]` or `[V6]:PORT`.
pub(crate) fn split_port(address: &str, form: &str) -> Result<(String, Option<u16>)> {
    let wrong = || {
        Error::new(
            ErrorCode::InvalidPort,
            message!("'{address}' is not an address; use {form}", address, form),
        )
    };
    let (host, port) = match address.strip_prefix('[') {
        Some(inner) => {
            let (host, rest) = inner.split_once(']').ok_or_else(wrong)?;
            match rest.strip_prefix(':') {
                Some(port) => (host, Some(port)),
                None if rest.is_empty() => (host, None),
                None => return Err(wrong()),
            }
        }
        // A second colon ends up in the port and fails there: a bare IPv6 address is ambiguous.
        None => match address.split_once(':') {
            Some((host, port)) => (host, Some(port)),
            None => (address, None),
        },
    };
    if host.is_empty() {
        return Err(wrong());
    }
    let port = match port.map(str::parse::<u16>) {
        None => None,
        Some(Ok(port)) if port > 0 => Some(port),
        Some(_) => return Err(wrong()),
    };
    Ok((host.to_owned(), port))
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // IPv6 addresses need brackets, so that the text parses to the same target again.
        let host_port = |f: &mut fmt::Formatter<'_>, scheme, host: &str, port| {
            if host.contains(':') {
                write!(f, "{scheme}:[{host}]:{port}")
            } else {
                write!(f, "{scheme}:{host}:{port}")
            }
        };
        match self {
            Self::Sim(SimSpeed::Max) => f.write_str("sim"),
            Self::Sim(SimSpeed::Times(times)) => write!(f, "sim:{times}"),
            Self::Serial(path) => f.write_str(path),
            Self::Usb {
                vendor,
                product,
                serial,
            } => {
                write!(f, "usb:{vendor:04x}:{product:04x}")?;
                serial.iter().try_for_each(|serial| write!(f, ":{serial}"))
            }
            Self::Arm(serial) => write!(f, "arm:{serial}"),
            Self::Udp { host, port } => host_port(f, "udp", host, *port),
            Self::Tcp { host, port } => host_port(f, "tcp", host, *port),
            Self::Ble(name) => write!(f, "ble:{name}"),
        }
    }
}

impl Target {
    /// Returns the one arm that is plugged into this computer; never the simulator.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if no serial port looks like an arm, or several
    /// do; the message lists the ports.
    pub fn discover() -> Result<Self> {
        Self::choose(&ports::ports()?)
    }

    fn choose(found: &[Port]) -> Result<Self> {
        let arms: Vec<_> = found.iter().filter(|port| port.likely_arm()).collect();
        Err(match arms.as_slice() {
            [arm] => return Ok(Self::Serial(arm.path.clone())),
            [] => {
                let found = ports::list(found);
                let message = message!(
                    "no arm found ({found}); is it switched on and plugged in?",
                    found
                );
                Error::new(ErrorCode::NoArm, message)
                    .remedy((Setting::Port, SettingValue::Any("PORT")), "names its port")
                    .remedy(
                        (Setting::Port, SettingValue::Word("sim")),
                        "uses a virtual arm",
                    )
            }
            several => {
                let several = ports::list(several.iter().copied());
                let message = message!("several arms found: {several}", several);
                Error::new(ErrorCode::SeveralArms, message)
                    .remedy((Setting::Port, SettingValue::Any("PORT")), "chooses one")
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;
    use crate::ports::Usb;

    #[test]
    fn reads_every_form() {
        let right = [
            ("sim", Target::Sim(SimSpeed::Max)),
            ("sim:max", Target::Sim(SimSpeed::Max)),
            ("SIM:2.5", Target::Sim(SimSpeed::Times(2.5))),
            ("com12", Target::Serial("com12".into())),
            (r"\\.\COM12", Target::Serial("COM12".into())),
            (r"\\.\pipe\arm", Target::Serial(r"\\.\pipe\arm".into())),
            ("./arm", Target::Serial("./arm".into())),
            (
                "/dev/serial/by-id/usb:1",
                Target::Serial("/dev/serial/by-id/usb:1".into()),
            ),
            (
                "usb:10C4:ea60",
                Target::Usb {
                    vendor: 0x10C4,
                    product: 0xEA60,
                    serial: None,
                },
            ),
            (
                "usb:403:6001:A6:00 4C",
                Target::Usb {
                    vendor: 0x0403,
                    product: 0x6001,
                    serial: Some("A6:00 4C".into()),
                },
            ),
            ("arm:DT1234:x", Target::Arm("DT1234:x".into())),
            (
                "udp:arm",
                Target::Udp {
                    host: "arm".into(),
                    port: 8899,
                },
            ),
            (
                "udp:[::1]:9",
                Target::Udp {
                    host: "::1".into(),
                    port: 9,
                },
            ),
            (
                "tcp:10.0.0.2:2000",
                Target::Tcp {
                    host: "10.0.0.2".into(),
                    port: 2000,
                },
            ),
            ("ble:Dobot", Target::Ble("Dobot".into())),
        ];
        for (text, target) in right {
            assert_eq!(text.parse::<Target>().unwrap(), target, "{text}");
            let again = target.to_string().parse::<Target>().unwrap();
            assert_eq!(again, target, "{text} survives being written");
        }
    }

    #[test]
    fn says_what_is_right() {
        for (text, hint) in [
            ("", "sim[:SPEED]"),
            ("ttyUSB0", "/dev/ttyUSB0"),
            ("sim:fast", "sim:max"),
            ("sim:0", "above 0"),
            ("sim:-1", "above 0"),
            ("sim:nan", "above 0"),
            ("udp:", "udp:HOST"),
            ("udp:h:0", "udp:HOST"),
            ("udp:h:99999", "udp:HOST"),
            ("udp:::1", "udp:HOST"),
            ("tcp:host", "tcp:host:PORT"),
            ("tcp", "tcp:HOST:PORT"),
            ("ble:", "ble:NAME"),
            ("usb:10c4", "usb:VENDOR:PRODUCT"),
            ("usb:10c4:", "usb:VENDOR:PRODUCT"),
            ("usb:10c4:ea60:", "usb:VENDOR:PRODUCT"),
            ("usb:+0c4:ea60", "usb:VENDOR:PRODUCT"),
            ("usb:010c4:ea60", "usb:VENDOR:PRODUCT"),
            ("usb", "usb:VENDOR:PRODUCT"),
            ("arm:", "arm:SERIAL"),
            ("arm", "arm:SERIAL"),
            ("com", "COM3"),
            ("comet", "COM3"),
        ] {
            let error = text.parse::<Target>().unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput);
            assert!(error.to_string().contains(hint), "{text}: {error}");
        }
    }

    #[test]
    fn chooses_the_one_arm() {
        let port = |path: &str, vendor| Port {
            path: path.into(),
            usb: Some(Usb {
                vendor,
                product: 0xEA60,
                ..Usb::default()
            }),
        };
        let (arm, other) = (port("/dev/ttyUSB0", 0x10C4), port("/dev/ttyACM0", 0x1234));
        let chosen = Target::choose(&[other.clone(), arm.clone()]).unwrap();
        assert_eq!(chosen, Target::Serial("/dev/ttyUSB0".into()));
        let none = Target::choose(&[other]).unwrap_err().to_string();
        assert!(none.contains("/dev/ttyACM0"), "{none}");
        let two = Target::choose(&[arm.clone(), port("/dev/ttyUSB7", 0x10C4)]);
        assert!(two.unwrap_err().to_string().contains("/dev/ttyUSB7"));
    }
}
