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

/// Set up a site of several machines: certificates and join codes
#[derive(Args, Debug)]
#[command(after_help = "\
The machines of a site authenticate each other with certificates. One machine creates the site; \
every other machine joins with a code that is typed or pasted there.

  magician site init lab               on the first machine
  magician site invite                 also there: prints a command for the other machine
  magician site join 192.168.1.5:41234/7KM2Q-..
                                       on the other machine, as printed
  magician serve --site lab            on each machine")]
pub(crate) struct Site {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Create a site with this machine as its first
    Init(Init),
    /// Let machines join: print the command to type there, and wait for them
    Invite(Invite),
    /// Join a site with the code of an invitation, or renew the certificate of this machine
    Join(Join),
    /// List the sites of this machine, and the machines of sites that were created here
    List {
        /// List only this site
        #[arg(value_name = "NAME", value_parser = name_of_site)]
        name: Option<String>,
    },
    /// Exclude a machine permanently: its certificates become invalid, and its name is not reused
    Revoke {
        /// Name of the machine, as in `site list`
        machine: String,
        /// Name of the site, if several were created here
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
    /// Name of this machine on the site [default: its host name]
    #[arg(long, value_name = "MACHINE")]
    name: Option<String>,
}

#[derive(Args, Debug)]
struct Invite {
    /// Name of the site, if several were created here
    #[arg(value_name = "NAME", env = "MAGICIAN_SITE", hide_env_values = true)]
    site: Option<String>,
    /// Validity of the code in minutes, 1 to 1440
    #[arg(long, value_name = "MINUTES", default_value = "10", value_parser = clap::value_parser!(u64).range(1..=1440))]
    minutes: u64,
    /// Number of machines that may join with the code, 1 to 1000
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..=1000))]
    machines: u64,
    /// Wait for the machines at this address; port 0: any free port
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "0.0.0.0:0")]
    listen: SocketAddr,
}

#[derive(Args, Debug)]
struct Join {
    /// Code printed by `site invite` on the machine that created the site
    code: String,
    /// Name of this machine on the site [default: its host name]
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
