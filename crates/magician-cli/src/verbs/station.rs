//! `station`: manages the tokens of this machine's stations, and the class of a station.

use clap::{Args, Subcommand};
use magician_station::Role;
use magician_station::client::StationClient;
use magician_station::http::{CODE_LIFETIME, TokenStore};
use serde_json::{Value, json};

use super::class::{Class, Results};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::serving::unix_time;
use magician::stations::{folder, stations};

/// Manage tokens, pairing codes and the class of a station
#[derive(Args, Debug)]
pub(crate) struct Station {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Create a token and print it once; list tokens, or revoke one
    Token(Token),
    /// Print a six-digit pairing code, valid for one token within two minutes
    Pair(Pair),
    /// Manage pupils, codes, turns and the schedule; freeze and free arms
    Class(Class),
    /// Print the results of the pupils of a running station
    Results(Results),
}

#[derive(Args, Debug)]
struct Token {
    /// Name of the new token [default: token-N]
    #[arg(long, value_name = "NAME")]
    new: Option<String>,
    /// Role of the token: viewer, student or teacher
    #[arg(long, value_name = "ROLE", default_value = "student", value_parser = role)]
    role: Role,
    /// List the tokens: name, role, creation and last use
    #[arg(long, conflicts_with_all = ["new", "revoke"])]
    list: bool,
    /// Revoke a token; a running station closes its sessions within a second
    #[arg(long, value_name = "NAME", conflicts_with = "new")]
    revoke: Option<String>,
}

#[derive(Args, Debug)]
struct Pair {
    /// Role of the token: viewer, student or teacher
    #[arg(long, value_name = "ROLE", default_value = "student", value_parser = role)]
    role: Role,
}

fn role(text: &str) -> Result<Role, String> {
    Role::named(text).ok_or_else(|| "expected viewer, student or teacher".to_owned())
}

/// Opens the store of tokens for this machine's stations.
pub(crate) fn tokens() -> Result<TokenStore, Failure> {
    let folder = folder().ok_or_else(|| {
        Failure::invalid("no folder for tokens: neither XDG_STATE_HOME nor HOME is set")
    })?;
    Ok(TokenStore::at(folder.join("tokens.toml")))
}

impl Station {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let store = tokens()?;
        match self.action {
            Action::Class(class) => class.run(context, call),
            Action::Results(results) => results.run(context, call),
            Action::Pair(pair) => {
                let code = store.pair(pair.role)?;
                let seconds = CODE_LIFETIME.as_secs();
                let answer = json!({"code": code, "role": pair.role.name(), "seconds": seconds});
                context.show(&answer, |out| out.line(&code))
            }
            Action::Token(token) if token.list => list(&store, context),
            Action::Token(Token {
                revoke: Some(name), ..
            }) => {
                store.revoke(&name)?;
                context.show(&json!({"revoked": name}), |out| {
                    out.line(format_args!("{name} is revoked"))
                })
            }
            Action::Token(token) => {
                let (name, text) = store.create(token.new.as_deref(), token.role)?;
                let answer = json!({"name": name, "role": token.role.name(), "token": text});
                context.show(&answer, |out| out.line(&text))
            }
        }
    }
}

/// Calls a method of the station at `--station`, or of the only one on this machine.
fn call(context: &mut Context, method: &str, params: Value) -> Result<Value, Failure> {
    let url = match &context.global.station {
        Some(url) => url.clone(),
        None => {
            let mut running: Vec<_> = stations().into_iter().map(|known| known.url).collect();
            match running.len() {
                1 => running.remove(0),
                0 => {
                    let hint = "start one with `magician serve --class FILE`, or give its address: --station URL";
                    return Err(
                        Failure::invalid("no station is running on this machine").hint(hint)
                    );
                }
                _ => {
                    let message = format!("{} are running on this machine", running.join(" and "));
                    return Err(Failure::invalid(message).hint("select one: --station URL"));
                }
            }
        }
    };
    let (token, trust) = (context.global.token_for(&url), context.global.trust());
    context.run_without_arm(async |_, _| {
        let client = StationClient::connect_trusting(&url, "magician", token.as_deref(), &trust);
        Ok(client.await?.call(method, params).await?)
    })
}

fn list(store: &TokenStore, context: &mut Context) -> Result<(), Failure> {
    let tokens = store.list()?;
    let entries: Vec<_> = { tokens.iter() }
        .map(|(name, token)| {
            json!({"name": name, "role": token.role, "made": token.made, "used": token.used})
        })
        .collect();
    context.show(&json!({"tokens": entries}), |out| {
        let mut columns = Columns::default();
        for (name, token) in &tokens {
            let used = token.used.map_or_else(
                || "never used".to_owned(),
                |used| format!("used {}", ago(used)),
            );
            columns.row([
                name.as_str(),
                &token.role,
                &format!("made {}", ago(token.made)),
                &used,
            ]);
        }
        columns.write(out)
    })
}

/// Describes the time since an instant, given in seconds since 1970.
fn ago(unix: u64) -> String {
    let seconds = unix_time().as_secs().saturating_sub(unix);
    match seconds {
        0..120 => format!("{seconds} s ago"),
        120..7200 => format!("{} min ago", seconds / 60),
        7200..172_800 => format!("{} h ago", seconds / 3600),
        _ => format!("{} days ago", seconds / 86_400),
    }
}
