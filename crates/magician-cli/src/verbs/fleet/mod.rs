//! `fleet`: commands for the arms of a site, on any machine.

#[cfg(feature = "site")]
mod expect;
#[cfg(feature = "site")]
mod hub;
#[cfg(feature = "site")]
mod list;
#[cfg(feature = "site")]
mod run;
#[cfg(feature = "site")]
mod stop;
#[cfg(feature = "site")]
mod studio;
#[cfg(feature = "site")]
mod watch;

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueHint};
use magician_program::Format;

use super::class::{Results, SiteClass};
use super::job::options::PresetName;
use super::job::options::{Makes, OptionFlags};
use super::serve::{FrontFlags, name_of_site};
#[cfg(not(feature = "site"))]
use crate::context::Context;
#[cfg(not(feature = "site"))]
use crate::failure::Failure;
use crate::options::seconds_from_zero;

/// List, watch, stop and run the arms of all stations of a site
#[derive(Args, Debug)]
#[command(after_help = "\
Stations join a site with `magician serve --site NAME`; on a local network they find each other. \
Everything beyond viewing needs a token of the stations in MAGICIAN_TOKEN; `magician station token` \
creates one.

  magician fleet --site lab list
  magician fleet --site lab watch
  magician fleet --site lab stop --all
  magician fleet --site lab expect
  magician fleet --site lab run star.svg --on a1,a2,a3 --stagger 2
  magician fleet --site lab run star.svg --any 5 --fit
  magician fleet --site lab studio
  magician fleet --site lab class set class.toml
  magician fleet --site lab class freeze")]
pub(crate) struct Fleet {
    /// Name of the site
    #[arg(long, env = "MAGICIAN_SITE", hide_env_values = true, global = true, value_name = "NAME", value_parser = optional_site_name)]
    site: Option<String>,
    /// Zenoh configuration for the site, a JSON5 file
    #[arg(long, global = true, value_name = "FILE", value_hint = ValueHint::FilePath)]
    site_config: Option<PathBuf>,
    #[command(subcommand)]
    action: Action,
}

impl Fleet {
    /// True for the hub of the studio.
    pub(crate) fn serves(&self) -> bool {
        matches!(self.action, Action::Studio(_))
    }
}

#[cfg(feature = "site")]
impl Action {
    /// True if the verb only shows what stations report, and sends them nothing.
    fn is_read_only(&self) -> bool {
        match self {
            Self::List | Self::Watch => true,
            Self::Expect(expect) => expect.show,
            _ => false,
        }
    }
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the arms: name, station, machine, port, state, holder, job
    List,
    /// Watch the arms until Ctrl-C: a table on a terminal, otherwise one line per change
    Watch,
    /// Stop the named arms, or all, at the same time
    Stop(Stop),
    /// Store the arms now on the site as expected: `stop --all` and `class` then report missing
    /// ones
    Expect(Expect),
    /// Run a file on several arms
    Run(Box<Run>),
    /// View and move all arms in the browser, as if they were at one station
    Studio(Box<Studio>),
    /// Manage class and schedule, freeze and free arms, at all stations
    Class(SiteClass),
    /// Print the results of the pupils of all stations
    Results(Results),
}

#[derive(Args, Debug)]
#[command(after_help = "\
Serves the page of `magician studio`; its overview shows the arms of every station as they come and \
go. Opened on this machine, the page uses the token in MAGICIAN_TOKEN, without which this command \
does not start; opened on another machine, it needs a token that is valid here and at the stations. \
Leases stay with the stations: when this program ends, jogs and moves stop, and jobs continue or \
pause as chosen at their start. Ends with Ctrl-C.")]
struct Studio {
    #[command(flatten)]
    front: FrontFlags,
    /// Do not open a browser
    #[arg(long)]
    no_open: bool,
}

