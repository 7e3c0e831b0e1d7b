//! What the messages of a site say: JSON beside sessions, and packets within them. Without I/O; nothing here panics on any bytes.

use magician_station::Role;
use magician_station::api::{Message, Method};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::channel::{Closed, FromStation, ToStation, WINDOW};
use crate::{ArmNews, StationId};

/// Bytes of a message, at most: a socket's unsent answers, and some.
pub const LARGEST: usize = 16 * 1024 * 1024;

/// What a station says of an arm under `state`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StateMessage {
    /// Who says it.
    pub station: StationId,
    /// [`ArmNews::machine`].
    pub machine: String,
    /// [`ArmNews::port`].
    pub port: String,
    /// [`ArmNews::is_virtual`].
    #[serde(rename = "virtual")]
    pub is_virtual: bool,
    /// [`ArmNews::state`].
    pub state: Value,
}

impl StateMessage {
    /// Of this station.
    #[must_use]
    pub fn new(station: StationId, news: ArmNews) -> Self {
        Self {
            station,
            machine: news.machine,
            port: news.port,
            is_virtual: news.is_virtual,
            state: news.state,
        }
    }

    /// Who says what.
    #[must_use]
    pub fn split(self) -> (StationId, ArmNews) {
        let news = ArmNews {
            machine: self.machine,
            port: self.port,
            is_virtual: self.is_virtual,
            state: self.state,
        };
        (self.station, news)
    }
}

/// What a station says under `event`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct EventMessage {
    /// Who says it.
    pub station: StationId,
    /// The parameters of `arm.event`.
    pub event: Value,
}

/// What a station says under `job`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct JobMessage {
    /// Who says it.
    pub station: StationId,
    /// The job of `job.changed`.
    pub job: Value,
}

/// What comes with a request, beside its text.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// The token.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
    /// The station that is meant; others do not answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub station: Option<StationId>,
    /// The program that asks.
    #[serde(default)]
    pub client: String,
    /// In place of a request: the channel of a session that is to be opened.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<ChannelId>,
}

/// The channel of a session: 128 random bits, 32 digits of hex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelId(pub u128);

/// Numbers as text of so many digits of hex.
macro_rules! as_hex {
    ($id:ident, $number:ty, $digits:literal) => {
        impl Serialize for $id {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.collect_str(&format_args!(concat!("{:0", $digits, "x}"), self.0))
            }
        }

        impl<'de> Deserialize<'de> for $id {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                let text = String::deserialize(from)?;
                let number = <$number>::from_str_radix(&text, 16).ok();
                // In one form only: ids are compared as text by others.
                number
                    .filter(|id| format!(concat!("{:0", $digits, "x}"), id) == text)
                    .map(Self)
                    .ok_or_else(|| serde::de::Error::custom("no id"))
            }
        }
    };
}

as_hex!(StationId, u64, 16);
as_hex!(ChannelId, u128, 32);

/// What a station does with a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    /// It is for another station: no answer, and nothing happens.
    NotForUs,
    /// It opens a session.
    Opens(ChannelId),
    /// It is carried out.
    Calls {
        /// Before everything else, in any number.
        is_stop: bool,
    },
    /// It is refused.
    Refused(&'static str),
}

/// Decides what a request is to this station.
#[must_use]
pub fn hear(own: StationId, asked: &Asked, text: &str) -> Heard {
    if asked.station.is_some_and(|meant| meant != own) {
        return Heard::NotForUs;
    }
    if let Some(channel) = asked.open {
        return match asked.station {
            Some(_) => Heard::Opens(channel),
            None => Heard::Refused(NAMELESS),
        };
    }
    match (asked.station, act(text)) {
        (None, Act::Does) => Heard::Refused(NAMELESS),
        (_, act) => Heard::Calls {
            is_stop: act == Act::Stops,
        },
    }
}

/// What a request comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Somebody looks. What is no request is as harmless: the station answers that it is none.
    Looks,
    /// Something is stopped, or kept up.
    Stops,
    /// All the rest.
    Does,
}

