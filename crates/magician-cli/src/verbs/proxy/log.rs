//! Log of the proxy on stderr: frames, endpoints, clients and the line, as text or JSON.

use std::fmt::Display;
use std::io::{self, Write};
use std::time::{Duration, SystemTime};

use magician::proxy::Event;
use magician::serve::{Endpoint, Notice, ProxyNotice, ProxyObserver};
use magician_protocol::{Description, Direction, Frame, FrameBuf, Row, describe};
use serde_json::{Map, Value, json};

use crate::json::json;
use crate::paint::{Paint, print_stderr};
use crate::serving::serving;
use crate::throttle::{Suppressed, Throttle};
use crate::verbs::decode::{direction_word, hex};

/// Smallest width of the column with names.
const NAME_WIDTH: usize = 8;
/// Width of the column with directions, or the words in their place.
const DIRECTION_WIDTH: usize = 11;

/// Amount and format of the output.
pub(super) struct Style {
    pub(super) json: bool,
    /// True if frames are shown.
    pub(super) frames: bool,
    /// Ids of the commands shown; empty for all.
    pub(super) only: Vec<u8>,
    pub(super) verbose: u8,
}

/// Log writer. Lines that belong together are written together; an unwritable stderr is ignored.
pub(super) struct Log {
    style: Style,
    /// Name of the line to the arm.
    arm: String,
    paint: Paint,
    begun: u64,
    width: usize,
    text: String,
    /// Rate limit for lines that peers can cause in any number: protocol errors, connecting and
    /// disconnecting clients.
    throttle: Throttle<&'static str>,
}

impl Log {
    pub(super) fn new(style: Style, arm: &str) -> Self {
        Self {
            style,
            arm: arm.to_owned(),
            paint: Paint::for_stderr(),
            begun: wall_clock(),
            width: NAME_WIDTH,
            text: String::new(),
            throttle: Throttle::default(),
        }
    }

    /// Returns the time since the beginning.
    fn elapsed(&self) -> Duration {
        Duration::from_micros(wall_clock().saturating_sub(self.begun))
    }

    /// True if one more line of this kind may be shown.
    fn passes(&mut self, kind: &'static str) -> bool {
        self.throttle.allows(self.elapsed(), kind, kind)
    }

    /// Prints summaries of suppressed lines.
    fn print_suppressed(&mut self, held: Vec<Suppressed>) {
        for Suppressed {
            count,
            last,
            seconds,
        } in held
        {
            if self.style.json {
                self.object(
                    json!({"event": "more", "of": last, "count": count, "seconds": seconds}),
                )
            } else {
                let line = format!("{last:<DIRECTION_WIDTH$}{count} more in the last {seconds} s");
                self.line("", line);
            }
        }
    }

    /// Warns about endpoints through which other computers can move the arm.
    pub(super) fn exposed(&self, endpoints: &[Endpoint]) {
        let arm = &self.arm;
        for endpoint in endpoints.iter().filter(|endpoint| endpoint.is_exposed()) {
            let message = format!(
                "every computer that reaches {endpoint} can move the arm at {arm} without a \
                    password; serve 127.0.0.1 to allow only programs on this computer"
            );
            let object =
                json!({"event": "exposed", "endpoint": endpoint.to_string(), "message": message});
            self.say(object, || {
                format!("{} {message}", self.paint.note("warning:"))
            });
        }
    }

    pub(super) fn serving(&self, endpoints: &[Endpoint]) {
        let arm = &self.arm;
        self.say(json!({"event": "proxy", "arm": arm}), || {
            format!("proxy for the arm at {arm}")
        });
        for endpoint in endpoints {
            self.say(
                json!({"event": "serving", "endpoint": endpoint.to_string()}),
                || serving(endpoint),
            );
        }
    }

    fn client(&mut self, notice: &Notice) {
        let at_all = self.style.frames || self.style.verbose > 0;
        let (kind, who, text) = match notice {
            Notice::Connected(who) if at_all => ("connected", who, "connected"),
            Notice::Left(who) if at_all => ("left", who, "left"),
            Notice::Refused(who) => ("refused", who, "refused: too many connections"),
            Notice::MadeRoom(who) => (
                "made-room",
                who,
                "closed: it was idle, and a new connection needed its place",
            ),
            _ => return,
        };
        if self.passes(kind) {
            self.say(json!({"event": kind, "link": who}), || {
                format!("{who} {text}")
            });
        }
    }

