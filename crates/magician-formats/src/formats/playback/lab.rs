//! Reader of playback files of DobotLab, the studio's successor: a JSON list of motions and tool
//! actions.
//!
//! ```json
//! [{"key":1,"type":"move","device":"Magician","params":{"moveType":"moveJ","pointName":"P","point":[220,0,40,0],
//!   "slide":false,"slideL":0}},
//!  {"key":2,"type":"endtool","device":"Magician","params":{"name":"suctionCup","status":"on"}}]
//! ```
//!
//! Unknown entries are refused: skipping one would lead the arm elsewhere.

use magician_host::message;

use crate::formats::rail::RailCourse;
use crate::plan::json::{Json, Member};
use crate::{Action, Diagnostic, DiagnosticCode, Grip, Origin, Parsed, Plan, Tool, Travel};

/// Largest number of entries. It bounds memory.
const MAX_ENTRIES: usize = 1_000_000;

/// Entry of the list.
struct Entry {
    action: EntryKind,
    origin: Origin,
}

enum EntryKind {
    Move {
        motion: Action,
        rail: Option<f32>,
        name: String,
    },
    Tool(Action),
}

pub(super) fn read(text: &str) -> Result<Parsed<Plan>, Diagnostic> {
    let json = Json::of(text);
    let lines = json.lines();
    let whole = json.whole()?;
    let list = json.array(whole)?;
    if list.is_empty() {
        return Err(Diagnostic::of_file(message!(
            "the playback file has no entries"
        )));
    }
    if list.len() > MAX_ENTRIES {
        let message = message!(
            "too many entries: {count}, limit {limit}",
            count = list.len(),
            limit = MAX_ENTRIES
        );
        return Err(Diagnostic::of_file(message));
    }
    let mut notes = Vec::new();
    let mut entries = Vec::new();
    for value in list {
        entries.extend(entry(&json, value, json.place(&lines, value), &mut notes)?);
    }
    let rails = entries.iter().map(|entry| match &entry.action {
        EntryKind::Move { rail, .. } => *rail,
        EntryKind::Tool(_) => None,
    });
    let mut course = RailCourse::of(rails);
    notes.extend(course.note());
    let mut plan = Plan::default();
    for Entry { action, origin } in entries {
        match action {
            EntryKind::Move { motion, rail, name } => {
                let origin = match name.as_str() {
                    "" => origin,
                    _ => origin.named(plan.name(name)),
                };
                let along = course.with_rail(motion, rail);
                plan.push(along.map_err(|why| Diagnostic::new(origin, why))?, origin);
            }
            EntryKind::Tool(action) => {
                let tool = match action {
                    Action::Gripper(_) => Tool::Gripper,
                    _ => Tool::Suction,
                };
                if *plan.tool.get_or_insert(tool) != tool {
                    let message = message!("the file uses both the gripper and the suction cup");
                    let help = message!("an arm has one tool");
                    return Err(Diagnostic::new(origin, message).help(help));
                }
                plan.push(action, origin);
            }
        }
    }
    Ok(Parsed {
        content: plan,
        notes,
    })
}