/// What a request comes to.
#[must_use]
pub fn act(text: &str) -> Act {
    let method = Message::parse(text).ok();
    let is_expect = { method.as_ref() }.is_some_and(|message| message.method == EXPECT);
    match method.and_then(|message| Method::named(&message.method)) {
        Some(method) if method.always => Act::Stops,
        Some(method) if method.role != Role::Viewer => Act::Does,
        None if is_expect => Act::Does,
        _ => Act::Looks,
    }
}

/// The method by which a teacher writes the roster of a station: `{"arms": [{"arm", "machine"}]}`. It is the site's own; the station
/// does not know it.
pub const EXPECT: &str = "site.expect";

const NAMELESS: &str =
    "`station` is missing: what does more than to look or stop names the station that is meant";

/// A packet of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Packet {
    /// A message of JSON-RPC.
    Text(String),
    /// A state as bytes.
    Frame(Vec<u8>),
    /// A sign of life of the client.
    Alive,
    /// How many packets were passed on so far.
    Taken(u64),
    /// The end, with its code and reason.
    Close(u16, String),
}

impl From<ToStation> for Packet {
    fn from(message: ToStation) -> Self {
        match message {
            ToStation::Text(text) => Self::Text(text),
            ToStation::Alive => Self::Alive,
        }
    }
}

impl From<FromStation> for Packet {
    fn from(message: FromStation) -> Self {
        match message {
            FromStation::Text(text) => Self::Text(text),
            FromStation::Frame(bytes) => Self::Frame(bytes),
            FromStation::Closed(closed) => Self::Close(closed.code, closed.reason),
        }
    }
}

impl TryFrom<Packet> for ToStation {
    type Error = BadPacket;

    fn try_from(packet: Packet) -> Result<Self, BadPacket> {
        match packet {
            Packet::Text(text) => Ok(Self::Text(text)),
            Packet::Alive => Ok(Self::Alive),
            _ => Err(BadPacket),
        }
    }
}

impl TryFrom<Packet> for FromStation {
    type Error = BadPacket;

    fn try_from(packet: Packet) -> Result<Self, BadPacket> {
        match packet {
            Packet::Text(text) => Ok(Self::Text(text)),
            Packet::Frame(bytes) => Ok(Self::Frame(bytes)),
            Packet::Close(code, reason) => Ok(Self::Closed(Closed { code, reason })),
            _ => Err(BadPacket),
        }
    }
}

/// Bytes that are not the next packet: one is missing, or they are none. The channel ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadPacket;

/// Numbers the packets of one end of a session, and keeps what is on its way within [`WINDOW`].
///
/// A packet is its number (8 bytes, little endian, from 0 on), a byte that says what it is, and the rest.
#[derive(Clone, Debug, Default, Hash)]
pub struct Flow {
    /// Packets sent.
    sent: u64,
    /// Of these, those that count.
    counted: u64,
    /// How many of them the other end has passed on.
    taken_there: u64,
    /// Packets heard.
    heard: u64,
    /// Of these, those that count.
    counted_here: u64,
    /// How many of them were passed on.
    taken: u64,
    /// What the other end was told of that.
    told: u64,
}

impl Flow {
    /// Whether another message may be sent.
    #[must_use]
    pub fn may_send(&self) -> bool {
        self.counted.saturating_sub(self.taken_there) < WINDOW as u64
    }

    /// A packet as bytes.
    pub fn pack(&mut self, packet: &Packet) -> Vec<u8> {
        let mut bytes = self.sent.to_le_bytes().to_vec();
        self.sent += 1;
        if counts(packet) {
            self.counted += 1;
        }
        match packet {
            Packet::Text(text) => {
                bytes.push(b'T');
                bytes.extend(text.as_bytes());
            }
            Packet::Frame(frame) => {
                bytes.push(b'F');
                bytes.extend(frame);
            }
            Packet::Alive => bytes.push(b'A'),
            Packet::Taken(number) => {
                bytes.push(b'W');
                bytes.extend(number.to_le_bytes());
            }
            Packet::Close(code, reason) => {
                bytes.push(b'C');
                bytes.extend(code.to_le_bytes());
                bytes.extend(reason.as_bytes());
            }
        }
        bytes
    }

