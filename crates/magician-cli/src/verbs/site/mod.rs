//! `site`: manages the machines of a site and their certificates.

#[cfg(feature = "site")]
mod failures;
#[cfg(feature = "site")]
mod folders;
#[cfg(feature = "site")]
mod invite;
#[cfg(feature = "site")]
mod list;
#[cfg(feature = "site")]
mod members;

#[cfg(feature = "site")]
pub(crate) use self::folders::identity;

use std::net::SocketAddr;

use clap::{Args, Subcommand};

use super::serve::name_of_site;
use crate::context::Context;
use crate::failure::Failure;

/// Make a site of several machines: certificates, and codes to join
#[derive(Args, Debug)]
#[command(after_help = "\
Machines of a site know each other by certificates. One machine makes the site; every other one joins by a code that is typed or pasted there.

  magician site init lab               at the first machine
  magician site invite                 there, too: prints a line for the other machine
  magician site join 192.168.1.5:41234/7KM2Q-..
                                       at the other machine, as printed
  magician serve --site lab            at each machine")]
pub(crate) struct Site {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Make a site, with this machine as its first
    Init(Init),
    /// Let machines join: print the line to type there, and wait for them
    Invite(Invite),
    /// Join a site by the code of an invitation, or renew the certificate of this machine
    Join(Join),
    /// List the sites of this machine; where a site was made, its machines
    List {
        /// This site only
        #[arg(value_name = "NAME", value_parser = name_of_site)]
        name: Option<String>,
    },
    /// Shut a machine out, for good: its certificates are worth nothing, and its name is not given again
    Revoke {
        /// The machine, as `site list` names it
        machine: String,
        /// The site, if several were made here
        #[arg(
            long,
            env = "MAGICIAN_SITE",
            hide_env_values = true,
            value_name = "NAME"
        )]
        site: Option<String>,
    },
}

#[derive(Args, Debug)]
struct Init {
    /// Name of the new site
    #[arg(value_name = "NAME", value_parser = name_of_site)]
    site: String,
    /// Name of this machine on it; its host name by default
    #[arg(long, value_name = "MACHINE")]
    name: Option<String>,
}

#[derive(Args, Debug)]
struct Invite {
    /// The site, if several were made here
    #[arg(value_name = "NAME", env = "MAGICIAN_SITE", hide_env_values = true)]
    site: Option<String>,
    /// Validity of the code, minutes
    #[arg(long, value_name = "MINUTES", default_value = "10", value_parser = clap::value_parser!(u64).range(1..=1440))]
    minutes: u64,
    /// Number of machines that may join by it
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..=1000))]
    machines: u64,
    /// Wait for them at this address; port 0: any free one
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "0.0.0.0:0")]
    listen: SocketAddr,
}

#[derive(Args, Debug)]
struct Join {
    /// The code, as `site invite` prints it at the machine that made the site
    code: String,
    /// Name of this machine on the site; its host name by default
    #[arg(long, value_name = "MACHINE")]
    name: Option<String>,
}

#[cfg(not(feature = "site"))]
impl Site {
    pub(crate) fn run(self, _: &mut Context) -> Result<(), Failure> {
        Err(super::serve::unsupported())
    }
}

#[cfg(feature = "site")]
impl Site {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.action {
            Action::Init(init) => init.run(context),
            Action::Invite(invite) => invite.run(context),
            Action::Join(join) => join.run(context),
            Action::List { name } => list::run(name.as_deref(), context),
            Action::Revoke { machine, site } => members::revoke(&machine, site.as_deref(), context),
        }
    }
}
