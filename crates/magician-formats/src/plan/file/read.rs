//! Reader of plan files.

use std::borrow::Cow;
use std::collections::HashMap;
use std::str::FromStr;

use magician_host::{Message, message};
use magician_protocol::{MAX_PARAMS, ParseError, Row, Set, Writer, encode_text};

use super::write::{grip_name, travel};
use super::{FORMAT, VERSION, VERSION_WITH_PARTS};
use crate::encoding::{Fallback, decode};
use crate::plan::json::{Json, Member};
use crate::{
    Action, Diagnostic, Grip, Origin, Part, Pause, PauseCause, Plan, Step, Surface, Tool, Travel,
};

/// Parses a plan file.
pub(super) fn plan(bytes: &[u8]) -> Result<Plan, Diagnostic> {
    let text = decode(bytes, Fallback::Refused)?.text;
    let json = Json::of(&text);
    let file = json.object(json.whole()?)?;
    let mut plan = Plan::default();
    let mut names = HashMap::new();
    let version = check_format(&json, &file)?;
    let mut steps = None;
    for member in &file {
        let value = member.value;
        match &*member.key {
            "format" | "version" => {}
            "$schema" => drop(json.string(value)?),
            "title" => plan.title = json.string(value)?.into_owned(),
            "tool" => plan.tool = tool(&json, value)?,
            "surface" => plan.surface = surface(&json, value)?,
            "names" => {
                for name in json.array(value)? {
                    let name = json.string(name)?.into_owned();
                    names.entry(name.clone()).or_insert(plan.names.len());
                    plan.names.push(name);
                }
            }
            "steps" => steps = Some(value),
            _ => {
                let known = "format, version, title, tool, surface, names, steps";
                return Err(json.unknown(member, known));
            }
        }
    }
    let steps = steps.ok_or_else(|| {
        Diagnostic::of_file(message!("there are no steps")).help(message!(
            "a plan has '\"steps\":[', one step on each line, ']'"
        ))
    })?;
    let mut reader = StepReader {
        json: &json,
        plan,
        names,
        version,
    };
    json.each(steps, |step| reader.step(step))?;
    Ok(reader.plan)
}

/// Checks that the file is a plan of a known version, before anything else is parsed. Returns the
/// version.
fn check_format<'t>(json: &Json<'t>, file: &[Member<'t>]) -> Result<u32, Diagnostic> {
    let find = |key: &str| file.iter().find(|member| member.key == key);
    let help = message!(
        "a plan begins with {begin}",
        begin = format!("{{\"format\":\"{FORMAT}\",\"version\":{VERSION},")
    );
    let Some(format) = find("format") else {
        return Err(Diagnostic::of_file(message!("it is not marked as a plan")).help(help));
    };
    if json.string(format.value)? != FORMAT {
        let message = message!(
            "this is {found}, not \"{wanted}\"",
            found = format.value,
            wanted = FORMAT
        );
        return Err(json.diagnostic(format.value, message).help(help));
    }
    let Some(version) = find("version") else {
        return Err(json
            .diagnostic(format.value, message!("it has no version"))
            .help(help));
    };
    let number: u32 = json.number(version.value, || message!("a whole number"))?;
    if !(VERSION..=VERSION_WITH_PARTS).contains(&number) {
        let message = message!(
            "this is a plan of version {number}; only versions {first} and {last} are known here",
            number,
            first = VERSION,
            last = VERSION_WITH_PARTS
        );
        let help = if number > VERSION_WITH_PARTS {
            message!("a newer release of this program may read it")
        } else {
            message!("versions count from 1")
        };
        return Err(json.diagnostic(version.value, message).help(help));
    }
    Ok(number)
}