/// Parses an entry; `None` if it has no effect.
fn entry<'t>(
    json: &Json<'t>,
    value: &'t str,
    origin: Origin,
    notes: &mut Vec<Diagnostic>,
) -> Result<Option<Entry>, Diagnostic> {
    let members = json.object(value)?;
    let text = |name: &str| string(json, &members, name);
    let device = text("device")?.unwrap_or_default();
    if !(device.is_empty() || device.eq_ignore_ascii_case("magician")) {
        let message = message!(
            "this was taught on a {device}, whose points are other positions here",
            device
        );
        let help = message!("teach the points again on a Magician");
        return Err(Diagnostic::new(origin, message).help(help));
    }
    let params = member(&members, "params").map(|member| member.value);
    let params = json.object(params.unwrap_or("{}"))?;
    let of_params = |name: &str| string(json, &params, name);
    let kind = text("type")?.unwrap_or_default();
    let action = match kind.as_str() {
        "move" => {
            let way = of_params("moveType")?.unwrap_or_default();
            let by = match way.to_ascii_lowercase().as_str() {
                "movej" | "movj" => Travel::Joints,
                "movel" | "movl" => Travel::Line,
                "jump" | "movejump" => Travel::Jump,
                _ => {
                    let message = message!("the motion '{way}' is not known", way);
                    let help = message!("known are jump, moveJ and moveL");
                    return Err(Diagnostic::new(origin, message).help(help));
                }
            };
            let point = member(&params, "point");
            let point = point.and_then(|point| serde_json::from_str::<Vec<f32>>(point.value).ok());
            let to = match point.as_deref() {
                Some([x, y, z, r]) if [x, y, z, r].iter().all(|value| value.is_finite()) => {
                    [*x, *y, *z, *r]
                }
                _ => {
                    let message = message!("the move has no point: [x, y, z, r] in mm and degrees");
                    return Err(Diagnostic::new(origin, message));
                }
            };
            let slides = member(&params, "slide").is_some_and(|slide| slide.value == "true");
            let at = member(&params, "slideL").map(|at| at.value.trim_matches('"').parse());
            let rail = match (slides, at) {
                (false, _) => None,
                (true, Some(Ok(at))) => Some(at).filter(|at: &f32| at.is_finite()),
                (true, _) => None,
            };
            if slides && rail.is_none() {
                let message =
                    message!("the move takes the rail along, and slideL does not say where to");
                return Err(Diagnostic::new(origin, message));
            }
            EntryKind::Move {
                motion: Action::Move { to, by },
                rail,
                name: of_params("pointName")?.unwrap_or_default(),
            }
        }
        "endtool" => {
            let name = of_params("name")?.unwrap_or_default();
            let status = of_params("status")?
                .unwrap_or_default()
                .to_ascii_lowercase();
            let tool = name.to_ascii_lowercase();
            let action = match (tool.as_str(), status.as_str()) {
                ("suctioncup" | "suction", "on" | "true") => Action::Suction(true),
                ("suctioncup" | "suction", "off" | "false") => Action::Suction(false),
                ("gripper", "open" | "on") => Action::Gripper(Grip::Open),
                ("gripper", "close" | "closed" | "grip") => Action::Gripper(Grip::Close),
                ("gripper", "off" | "false" | "disable") => Action::Gripper(Grip::Off),
                ("none" | "", _) => {
                    let note = message!("an entry without a tool is left out");
                    notes.push(Diagnostic::new(origin, note).coded(DiagnosticCode::LeftOut));
                    return Ok(None);
                }
                _ => {
                    let message = message!(
                        "the tool '{name}' with the state '{status}' is not known",
                        name,
                        status
                    );
                    let help =
                        message!("known are suctionCup (on, off) and gripper (open, close, off)");
                    return Err(Diagnostic::new(origin, message).help(help));
                }
            };
            EntryKind::Tool(action)
        }
        other => {
            let message = message!("an entry of the type '{kind}' is not known", kind = other);
            let help = message!("known are move and endtool");
            return Err(Diagnostic::new(origin, message).help(help));
        }
    };
    Ok(Some(Entry { action, origin }))
}

fn member<'m, 't>(members: &'m [Member<'t>], name: &str) -> Option<&'m Member<'t>> {
    members.iter().find(|member| member.key == name)
}

/// Returns the text of a member; `None` if it is absent or null.
fn string<'t>(
    json: &Json<'t>,
    members: &[Member<'t>],
    name: &str,
) -> Result<Option<String>, Diagnostic> {
    let value = member(members, name).map(|member| member.value);
    match value.filter(|value| *value != "null") {
        // Some files give the state of a tool as a boolean.
        Some(plain @ ("true" | "false")) => Ok(Some(plain.to_owned())),
        Some(value) => Ok(Some(json.string(value)?.into_owned())),
        None => Ok(None),
    }
}
