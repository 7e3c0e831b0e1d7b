//! Options common to a station and a hub: addresses, admission, encryption and the library of
//! programs.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueHint};
use magician_job::dirs;
use magician_station::ProgramStore;
use magician_station::http::{
    Admission, HttpOptions, ListenError, Listener, Pages, ProgramFolder, Tls, TokenStore,
};

use crate::config::Config;
use crate::failure::Failure;
use crate::paint::print_stderr;
use crate::verbs::station::tokens;
use magician::stations::{LocalStation, stations};

#[derive(Args, Debug)]
pub(crate) struct FrontFlags {
    /// Listen at this address [default: localhost:8910, reachable only from this machine]
    #[arg(long, value_name = "HOST:PORT")]
    pub(super) listen: Option<String>,
    /// Print a six-digit pairing code, valid for one token within two minutes
    #[arg(long)]
    pair: bool,
    /// Also accept the tokens in this file, one `TOKEN ROLE [NAME]` per line
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Let web pages of this origin use the station, such as https://example.org (repeatable)
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,
    /// Also answer requests for this host name (repeatable)
    #[arg(long, value_name = "HOST[:PORT]")]
    allow_host: Vec<String>,
    /// Encrypt connections with this certificate (PEM), followed by the certificates that signed
    /// it; needs --tls-key
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// Private key of the certificate (PEM)
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// Let everyone watch and stop, and no one move
    #[arg(long)]
    pub(crate) read_only: bool,
    /// Folder of the program library [default: `programs` in magician's user data folder]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    programs: Option<PathBuf>,
}

impl FrontFlags {
    /// Fills in settings that no flag sets.
    pub(crate) fn fill_in(&mut self, config: &Config) {
        let listen = || config.file_value("serve.listen").map(str::to_owned);
        self.listen = self.listen.take().or_else(listen);
        let programs = || config.file_value("serve.programs").map(PathBuf::from);
        self.programs = self.programs.take().or_else(programs);
        for (given, name) in [
            (&mut self.allow_host, "serve.allow_host"),
            (&mut self.allow_origin, "serve.allow_origin"),
        ] {
            if given.is_empty() {
                *given = config.list(name);
            }
        }
    }

    /// Opens the token store of this machine, extended by the user's token file.
    pub(crate) fn tokens(&self) -> Result<TokenStore, Failure> {
        let store = tokens()?;
        Ok(match &self.token_file {
            Some(path) => store.with_list(path)?,
            None => store,
        })
    }

    /// Loads certificate and key; `None` if connections are not encrypted.
    pub(crate) fn tls(&self) -> Result<Option<Tls>, Failure> {
        Ok(match (&self.tls_cert, &self.tls_key) {
            (Some(certificate), Some(key)) => Some(Tls::from_files(certificate, key)?),
            _ => None,
        })
    }

    /// Binds the addresses. Connections are accepted later.
    pub(crate) async fn bind(&self, tls: Option<Tls>) -> Result<Listener, Failure> {
        let listener = Listener::bind(self.listen.as_deref()).await;
        let listener = listener.map_err(bind_failure)?;
        Ok(match tls {
            Some(tls) => listener.encrypted(tls),
            None => listener,
        })
    }

    /// Opens the library of programs; `None` if the system has no folder for it.
    pub(crate) fn programs(&self) -> Result<Option<Arc<dyn ProgramStore>>, Failure> {
        let usual = || dirs::data().map(|data| data.join("programs"));
        let Some(folder) = self.programs.clone().or_else(usual) else {
            return Ok(None);
        };
        if folder.exists() && !folder.is_dir() {
            let message = format!("{} is not a folder", folder.display());
            return Err(Failure::invalid(message));
        }
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        Ok(Some(Arc::new(ProgramFolder::at(folder))))
    }

    /// Returns the hosts and origins that are admitted besides the station's own.
    pub(crate) fn admission(&self) -> Admission {
        Admission {
            hosts: self.allow_host.clone(),
            origins: self.allow_origin.clone(),
            ..Admission::default()
        }
    }

    /// Returns the HTTP options.
    pub(crate) fn http(&self, tokens: TokenStore, pages: Pages) -> HttpOptions {
        HttpOptions {
            admission: self.admission(),
            pages,
            ..HttpOptions::new(tokens, env!("CARGO_PKG_VERSION"))
        }
    }

    /// Prints a pairing code, if one is asked for.
    pub(crate) fn print_code(&self, tokens: &TokenStore) -> Result<(), Failure> {
        if self.pair {
            let code = tokens.pair(magician_station::Role::Student)?;
            print_stderr(format_args!(
                "code {code}, valid for one token within two minutes"
            ));
        }
        Ok(())
    }
}

/// Converts an error of binding into a failure. If the port is in use, the hint names the station
/// of this computer that has it.
fn bind_failure(error: ListenError) -> Failure {
    let port = match &error {
        ListenError::Bind(address, why) if why.kind() == io::ErrorKind::AddrInUse => address.port(),
        _ => return error.into(),
    };
    let failure = Failure::from(error);
    let is_there = |url: &str| url.trim_end_matches('/').ends_with(&format!(":{port}"));
    let station = stations().into_iter().find(|known| is_there(&known.url));
    failure.hint(match station {
        Some(LocalStation { url, arms, .. }) => format!(
            "a station of {} is running there: open {url}, or use another port: --listen 127.0.0.1:0 takes a free one",
            arms.join(", ")
        ),
        None => "another program is using that address: --listen 127.0.0.1:0 takes a free port".to_owned(),
    })
}