#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
struct Stop {
    /// Names of the arms
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Stop every arm of the site
    #[arg(long)]
    all: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Each station stores the list; `class set` adds the arms that are present. An arm that a station \
expects is reported as missing until it appears, or until that station gets a new list.")]
struct Expect {
    /// Print the expected arms and mark missing ones
    #[arg(long, conflicts_with = "none")]
    show: bool,
    /// Clear the list of expected arms
    #[arg(long)]
    none: bool,
}

#[derive(Args, Debug)]
#[group(id = "where", required = true, multiple = false, args = ["on", "any"])]
#[command(after_help = "\
The file is checked for every arm first; nothing starts unless all arms can do it. Each arm runs it \
as a job of its own, which continues if this program or the network fails; Ctrl-C stops the jobs \
that this command started, --detach leaves them to the stations at once.")]
struct Run {
    /// File to run; `-` reads stdin
    #[arg(value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// File type, if neither name nor content shows it; values as for `magician run`
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// Names of the arms to use
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    on: Vec<String>,
    /// Use N arms that are free, homed and without alarms, in the order of their names
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    any: Option<u64>,
    /// Delay from the start of one arm to the start of the next, in seconds
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = seconds_from_zero)]
    stagger: std::time::Duration,
    /// Exit after starting the jobs, which continue at the stations
    #[arg(long)]
    detach: bool,
    /// Run even if an arm is not known to be homed since power-up; positions may be wrong
    #[arg(long)]
    unhomed: bool,
    /// Preset of the stations for flags that are not given
    #[arg(long, value_name = "NAME", value_parser = PresetName, hide_possible_values = true)]
    preset: Option<String>,
    #[command(flatten)]
    options: OptionFlags<Makes>,
}

/// Parses the name of a site. An empty variable counts as not set, as for the port.
fn optional_site_name(text: &str) -> Result<String, &'static str> {
    match text {
        "" => Ok(String::new()),
        text => name_of_site(text),
    }
}

#[cfg(not(feature = "site"))]
impl Fleet {
    pub(crate) fn run(self, _: &mut Context) -> Result<(), Failure> {
        Err(super::serve::unsupported())
    }
}

#[cfg(feature = "site")]
pub(super) use with::{Known, condition, gather, job_of};

#[cfg(feature = "site")]
mod with {
    use std::collections::{BTreeMap, BTreeSet};
    use std::time::Duration;

    use magician::ErrorKind;
    use magician_site::carrier::ZenohSite;
    use magician_site::keys::SiteName;
    use magician_site::{ArmAt, ArmReport, Caller, Site};
    use serde_json::{Value, json};
    use tokio::time::{Instant, sleep_until, timeout_at};

    use super::{Action, Fleet};
    use crate::context::Context;
    use crate::failure::{Failure, Kind};
    use crate::paint::print_stderr;
    use crate::verbs::serve::print_linger_warning;
    use crate::verbs::site::identity;

    /// Time after joining in which present arms appear. A choice: long for a local network, short
    /// for a user who waits.
    const DISCOVERY_TIME: Duration = Duration::from_millis(700);
    /// Longest wait, from joining on, for the state of every arm. A choice.
    const STATE_TIMEOUT: Duration = Duration::from_millis(1300);

    /// Alarm that an arm raises at power-on, until it is cleared.
    const RESET_OCCURRED: u64 = 0;

    /// Present arms with their latest state; `None` if none has been received.
    pub(in super::super) type Known = BTreeMap<ArmAt, Option<ArmReport>>;