    /// The packet of bytes that came; what it says of our own packets is noted.
    ///
    /// # Errors
    /// [`BadPacket`], after which nothing more can be read.
    pub fn unpack(&mut self, bytes: &[u8]) -> Result<Packet, BadPacket> {
        let (number, rest) = bytes.split_first_chunk().ok_or(BadPacket)?;
        let (kind, rest) = rest.split_first().ok_or(BadPacket)?;
        if u64::from_le_bytes(*number) != self.heard {
            return Err(BadPacket);
        }
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).map_err(|_| BadPacket);
        let packet = match kind {
            b'T' => Packet::Text(text(rest)?),
            b'F' => Packet::Frame(rest.to_vec()),
            b'A' if rest.is_empty() => Packet::Alive,
            b'W' => {
                let number = u64::from_le_bytes(rest.try_into().map_err(|_| BadPacket)?);
                if number < self.taken_there || number > self.counted {
                    return Err(BadPacket);
                }
                self.taken_there = number;
                Packet::Taken(number)
            }
            b'C' => {
                let (code, reason) = rest.split_first_chunk().ok_or(BadPacket)?;
                Packet::Close(u16::from_le_bytes(*code), text(reason)?)
            }
            _ => return Err(BadPacket),
        };
        self.heard += 1;
        if counts(&packet) {
            self.counted_here += 1;
            if self.counted_here - self.taken > WINDOW as u64 {
                return Err(BadPacket);
            }
        }
        Ok(packet)
    }

    /// A message was passed on; what to tell the other end of it, at times.
    pub fn took(&mut self) -> Option<Packet> {
        self.taken += 1;
        if self.taken - self.told < WINDOW as u64 / 4 {
            return None;
        }
        self.told = self.taken;
        Some(Packet::Taken(self.taken))
    }
}

