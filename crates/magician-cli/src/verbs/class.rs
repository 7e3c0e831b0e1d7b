//! `class` and `results`, below `station` and `fleet`: commands of a teacher for all pupils of a
//! station or a site.
//!
//! Each command makes one request through the `call` that it is given: to one station, or through a
//! hub to all stations of a site.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueHint};
use magician_station::class::{ClassFile, codes_page, results_page};
use serde_json::{Value, json};

use crate::columns::Columns;
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;

/// At one station.
#[derive(Args, Debug)]
pub(super) struct Class {
    #[command(subcommand)]
    action: StationAction,
}

/// At all stations of a site. Pupils, turns and codes are a station's own.
#[derive(Args, Debug)]
pub(super) struct SiteClass {
    #[command(subcommand)]
    action: ClassAction,
}

#[derive(Debug, Subcommand)]
enum StationAction {
    #[command(flatten)]
    ClassAction(ClassAction),
    /// Generate new codes for these pupils, or for all; pupils signed in with an old code must sign
    /// in again
    Codes {
        /// Names of pupils [default: all]
        #[arg(value_name = "NAME")]
        pupils: Vec<String>,
    },
    /// End the turns at these arms, or at all; the next in the queue gets the arm
    End {
        /// Names of arms [default: all]
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Pass the turns at these arms, or at all, to the next in the queue; the previous holders go
    /// to its end
    Next {
        /// Names of arms [default: all]
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Print the current turns and the queue
    Turns,
}

#[derive(Debug, Subcommand)]
enum ClassAction {
    /// Generate missing codes for the pupils in a class file, save them in it, and print the list
    New {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: PathBuf,
        /// Write the codes to an HTML page to print and cut up
        #[arg(long, value_name = "FILE")]
        html: Option<PathBuf>,
    },
    /// Print the pupils and their codes
    List {
        /// Write the codes to an HTML page to print and cut up
        #[arg(long, value_name = "FILE")]
        html: Option<PathBuf>,
    },
    /// Set the class from a file; without FILE, end the class
    Set {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: Option<PathBuf>,
        /// Use the codes and the PIN of the file even for pupils who already have other codes
        #[arg(long, requires = "file")]
        use_codes: bool,
    },
    /// Stop these arms, or all, until they are freed: jobs pause, the laser goes off, pupils cannot
    /// move them
    Freeze {
        /// Names of arms [default: all]
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Let pupils move these arms, or all, again
    Free {
        /// Names of arms [default: all]
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Print the schedule, or set it from FILE
    Schedule {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: Option<PathBuf>,
    },
}

#[derive(Args, Debug)]
pub(super) struct Results {
    /// Write one self-contained, printable HTML page with the pictures
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

fn read(file: &Path) -> Result<String, Failure> {
    let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
    fs::read_to_string(file).map_err(wrong)
}

fn write(file: &Path, text: &str) -> Result<(), Failure> {
    let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
    magician_job::files::replace_private(file, text).map_err(wrong)
}

/// Lists pupils and their codes, one per line, and writes a printable page to `html`.
fn list(context: &mut Context, class: &Value, html: Option<&Path>) -> Result<(), Failure> {
    if let Some(file) = html {
        write(file, &codes_page(class))?;
    }
    context.show(class, |out| {
        if class.get("class").is_some_and(Value::is_null) {
            return out.line("there is no class: `class set FILE` sets one");
        }
        let pupils = class["pupils"].as_array().map_or(&[][..], Vec::as_slice);
        if pupils.is_empty() {
            return out.line("the class has no pupils: add [[pupil]] name = \"..\" to its file");
        }
        let mut columns = Columns::default();
        for pupil in pupils {
            let text = |name: &str| pupil[name].as_str().unwrap_or_default();
            columns.row([text("name"), text("group"), text("code")]);
        }
        columns.write(out)?;
        let kept = class["codes_kept"].as_array().into_iter().flatten();
        let kept: Vec<_> = kept.filter_map(Value::as_str).collect();
        if !kept.is_empty() {
            let kept = kept.join(", ");
            out.line(format_args!(
                "the file has other codes for {kept}: the codes above remain valid; --use-codes \
                    replaces them by those of the file"
            ))?;
        }
        match class["pin"].as_str() {
            Some(pin) => out.line(format_args!(
                "the teacher's PIN, for use at the station's computer: {pin}"
            )),
            None => Ok(()),
        }
    })
}

/// Fails if the stations of a site did not all apply the request alike. The answer of a single
/// station always passes.
fn check_all_applied(shown: &Value) -> Result<(), Failure> {
    let names = |arms: &Value| {
        let arms = arms.as_array().into_iter().flatten();
        let names: Vec<_> = arms.filter_map(Value::as_str).collect();
        names.join(", ")
    };
    let mut flaws = Vec::new();
    for (member, what) in [
        (
            "differ",
            if shown.get("class").is_some() {
                "class"
            } else {
                "schedule"
            },
        ),
        ("differ_in_schedule", "schedule"),
    ] {
        for station in shown[member].as_array().into_iter().flatten() {
            let has = if station["none"] == true {
                "no"
            } else {
                "another"
            };
            let machine = station["machine"].as_str();
            let machine = machine.map_or_else(String::new, |machine| format!(" (on {machine})"));
            flaws.push(format!(
                "{has} {what} at {}{machine}",
                names(&station["arms"])
            ));
        }
    }
    let missing = names(&shown["missing"]);
    if !missing.is_empty() {
        flaws.push(format!("no answer from {missing}"));
    }
    if flaws.is_empty() {
        return Ok(());
    }
    let message = format!("the stations differ: {}", flaws.join("; "));
    let timeout = Kind::Driver(magician::ErrorKind::Timeout);
    Err(Failure::new(timeout, message))
}

fn arms(names: &[String]) -> Value {
    if names.is_empty() {
        json!({})
    } else {
        json!({"arms": names})
    }
}

impl Class {
    pub(super) fn run(
        self,
        context: &mut Context,
        call: impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure>,
    ) -> Result<(), Failure> {
        self.action.run(context, call)
    }
}

#[cfg(feature = "site")]
impl SiteClass {
    pub(super) fn run(
        self,
        context: &mut Context,
        call: impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure>,
    ) -> Result<(), Failure> {
        self.action.run(context, "fleet", call)
    }
}

impl StationAction {
    fn run(
        self,
        context: &mut Context,
        call: impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::ClassAction(what) => what.run(context, "station", call),
            Self::Codes { pupils } => {
                let params = if pupils.is_empty() {
                    json!({})
                } else {
                    json!({"pupils": pupils})
                };
                let class = call(context, "class.codes", params)?;
                list(context, &class, None)
            }
            Self::End { arms: names } => {
                let done = call(context, "turn.end", arms(&names))?;
                context.show(&done, |out| {
                    print_arms(out, &done, "turn ended", "no arm has a turn")
                })
            }
            Self::Next { arms: names } => {
                let done = call(context, "turn.next", arms(&names))?;
                let nobody = "no turn is passed on: no one present is waiting";
                context.show(&done, |out| {
                    print_arms(out, &done, "turn passed on", nobody)
                })
            }
            Self::Turns => {
                let turns = call(context, "turn.list", json!({}))?;
                context.show(&turns, |out| show_turns(out, &turns))
            }
        }
    }
}

impl ClassAction {
    /// Runs the command `noun class ..`.
    fn run(
        self,
        context: &mut Context,
        noun: &str,
        call: impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::New { file, html } => {
                let text = read(&file)?;
                let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
                let mut class = ClassFile::parse(&text).map_err(wrong)?;
                let before = class.clone();
                class.make_codes(magician_station::class::random);
                if class != before {
                    write(&file, &class.to_text())?;
                }
                let pupils = class.pupil.iter().map(
                    |pupil| json!({"name": pupil.name, "group": pupil.group, "code": pupil.code}),
                );
                let shown = json!({"pupils": pupils.collect::<Vec<_>>(), "pin": class.class.pin});
                list(context, &shown, html.as_deref())
            }
            Self::List { html } => {
                let class = call(context, "class.get", json!({}))?;
                list(context, &class, html.as_deref())?;
                check_all_applied(&class)
            }
            Self::Set { file, use_codes } => {
                let text = file.as_deref().map(read).transpose()?.unwrap_or_default();
                let params = json!({"text": text, "use_codes": use_codes});
                let class = call(context, "class.set", params)?;
                list(context, &class, None)
            }
            Self::Freeze { arms: names } => {
                let done = call(context, "class.freeze", arms(&names))?;
                context.show(&done, |out| {
                    let how = format!("frozen: free with `magician {noun} class free`");
                    print_arms(out, &done, &how, "no arm")
                })
            }
            Self::Free { arms: names } => {
                let done = call(context, "class.free", arms(&names))?;
                context.show(&done, |out| print_arms(out, &done, "free", "no arm"))
            }
            Self::Schedule { file } => {
                let schedule = match file {
                    Some(file) => call(context, "schedule.set", json!({"text": read(&file)?}))?,
                    None => call(context, "schedule.get", json!({}))?,
                };
                context.show(&schedule, |out| match schedule["text"].as_str() {
                    Some(text) if !text.trim().is_empty() => out.line(text.trim_end()),
                    _ => out.line("no schedule: every arm is free at any time"),
                })?;
                check_all_applied(&schedule)
            }
        }
    }
}

/// Prints the arms that an answer names, or the text `none` for an empty list.
fn print_arms(out: &mut Output, done: &Value, state: &str, none: &str) -> Result<(), Failure> {
    let arms = done["arms"].as_array().into_iter().flatten();
    let names: Vec<_> = arms.filter_map(Value::as_str).collect();
    if names.is_empty() {
        return out.line(none);
    }
    out.line(format_args!("{} {state}", names.join(", ")))
}

fn show_turns(out: &mut Output, turns: &Value) -> Result<(), Failure> {
    let text = |value: &Value| value.as_str().unwrap_or("-").to_owned();
    let mut columns = Columns::default();
    for arm in turns["arms"].as_array().into_iter().flatten() {
        let left = arm["left_s"]
            .as_f64()
            .map(|left| format!("{left:.0} s left"));
        let frozen = if arm["frozen"] == true { "frozen" } else { "" };
        let jobs = arm["jobs"].as_array().map_or(0, Vec::len);
        let waiting = match jobs {
            0 => String::new(),
            1 => "1 program waits".to_owned(),
            more => format!("{more} programs wait"),
        };
        columns.row([
            text(&arm["arm"]).as_str(),
            &text(&arm["person"]),
            &text(&arm["state"]),
            &left.unwrap_or_default(),
            frozen,
            &waiting,
        ]);
    }
    columns.write(out)?;
    for place in turns["queue"].as_array().into_iter().flatten() {
        let absent = match place["reason"].as_str() {
            Some("away") => ", absent",
            Some("schedule") => ", waits for a slot in the schedule",
            Some("frozen") => ", waits until an arm is freed",
            _ => "",
        };
        out.line(format_args!(
            "{} {}{absent}",
            place["place"],
            text(&place["person"])
        ))?;
    }
    Ok(())
}

impl Results {
    pub(super) fn run(
        self,
        context: &mut Context,
        call: impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure>,
    ) -> Result<(), Failure> {
        let results = call(context, "class.results", json!({}))?;
        if let Some(file) = &self.out {
            write(file, &results_page(&results))?;
        }
        context.show(&results, |out| {
            let items = results["results"].as_array().map_or(&[][..], Vec::as_slice);
            if items.is_empty() {
                return out.line("no results yet: finished jobs of pupils are listed here");
            }
            let mut columns = Columns::default();
            for item in items {
                let text = |name: &str| item[name].as_str().unwrap_or_default();
                let drawn = item["drawn_mm"].as_f64().map(|mm| format!("{mm:.0} mm"));
                columns.row([
                    text("pupil"),
                    text("title"),
                    text("arm"),
                    text("time_local"),
                    &drawn.unwrap_or_default(),
                ]);
            }
            columns.write(out)
        })
    }
}