    fn say(&self, object: Value, text: impl FnOnce() -> String) {
        let line = if self.style.json {
            json(&object)
        } else {
            text()
        };
        print_stderr(line);
    }

    /// Prints a frame that passed or was rejected.
    fn event(&mut self, event: &Event, client: Option<&str>) {
        if !self.style.frames {
            return;
        }
        let (request, reply) = (Direction::Request, Direction::Reply);
        let shown = match event {
            Event::Foreign { bytes, passed, .. } => {
                return self.foreign(client.unwrap_or("arm"), bytes.bytes(), *passed);
            }
            Event::Request { frame, .. } => ShownFrame::new("request", frame, request),
            Event::Reply { frame, shared, .. } => {
                let note = shared.then(|| "shared".to_owned());
                ShownFrame::new("reply", frame, reply).with_note(note)
            }
            Event::Unanswered { frame, .. } => ShownFrame::new("unanswered", frame, request).bad(),
            Event::Dropped { frame, reason, .. } => {
                let note = Some(reason.to_string());
                ShownFrame::new("dropped", frame, request)
                    .with_note(note)
                    .bad()
            }
            Event::Own { frame } => ShownFrame::new("own", frame, request),
            Event::Unclaimed { frame } => ShownFrame::new("unclaimed", frame, reply).bad(),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let who = client.unwrap_or(match event {
            Event::Own { .. } => "proxy",
            Event::Unclaimed { .. } => "arm",
            _ => "?",
        });
        let only = &self.style.only;
        let wanted = only.is_empty() || only.contains(&shown.frame.id());
        // Valid traffic is limited by its clients' requests; errors may come at any rate.
        if wanted && (!shown.bad || self.passes(shown.word)) {
            if self.style.json {
                self.object(shown.object(who))
            } else {
                self.frame(who, &shown)
            }
        }
    }

    fn frame(&mut self, who: &str, shown: &ShownFrame<'_>) {
        let paint = self.paint;
        let values = shown.values();
        let note = shown.note.as_ref().map(|note| format!("  ({note})"));
        let note = paint.note(note.unwrap_or_default()).to_string();
        let name = paint.name(shown.name()).to_string();
        let word = format!("{:<DIRECTION_WIDTH$}", shown.word);
        let word = if shown.bad {
            paint.error(word).to_string()
        } else {
            word
        };
        self.line(who, format_args!("{word}{name}{values}{note}"));
    }

    fn foreign(&mut self, who: &str, bytes: &[u8], passed: bool) {
        if !self.passes("noise") {
            return;
        }
        if self.style.json {
            return self.object(json!({
                "time": wall_clock(), "link": who, "event": "noise", "hex": hex(bytes),
                "ok": false, "passed": passed,
            }));
        }
        let word = self
            .paint
            .error(format!("{:<DIRECTION_WIDTH$}", "noise"))
            .to_string();
        let text = bytes.escape_ascii();
        let fate = match (who, passed) {
            ("arm", _) => "",
            (_, true) => "  (passed on)",
            (_, false) => "  (dropped)",
        };
        let fate = self.paint.note(fate).to_string();
        self.line(who, format_args!("{word}\"{text}\"{fate}"));
    }

    fn object(&mut self, object: Value) {
        self.text += &json(&object);
        self.text.push('\n');
    }

    fn line(&mut self, who: &str, rest: impl Display) {
        self.width = self.width.max(who.chars().count());
        let since = wall_clock().saturating_sub(self.begun);
        let (seconds, micros) = (since / 1_000_000, since % 1_000_000);
        let time = format!("{seconds:>5}.{micros:06}");
        let time = self.paint.dim(time).to_string();
        let width = self.width;
        let line = format_args!("{time}  {who:<width$}  {rest}");
        self.text += &self.paint.harmless(line);
        self.text.push('\n');
    }
}

impl ProxyObserver for Log {
    fn notice(&mut self, notice: ProxyNotice<'_>) {
        match notice {
            ProxyNotice::Traffic { event, client } => self.event(event, client),
            ProxyNotice::Client(notice) => self.client(notice),
            ProxyNotice::LineLost(why) => {
                let object = json!({"event": "line-lost", "message": why.to_string()});
                self.say(object, || {
                    format!("{why}; reconnecting, no replies until the line is back")
                });
            }
            ProxyNotice::LineFound => self.say(json!({"event": "line-found"}), || {
                format!("the line to the arm {} is back", self.arm)
            }),
            ProxyNotice::TraceEnded(error) => {
                let object = json!({"event": "trace-ended", "message": error.to_string()});
                self.say(object, || format!("the trace ends here: {error}"));
            }
            ProxyNotice::JogNotConfirmed => self.say(json!({"event": "jog-not-confirmed"}), || {
                "the arm did not confirm that the jog has ended".to_owned()
            }),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }

    fn flush(&mut self) {
        let ended = self.throttle.take_ended(self.elapsed());
        self.print_suppressed(ended);
        if !self.text.is_empty() {
            let _ = io::stderr().lock().write_all(self.text.as_bytes());
            self.text.clear();
        }
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        let rest = self.throttle.take_all(self.elapsed());
        self.print_suppressed(rest);
        self.flush();
    }
}

/// Frame to print.
struct ShownFrame<'a> {
    word: &'static str,
    frame: Frame<'a>,
    meaning: Option<Description<'a>>,
    direction: Direction,
    note: Option<String>,
    bad: bool,
}

impl<'a> ShownFrame<'a> {
    fn new(word: &'static str, frame: &'a FrameBuf, direction: Direction) -> Self {
        let frame = frame.frame();
        Self {
            word,
            meaning: describe(&frame, direction).ok(),
            frame,
            direction,
            note: None,
            bad: false,
        }
    }