fn tool(json: &Json<'_>, value: &str) -> Result<Option<Tool>, Diagnostic> {
    if value == "null" {
        return Ok(None);
    }
    if value.starts_with('[') {
        return numbers(json, "tool", "x, y, z", value).map(|bias| Some(Tool::Bias(bias)));
    }
    let name = json.string(value)?;
    let found = Tool::NAMED_TOOLS.iter().find(|(known, _)| *known == name);
    match found {
        Some((_, tool)) => Ok(Some(*tool)),
        None => {
            let names = Tool::NAMED_TOOLS.map(|(name, _)| name).join(", ");
            let help = message!(
                "a tool is one of {names}, or its bias as [x,y,z] in mm",
                names
            );
            Err(json
                .diagnostic(value, message!("unknown tool {name}", name = value))
                .help(help))
        }
    }
}

fn surface(json: &Json<'_>, value: &str) -> Result<Option<Surface>, Diagnostic> {
    if value == "null" {
        return Ok(None);
    }
    let mut height = None;
    let mut slope = [0.0; 2];
    for member in json.object(value)? {
        match &*member.key {
            "height" => height = Some(float(json, "height", member.value)?),
            "slope" => slope = numbers(json, "slope", "x, y", member.value)?,
            _ => return Err(json.unknown(&member, "height, slope")),
        }
    }
    match height {
        Some(height) => Ok(Some(Surface { height, slope })),
        None => Err(json.diagnostic(value, message!("the surface has no 'height'"))),
    }
}

/// Parses a number, or the name of a non-finite one.
fn float<T: FromStr + Into<f64> + Copy>(
    json: &Json<'_>,
    key: &str,
    value: &str,
) -> Result<T, Diagnostic> {
    let wrong = || {
        let message = message!(
            "'{name}' takes a number, not {value}",
            name = key,
            value = shortened(value)
        );
        json.diagnostic(value, message)
    };
    let named = matches!(value, "\"NaN\"" | "\"inf\"" | "\"-inf\"");
    let number = if named {
        value.trim_matches('"')
    } else {
        value
    };
    let number: T = number.parse().map_err(|_| wrong())?;
    // A literal such as 1e60 overflows to infinity in 32 bits.
    if !named && !number.into().is_finite() {
        return Err(wrong());
    }
    Ok(number)
}

fn numbers<T, const N: usize>(
    json: &Json<'_>,
    key: &str,
    what: &str,
    value: &str,
) -> Result<[T; N], Diagnostic>
where
    T: FromStr + Into<f64> + Copy + Default,
{
    let wrong = |message: Message| json.diagnostic(value, message);
    if !value.starts_with('[') {
        return Err(wrong(message!(
            "'{name}' takes {n} numbers, {what}, and this is {found}",
            name = key,
            n = N,
            what,
            found = shortened(value)
        )));
    }
    let mut list = [T::default(); N];
    let mut count = 0;
    json.each(value, |item| {
        if let Some(slot) = list.get_mut(count) {
            *slot = float(json, key, item)?;
        }
        count += 1;
        Ok(())
    })?;
    match count {
        count if count == N => Ok(list),
        1 => Err(wrong(message!(
            "'{name}' takes {n} numbers, {what}, and this is 1",
            name = key,
            n = N,
            what
        ))),
        count => Err(wrong(message!(
            "'{name}' takes {n} numbers, {what}, and these are {count}",
            name = key,
            n = N,
            what,
            count
        ))),
    }
}

/// Shortens a value so that it fits into a message.
fn shortened(value: &str) -> Cow<'_, str> {
    match value.char_indices().nth(30) {
        Some((end, _)) => format!("{}...", value.get(..end).unwrap_or_default()).into(),
        None => value.into(),
    }
}

struct StepReader<'j, 't> {
    json: &'j Json<'t>,
    plan: Plan,
    /// Index of each name in the plan's list.
    names: HashMap<String, usize>,
    version: u32,
}