    impl Fleet {
        pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
            let caller = Caller {
                token: context.global.token(),
            };
            let config = self.site_config.as_deref();
            let name = self.site.filter(|name| !name.is_empty());
            let is_read_only = self.action.is_read_only();
            let join = async || {
                let Some(name) = name else {
                    return Err(Failure::usage("no site given").hint(
                        "give --site NAME, the name used by the stations, or set MAGICIAN_SITE",
                    ));
                };
                let name: SiteName = name.parse().map_err(Failure::usage)?;
                let identity = identity(&name)?;
                if identity.is_none() && !is_read_only {
                    return Err(no_certificate(&name));
                }
                print_linger_warning();
                if identity.is_none() {
                    print_stderr(format_args!(
                        "this information is not authenticated: this machine has no certificate of the site {name}"
                    ));
                }
                Ok::<_, Failure>(ZenohSite::join(name, config, identity).await?)
            };
            match self.action {
                Action::List => super::list::run(context, join),
                Action::Watch => super::watch::run(context, join),
                Action::Stop(stop) => stop.run(context, caller, join),
                Action::Expect(expect) => expect.run(context, caller, join),
                Action::Run(run) => run.run(context, caller, join),
                Action::Studio(studio) => studio.run(context, caller, join),
                Action::Class(class) => class.run(context, super::hub::requester(caller, join)),
                Action::Results(results) => {
                    results.run(context, super::hub::requester(caller, join))
                }
            }
        }
    }

    /// A request carries the user's token, and tokens are sent only to stations with a verified
    /// certificate.
    fn no_certificate(site: &SiteName) -> Failure {
        let message = format!(
            "this machine has no certificate of the site {site}: its stations can be viewed, but not controlled"
        );
        Failure::new(Kind::Driver(ErrorKind::Timeout), message).hint(format!(
            "`magician site init {site}` creates the first certificate of a site; other machines \
                get theirs with `magician site invite` there and `magician site join CODE` here"
        ))
    }

    /// Waits until the arms of a site have appeared. Fails if no arm appears.
    pub(in super::super) async fn gather(site: &ZenohSite) -> Result<Known, Failure> {
        let begun = Instant::now();
        let mut events = site.watch();
        sleep_until(begun + DISCOVERY_TIME).await;
        let all_told = async {
            while site.arms().is_empty() || site.arms().values().any(Option::is_none) {
                events.next().await;
            }
        };
        // A timeout is not an error: an arm without news is listed without a state.
        let _ = timeout_at(begun + STATE_TIMEOUT, all_told).await;
        let arms = site.arms();
        if arms.is_empty() {
            return Err(no_arm_failure(site));
        }
        Ok(arms)
    }

    fn no_arm_failure(site: &ZenohSite) -> Failure {
        let message = format!("there are no arms on the site {}", site.name());
        Failure::new(Kind::Driver(ErrorKind::Timeout), message)
            .hint("stations join it with `magician serve --site NAME`, on the same network")
    }

    /// Returns the names that more than one station uses for an arm.
    pub(in super::super) fn twins(known: &Known) -> BTreeSet<String> {
        let mut seen = BTreeSet::new();
        let names = known.keys().map(|at| at.arm.clone());
        names.filter(|name| !seen.insert(name.clone())).collect()
    }

    /// Describes the state of an arm in a word or two.
    pub(in super::super) fn condition(report: Option<&ArmReport>) -> String {
        let state = match report {
            Some(report) if !report.state.is_null() => &report.state,
            Some(_) => return "no line".to_owned(),
            None => return "silent".to_owned(),
        };
        let alarms: Vec<_> = { state["alarms"].as_array().into_iter().flatten() }
            .filter_map(Value::as_u64)
            // Present on every arm that was switched on; `not homed` describes it better.
            .filter(|code| *code != RESET_OCCURRED)
            .map(|code| format!("{code:#04x}"))
            .collect();
        if state["link"] == "lost" {
            "no line".to_owned()
        } else if !alarms.is_empty() {
            format!("alarm {}", alarms.join(" "))
        } else if state["moving"] == true {
            "moving".to_owned()
        } else if state["homed"] == false {
            "not homed".to_owned()
        } else {
            "ready".to_owned()
        }
    }

    /// Returns an arm's job and its lease holder, empty for an arm without.
    pub(in super::super) fn job_of(report: Option<&ArmReport>) -> (String, String) {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        report.map_or_else(Default::default, |report| {
            (
                text(&report.state["job"]),
                text(&report.state["holder"]["name"]),
            )
        })
    }

    /// Returns an arm as JSON.
    pub(in super::super) fn as_json(
        at: &ArmAt,
        report: Option<&ArmReport>,
        is_twin: bool,
    ) -> Value {
        json!({
            "name": at.arm,
            "station": at.station.to_string(),
            "machine": report.map(|report| &report.machine),
            "port": report.map(|report| &report.port),
            "virtual": report.map(|report| report.is_virtual),
            "twin": is_twin,
            "state": report.map_or(&Value::Null, |report| &report.state),
        })
    }
}
#[cfg(feature = "site")]
pub(super) use with::{as_json, twins};