    fn with_note(self, note: Option<String>) -> Self {
        Self { note, ..self }
    }

    fn bad(self) -> Self {
        Self { bad: true, ..self }
    }

    fn known_name(&self) -> Option<&'static str> {
        let row = Row::with_id(self.frame.id())?;
        Some(row.form_name(self.frame.ctrl()))
    }

    fn name(&self) -> String {
        match self.known_name() {
            Some(name) => name.to_owned(),
            None => format!("unknown id {}", self.frame.id()),
        }
    }

    /// Returns the fields in the notation that users type, or the bytes if they cannot be decoded.
    fn values(&self) -> String {
        let queued = if self.frame.ctrl().queued() {
            "  queued"
        } else {
            ""
        };
        let values = self
            .meaning
            .as_ref()
            .and_then(|meaning| meaning.values().ok());
        match values {
            Some(values) => {
                let values = values.map(|(field, value)| {
                    let value = value.to_string().replace(", ", ",");
                    format!(" {}={value}", field.name)
                });
                format!("{queued} {}", values.collect::<String>())
                    .trim_end()
                    .to_owned()
            }
            None if self.frame.params().is_empty() => queued.to_owned(),
            None => format!("{queued}  {}", hex(self.frame.params())),
        }
    }

    fn object(&self, who: &str) -> Value {
        let (frame, ctrl) = (&self.frame, self.frame.ctrl());
        let mut object = Map::new();
        let mut put = |key: &str, value: Value| object.insert(key.to_owned(), value);
        put("time", json!(wall_clock()));
        put("link", json!(who));
        put("event", json!(self.word));
        put("direction", json!(direction_word(self.direction)));
        put("hex", json!(hex(frame.bytes())));
        put("ok", json!(self.meaning.is_some()));
        put("id", json!(frame.id()));
        put("command", json!(self.known_name()));
        put("write", json!(ctrl.write()));
        put("queued", json!(ctrl.queued()));
        let raw = || json!({"raw": hex(frame.params())});
        let meaning = self.meaning.as_ref();
        let params = meaning.and_then(|meaning| serde_json::to_value(meaning).ok());
        put("params", params.unwrap_or_else(raw));
        if let Some(note) = &self.note {
            put("note", json!(note));
        }
        Value::Object(object)
    }
}

/// Returns microseconds since 1970.
fn wall_clock() -> u64 {
    let since = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}