impl<'t> StepReader<'_, 't> {
    fn step(&mut self, value: &'t str) -> Result<(), Diagnostic> {
        let mut members = self.json.object(value)?;
        let mut take = |key: &str| {
            let at = members.iter().position(|member| member.key == key)?;
            Some(members.swap_remove(at).value)
        };
        let mut origin = Origin::NONE;
        if let Some(place) = take("at") {
            [origin.line, origin.column, origin.length] = self.place(place)?;
        }
        if let Some(name) = take("name") {
            origin.name = self.name(name)?;
        }
        let action = self.action(value, members)?;
        self.plan.steps.push(Step::new(action, origin));
        Ok(())
    }

    fn place(&self, value: &str) -> Result<[u32; 3], Diagnostic> {
        let mut place = Vec::new();
        let what = || message!("a whole number; 'at' is [line, column, length]");
        self.json.each(value, |item| {
            place.push(self.json.number(item, what)?);
            Ok(())
        })?;
        let count = place.len();
        place.try_into().map_err(|_| {
            let message = message!(
                "'at' takes 3 whole numbers, line, column, length, and has {count}",
                count
            );
            self.json.diagnostic(value, message)
        })
    }

    /// Returns the index of the name plus 1, as [`Origin`] stores it.
    fn name(&mut self, value: &str) -> Result<u32, Diagnostic> {
        if !value.starts_with('"') {
            let what = || message!("a name, or its number in 'names'");
            return self.json.number(value, what);
        }
        let name = self.json.string(value)?;
        let index = match self.names.get(&*name) {
            Some(index) => *index,
            None => {
                let index = self.plan.name(&*name);
                self.names.insert(name.into_owned(), index);
                index
            }
        };
        Ok(Origin::NONE.named(index).name)
    }

    fn action(&self, step: &str, mut members: Vec<Member<'t>>) -> Result<Action, Diagnostic> {
        let json = self.json;
        let mut actions = members.iter().filter(|member| is_action(&member.key));
        let (first, second) = (actions.next(), actions.next());
        let Some(first) = first else {
            let names = Action::NAMES.join(", ");
            return Err(json
                .diagnostic(step, message!("this step has no action"))
                .help(message!("a step is one of {names}", names)));
        };
        if let Some(second) = second {
            let message = message!(
                "'{name}' and '{other}' in one step",
                name = first.key,
                other = second.key
            );
            return Err(json
                .diagnostic(step, message)
                .help(message!("make two steps of them")));
        }
        let at = members
            .iter()
            .position(|member| is_action(&member.key))
            .unwrap_or(0);
        let Member { key, value } = members.swap_remove(at);
        let mut beside = StepMembers {
            json,
            key: &key,
            value,
            members,
        };
        let action = match &*key {
            "move" => {
                let to = numbers(json, &key, "x, y, z, r", value)?;
                let by = beside.travel(&[Travel::Joints, Travel::Line, Travel::Jump])?;
                Action::Move { to, by }
            }
            "joints" => {
                let to = numbers(json, &key, "J1, J2, J3, J4", value)?;
                let by = beside.travel(&[Travel::Joints, Travel::Line, Travel::Jump])?;
                Action::Joints { to, by }
            }
            "shift" => {
                let by = numbers(json, &key, "x, y, z, r", value)?;
                let line = beside.travel(&[Travel::Joints, Travel::Line])? == Travel::Line;
                Action::Shift { by, line }
            }
            "arc" => {
                let to = numbers(json, &key, "x, y, z, r", value)?;
                let via = numbers(json, "via", "x, y, z, r", beside.needed("via")?)?;
                Action::Arc { via, to }
            }
            "path" => Action::Path {
                to: numbers(json, &key, "x, y, z", value)?,
            },
            "burn" => {
                let to = numbers(json, &key, "x, y, z", value)?;
                let power = float(json, "power", beside.needed("power")?)?;
                Action::Burn { to, power }
            }
            "suction" => Action::Suction(json.boolean(value)?),
            "laser" => Action::Laser(json.boolean(value)?),
            "gripper" => {
                let grips =
                    [Grip::Off, Grip::Open, Grip::Close].map(|grip| (grip_name(grip), grip));
                Action::Gripper(json.one_of(value, &grips)?)
            }
            "wait" => Action::Wait(wait(json, value)?),
            "home" => {
                if json.boolean(value)? {
                    Action::Home
                } else {
                    let message = message!("'home' takes true; remove the step instead");
                    return Err(json.diagnostic(value, message));
                }
            }
            "part" | "pause" if self.version < VERSION_WITH_PARTS => {
                let message = message!(
                    "a '{name}' needs a plan of version {version}",
                    name = key,
                    version = VERSION_WITH_PARTS
                );
                return Err(json.diagnostic(value, message));
            }
            "part" => Action::Part(Box::new(part(json, value)?)),
            "pause" => {
                let causes = PauseCause::ALL.map(|cause| (cause.name(), cause));
                Action::Pause(Box::new(Pause {
                    text: json.string(value)?.into_owned(),
                    cause: json.one_of(beside.needed("reason")?, &causes)?,
                }))
            }
            _ => command(json, value, beside.take("values"))?,
        };
        match beside.members.first() {
            Some(member) => {
                let known = message!("{known}, at, name", known = beside.known());
                Err(json.unknown(member, known))
            }
            None => Ok(action),
        }
    }
}