/// Whether a packet counts towards the window.
const fn counts(packet: &Packet) -> bool {
    matches!(packet, Packet::Text(_) | Packet::Frame(_) | Packet::Alive)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const OWN: StationId = StationId(7);

    fn asked(text: &str) -> Asked {
        serde_json::from_str(text).unwrap()
    }

    fn request(method: &str) -> String {
        json!({"jsonrpc": "2.0", "id": 1, "method": method}).to_string()
    }

    #[test]
    fn a_station_hears_what_is_for_it() {
        let to_us = asked(r#"{"station": "0000000000000007", "token": "t", "client": "c"}"#);
        let to_other = asked(r#"{"station": "0000000000000008"}"#);
        let to_any = asked("{}");
        let calls = Heard::Calls { is_stop: false };
        let stops = Heard::Calls { is_stop: true };
        for (method, us, any) in [
            ("arm.move", calls.clone(), Heard::Refused(NAMELESS)),
            ("job.start", calls.clone(), Heard::Refused(NAMELESS)),
            ("preset.remove", calls.clone(), Heard::Refused(NAMELESS)),
            (EXPECT, calls.clone(), Heard::Refused(NAMELESS)),
            ("arm.state", calls.clone(), calls.clone()),
            ("job.check", calls.clone(), calls.clone()),
            ("arm.stop", stops.clone(), stops.clone()),
            ("job.stop", stops.clone(), stops.clone()),
            ("jog.stop", stops.clone(), stops.clone()),
            ("no.method", calls.clone(), calls.clone()),
        ] {
            let text = request(method);
            assert_eq!(hear(OWN, &to_us, &text), us, "{method}");
            assert_eq!(hear(OWN, &to_any, &text), any, "{method}");
            assert_eq!(hear(OWN, &to_other, &text), Heard::NotForUs, "{method}");
        }
        assert_eq!(hear(OWN, &to_any, "no JSON"), calls);
    }

    #[test]
    fn a_session_is_opened_by_the_station_that_is_named() {
        let channel = ChannelId(0xc0ffee);
        let mut open = Asked {
            open: Some(channel),
            station: Some(OWN),
            ..Asked::default()
        };
        assert_eq!(hear(OWN, &open, ""), Heard::Opens(channel));
        assert_eq!(hear(StationId(8), &open, ""), Heard::NotForUs);
        open.station = None;
        assert_eq!(hear(OWN, &open, ""), Heard::Refused(NAMELESS));
        let text = serde_json::to_string(&open).unwrap();
        assert!(text.contains(r#""open":"00000000000000000000000000c0ffee""#));
        assert_eq!(asked(&text), open);
        for wrong in [
            r#"{"open": "c0ffee"}"#,
            r#"{"station": "7"}"#,
            r#"{"station": 7}"#,
            r#"{"stations": []}"#,
            "7",
        ] {
            assert!(serde_json::from_str::<Asked>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn packets_are_read_as_they_are_written() {
        let (mut here, mut there) = (Flow::default(), Flow::default());
        let packets = [
            Packet::Text("{}".to_owned()),
            Packet::Frame(vec![0x4d, 1, 2]),
            Packet::Alive,
            Packet::Taken(0),
            Packet::Close(4401, "no token".to_owned()),
        ];
        for packet in packets {
            let bytes = here.pack(&packet);
            assert_eq!(there.unpack(&bytes), Ok(packet));
        }
        assert_eq!(Flow::default().pack(&Packet::Alive), b"\0\0\0\0\0\0\0\0A");
    }

    #[test]
    fn a_packet_that_is_missing_or_comes_twice_ends_the_channel() {
        let mut here = Flow::default();
        let first = here.pack(&Packet::Alive);
        let second = here.pack(&Packet::Alive);
        assert_eq!(Flow::default().unpack(&second), Err(BadPacket));
        let mut there = Flow::default();
        assert!(there.unpack(&first).is_ok());
        assert_eq!(there.unpack(&first), Err(BadPacket));
    }

    #[test]
    fn what_is_on_its_way_is_bounded() {
        let (mut here, mut there) = (Flow::default(), Flow::default());
        let mut waiting = 0;
        while here.may_send() {
            let bytes = here.pack(&Packet::Text("x".to_owned()));
            assert!(there.unpack(&bytes).is_ok());
            waiting += 1;
        }
        assert_eq!(waiting, WINDOW);
        // One that does not keep to it is cut off.
        let bytes = here.pack(&Packet::Alive);
        assert_eq!(there.unpack(&bytes), Err(BadPacket));

        let (mut here, mut there) = (Flow::default(), Flow::default());
        for _ in 0..10 * WINDOW {
            assert!(here.may_send());
            let bytes = here.pack(&Packet::Alive);
            assert!(there.unpack(&bytes).is_ok());
            if let Some(told) = there.took() {
                let bytes = there.pack(&told);
                assert!(here.unpack(&bytes).is_ok());
            }
        }
    }

    #[test]
    fn nothing_is_taken_that_was_not_sent() {
        let mut here = Flow::default();
        here.pack(&Packet::Alive);
        let mut there = Flow::default();
        let lie = there.pack(&Packet::Taken(2));
        assert_eq!(here.unpack(&lie), Err(BadPacket));
    }

    #[test]
    fn any_bytes_are_read_or_refused() {
        // A small generator of our own: what matters is that every length and kind comes up.
        let mut state = 1_u64;
        for round in 0..20_000 {
            let mut bytes = vec![0; round % 40];
            for byte in &mut bytes {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                *byte = (state >> 56) as u8;
            }
            if round % 3 == 0 && bytes.len() > 8 {
                bytes[..8].fill(0);
                bytes[8] = b"TFAWC"[round % 5];
            }
            let _ = Flow::default().unpack(&bytes);
            let text = String::from_utf8_lossy(&bytes);
            let _ = serde_json::from_str::<StateMessage>(&text);
            let _ = hear(OWN, &Asked::default(), &text);
        }
    }
}
