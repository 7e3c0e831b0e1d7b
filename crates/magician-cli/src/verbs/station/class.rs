//! `station class` and `station results`: what a teacher does for all pupils of a station.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueHint};
use magician_station::class::{ClassFile, codes_page, results_page};
use magician_station::client::StationClient;
use serde_json::{Value, json};

use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;
use crate::verbs::serve::stations;

#[derive(Args, Debug)]
pub(super) struct Class {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Make codes for the pupils of a class file that have none, write them into it, and print the list
    New {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: PathBuf,
        /// Write the codes as a page to print and cut up
        #[arg(long, value_name = "FILE")]
        html: Option<PathBuf>,
    },
    /// Print the pupils of the running station and their codes
    List {
        /// Write the codes as a page to print and cut up
        #[arg(long, value_name = "FILE")]
        html: Option<PathBuf>,
    },
    /// Give the running station another class file; without FILE the class ends
    Set {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: Option<PathBuf>,
    },
    /// Make new codes, for these pupils or for all: whoever signed in with an old one has to sign in again
    Codes {
        #[arg(value_name = "NAME")]
        pupils: Vec<String>,
    },
    /// Stop these arms, or all, until they are freed: jobs pause, the laser is off, pupils move nothing
    Freeze {
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Let pupils move these arms again, or all
    Free {
        #[arg(value_name = "ARM")]
        arms: Vec<String>,
    },
    /// Print whose turn it is and who waits
    Turns,
    /// Print the schedule, or give the running station the one of FILE
    Schedule {
        #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
        file: Option<PathBuf>,
    },
}

#[derive(Args, Debug)]
pub(super) struct Results {
    /// Write one page with the pictures: it needs nothing else, and prints well
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

/// Calls a method of the station that is meant: that of --station, else the one of this machine.
fn call(context: &mut Context, method: &str, params: Value) -> Result<Value, Failure> {
    let url = match &context.global.station {
        Some(url) => url.clone(),
        None => {
            let mut running: Vec<_> = stations().map(|(url, _)| url).collect();
            match running.len() {
                1 => running.remove(0),
                0 => {
                    let hint = "start one with `magician serve --class FILE`, or say where it is: --station URL";
                    return Err(Failure::invalid("no station runs on this machine").hint(hint));
                }
                _ => {
                    let message = format!("{} run on this machine", running.join(" and "));
                    return Err(Failure::invalid(message).hint("say which: --station URL"));
                }
            }
        }
    };
    let (token, trust) = (context.global.token(), context.global.trust());
    context.alone(async |_, _| {
        let client = StationClient::connect_trusting(&url, "magician", token.as_deref(), &trust);
        Ok(client.await?.call(method, params).await?)
    })
}

fn read(file: &Path) -> Result<String, Failure> {
    let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
    fs::read_to_string(file).map_err(wrong)
}

fn write(file: &Path, text: &str) -> Result<(), Failure> {
    let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
    magician_job::files::replace_private(file, text).map_err(wrong)
}

/// The pupils and their codes, a line each; as a page where one is wanted.
fn list(context: &mut Context, class: &Value, html: Option<&Path>) -> Result<(), Failure> {
    if let Some(file) = html {
        write(file, &codes_page(class))?;
    }
    context.show(class, |out| {
        let pupils = class["pupils"].as_array().map_or(&[][..], Vec::as_slice);
        if pupils.is_empty() {
            return out.line("the class has no pupils: add [[pupil]] name = \"..\" to its file");
        }
        let mut columns = Columns::default();
        for pupil in pupils {
            let text = |name: &str| pupil[name].as_str().unwrap_or_default();
            columns.row([text("name"), text("group"), text("code")]);
        }
        columns.write(out)
    })
}

fn arms(names: &[String]) -> Value {
    if names.is_empty() {
        json!({})
    } else {
        json!({"arms": names})
    }
}

impl Class {
    pub(super) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.what {
            What::New { file, html } => {
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
                let shown = json!({"pupils": pupils.collect::<Vec<_>>()});
                list(context, &shown, html.as_deref())
            }
            What::List { html } => {
                let class = call(context, "class.get", json!({}))?;
                list(context, &class, html.as_deref())
            }
            What::Set { file } => {
                let text = file.as_deref().map(read).transpose()?.unwrap_or_default();
                let class = call(context, "class.set", json!({"text": text}))?;
                list(context, &class, None)
            }
            What::Codes { pupils } => {
                let params = if pupils.is_empty() {
                    json!({})
                } else {
                    json!({"pupils": pupils})
                };
                let class = call(context, "class.codes", params)?;
                list(context, &class, None)
            }
            What::Freeze { arms: names } => {
                let done = call(context, "class.freeze", arms(&names))?;
                context.show(&done, |out| {
                    say(
                        out,
                        &done,
                        "frozen: free with `magician station class free`",
                    )
                })
            }
            What::Free { arms: names } => {
                let done = call(context, "class.free", arms(&names))?;
                context.show(&done, |out| say(out, &done, "free"))
            }
            What::Turns => {
                let turns = call(context, "turn.list", json!({}))?;
                context.show(&turns, |out| show_turns(out, &turns))
            }
            What::Schedule { file } => {
                let schedule = match file {
                    Some(file) => call(context, "schedule.set", json!({"text": read(&file)?}))?,
                    None => call(context, "schedule.get", json!({}))?,
                };
                context.show(&schedule, |out| match schedule["text"].as_str() {
                    Some(text) if !text.trim().is_empty() => out.line(text.trim_end()),
                    _ => out.line("no schedule: every arm is free at any time"),
                })
            }
        }
    }
}

fn say(out: &mut Output, done: &Value, state: &str) -> Result<(), Failure> {
    let arms = done["arms"].as_array().into_iter().flatten();
    let names: Vec<_> = arms.filter_map(Value::as_str).collect();
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
        columns.row([
            text(&arm["arm"]).as_str(),
            &text(&arm["person"]),
            &text(&arm["state"]),
            &left.unwrap_or_default(),
            frozen,
        ]);
    }
    columns.write(out)?;
    for place in turns["queue"].as_array().into_iter().flatten() {
        let absent = if place["missed"] == true {
            ", not there"
        } else {
            ""
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
    pub(super) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let results = call(context, "class.results", json!({}))?;
        if let Some(file) = &self.out {
            write(file, &results_page(&results))?;
        }
        context.show(&results, |out| {
            let items = results["results"].as_array().map_or(&[][..], Vec::as_slice);
            if items.is_empty() {
                return out.line("nothing yet: a pupil's job that is done comes here");
            }
            let mut columns = Columns::default();
            for item in items {
                let text = |name: &str| item[name].as_str().unwrap_or_default();
                let drawn = item["drawn_mm"].as_f64().map(|mm| format!("{mm:.0} mm"));
                columns.row([
                    text("pupil"),
                    text("title"),
                    text("arm"),
                    text("time"),
                    &drawn.unwrap_or_default(),
                ]);
            }
            columns.write(out)
        })
    }
}