fn is_action(key: &str) -> bool {
    Action::NAMES.contains(&key)
}

/// The action of a step and its other members.
struct StepMembers<'j, 't> {
    json: &'j Json<'t>,
    key: &'j str,
    value: &'t str,
    members: Vec<Member<'t>>,
}

impl<'t> StepMembers<'_, 't> {
    fn take(&mut self, key: &str) -> Option<&'t str> {
        let at = self.members.iter().position(|member| member.key == key)?;
        Some(self.members.swap_remove(at).value)
    }

    fn needed(&mut self, key: &str) -> Result<&'t str, Diagnostic> {
        let taken = self.take(key);
        taken.ok_or_else(|| {
            let message = message!("'{name}' needs '{key}' beside it", name = self.key, key);
            self.json.diagnostic(self.value, message)
        })
    }

    fn travel(&mut self, allowed: &[Travel]) -> Result<Travel, Diagnostic> {
        let Some(value) = self.take("by") else {
            return Ok(Travel::Joints);
        };
        let named: Vec<_> = allowed.iter().map(|by| (travel(*by), *by)).collect();
        self.json.one_of(value, &named)
    }

    fn known(&self) -> Message {
        let names = match self.key {
            "move" => "move, by",
            "joints" => "joints, by",
            "shift" => "shift, by",
            "arc" => "arc, via",
            "burn" => "burn, power",
            "command" => "command, values",
            "pause" => "pause, reason",
            _ => return message!("the action itself"),
        };
        names.into()
    }
}

/// Parses the start of a part.
fn part<'t>(json: &Json<'t>, value: &'t str) -> Result<Part, Diagnostic> {
    let mut part = Part::default();
    let what = || message!("a whole number from 1");
    for member in json.object(value)? {
        let value = member.value;
        match &*member.key {
            "n" => part.n = json.number(value, what)?,
            "pass" => part.pass = Some(json.number(value, what)?),
            "name" | "color" if value == "null" => {}
            "name" => part.name = Some(json.string(value)?.into_owned()),
            "color" => {
                let text = json.string(value)?;
                let color = text.parse().map_err(|_| {
                    let message = message!(
                        "'{text}' is not a colour: expected #rrggbb or a name of CSS",
                        text
                    );
                    json.diagnostic(value, message)
                })?;
                part.color = Some(color);
            }
            _ => return Err(json.unknown(&member, "n, name, color, pass")),
        }
    }
    if part.n == 0 || part.pass == Some(0) {
        return Err(json.diagnostic(value, message!("parts and passes count from 1")));
    }
    Ok(part)
}

/// Parses seconds and returns ms. They must be a whole number.
fn wait(json: &Json<'_>, value: &str) -> Result<u32, Diagnostic> {
    let seconds: f64 = float(json, "wait", value)?;
    let milliseconds = seconds * 1000.0;
    let whole = milliseconds.round();
    // Negated, so that NaN is refused too.
    if !((0.0..=f64::from(u32::MAX)).contains(&whole) && (milliseconds - whole).abs() < 1e-4) {
        let message = message!(
            "'wait' takes seconds, 0 to 4294967.295 in whole ms, not {value}",
            value = shortened(value)
        );
        return Err(json.diagnostic(value, message));
    }
    Ok(whole as u32)
}

/// Parses any command that can be queued. Its fields have the names of the protocol's table.
fn command(json: &Json<'_>, name: &str, values: Option<&str>) -> Result<Action, Diagnostic> {
    let called = json.string(name)?;
    let row = Row::find_writable(&called).map_err(|_| {
        let message = message!("unknown command {name} to set", name = shortened(name));
        json.diagnostic(name, message)
            .remedy(magician_host::Action::ListCommands, "lists them")
    })?;
    let layout = row.set.filter(|_| row.queueable).ok_or_else(|| {
        let message = message!(
            "'{name}' cannot be queued, so it cannot be a step",
            name = row.name
        );
        json.diagnostic(name, message)
    })?;
    let members = values.map_or(Ok(Vec::new()), |values| json.object(values))?;
    let texts = members.iter().map(|member| argument(json, member.value));
    let texts = texts.collect::<Result<Vec<_>, _>>()?;
    let arguments = members
        .iter()
        .zip(&texts)
        .map(|(member, text)| (&*member.key, &**text));
    let arguments: Vec<(&str, &str)> = arguments.collect();
    let mut room = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut room);
    let written = encode_text(layout, &arguments, &mut writer);
    written.map_err(|error| {
        let about = match error {
            ParseError::Value { field, .. } | ParseError::Twice(field) => layout.field(field.name),
            _ => None,
        };
        let member = members.iter().rev().find(|member| match error {
            ParseError::UnknownField(key) => member.key == key,
            _ => about.is_some() && layout.field(&member.key) == about,
        });
        let place = member.map_or(values.unwrap_or(name), |member| member.value);
        let error = error.to_string();
        json.diagnostic(place, message!("{name}: {error}", name = row.name, error))
    })?;
    let count = writer
        .finish()
        .map_err(|error| json.diagnostic(name, error.to_string()))?;
    let params = room.get(..count).unwrap_or_default();
    let command = Set::decode(row.id, params);
    let command = command.map_err(|error| json.diagnostic(name, error.to_string()))?;
    Ok(Action::Command(Box::new(command)))
}

/// Converts a value to the syntax of the command line, which [`encode_text`] parses: arrays with
/// commas, outputs as ratio:address:level.
fn argument<'t>(json: &Json<'t>, value: &'t str) -> Result<Cow<'t, str>, Diagnostic> {
    if !value.starts_with('[') {
        return item(json, value);
    }
    let mut parts: Vec<Cow<'t, str>> = Vec::new();
    json.each(value, |value| {
        parts.push(if value.starts_with('{') {
            output(json, value)?.into()
        } else {
            item(json, value)?
        });
        Ok(())
    })?;
    Ok(parts.join(",").into())
}

fn item<'t>(json: &Json<'t>, value: &'t str) -> Result<Cow<'t, str>, Diagnostic> {
    match value.as_bytes().first() {
        Some(b'"') => json.string(value),
        Some(b'[' | b'{') => {
            let message = message!("expected a number, a string or a list of them");
            Err(json.diagnostic(value, message))
        }
        _ => Ok(value.into()),
    }
}

fn output(json: &Json<'_>, value: &str) -> Result<String, Diagnostic> {
    let [mut ratio, mut address, mut level] = [None; 3];
    for member in json.object(value)? {
        let slot: &mut Option<u16> = match &*member.key {
            "ratio" => &mut ratio,
            "address" => &mut address,
            "level" => &mut level,
            _ => return Err(json.unknown(&member, "ratio, address, level")),
        };
        *slot = Some(json.number(member.value, || message!("a whole number"))?);
    }
    match (ratio, address, level) {
        (Some(ratio), Some(address), Some(level)) => Ok(format!("{ratio}:{address}:{level}")),
        _ => {
            let message = message!("an output has 'ratio', 'address' and 'level'");
            Err(json.diagnostic(value, message))
        }
    }
}
