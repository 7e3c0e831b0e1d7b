//! `--site`: the station as a member of a site.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use magician_station::http::TokenStore;
use magician_station::{ArmEntry, RunningStation};

use crate::failure::Failure;

// Ends the heading of the flags before these, which clap applies to all later flags of a verb.
#[derive(Args, Debug)]
#[command(next_help_heading = None::<&'static str>)]
pub(crate) struct SiteFlags {
    /// Join a site, so that `magician fleet --site NAME` on other machines sees the arms; arm names
    /// must be unique on the site
    #[arg(long, value_name = "NAME", value_parser = name_of_site, hide = cfg!(not(feature = "site")))]
    pub(super) site: Option<String>,
    /// Zenoh configuration for the site, a JSON5 file: listen addresses and peers
    #[arg(long, value_name = "FILE", requires = "site", value_hint = ValueHint::FilePath, hide = cfg!(not(feature = "site")))]
    site_config: Option<PathBuf>,
}

/// Parses the name of a site.
pub(crate) fn name_of_site(text: &str) -> Result<String, &'static str> {
    if magician_station::is_name(text) {
        Ok(text.to_owned())
    } else {
        Err(super::NAME_RULE)
    }
}

#[cfg(not(feature = "site"))]
pub(super) use without::SiteMembership;
#[cfg(not(feature = "site"))]
pub(crate) use without::unsupported;

/// Replacement in builds without sites: fails and names a build with them.
#[cfg(not(feature = "site"))]
mod without {
    use magician::ErrorKind;

    use crate::failure::{Failure, Kind};

    /// Never constructed in such a build.
    #[derive(Debug)]
    pub(in super::super) enum SiteMembership {}

    pub(crate) fn unsupported() -> Failure {
        let message = "this build of magician cannot join sites";
        Failure::new(Kind::Driver(ErrorKind::Unsupported), message)
            .hint("release builds can, and builds with `--features site`")
    }
}

#[cfg(not(feature = "site"))]
impl SiteFlags {
    /// Fails before anything is opened.
    pub(super) fn check(&self) -> Result<(), Failure> {
        match self.site {
            Some(_) => Err(unsupported()),
            None => Ok(()),
        }
    }

    pub(super) fn name_of_only_arm(&self) -> Option<String> {
        None
    }

    pub(super) async fn join(
        &self,
        _: &[ArmEntry],
        _: &RunningStation,
        _: &TokenStore,
    ) -> Result<Option<SiteMembership>, Failure> {
        Ok(None)
    }
}

#[cfg(not(feature = "site"))]
impl SiteMembership {
    pub(super) fn name(&self) -> &str {
        match *self {}
    }

    pub(super) fn station(&self) -> String {
        match *self {}
    }

    pub(super) async fn leave(self) {
        match self {}
    }
}

/// Membership in a site.
#[cfg(feature = "site")]
#[derive(Debug)]
pub(super) struct SiteMembership {
    name: String,
    node: magician_site::carrier::SiteNode,
}

#[cfg(feature = "site")]
impl SiteFlags {
    pub(super) fn check(&self) -> Result<(), Failure> {
        Ok(())
    }

    /// Returns the default name of a station's only arm on a site: the machine's name, because
    /// names must be unique on the site.
    pub(super) fn name_of_only_arm(&self) -> Option<String> {
        self.site.as_ref()?;
        magician_site::keys::derive_name(&crate::mdns::host_name())
    }

    pub(super) async fn join(
        &self,
        entries: &[ArmEntry],
        station: &RunningStation,
        tokens: &TokenStore,
    ) -> Result<Option<SiteMembership>, Failure> {
        use magician_site::carrier::{NodeOptions, ServedArm, SiteNode};
        use magician_site::keys::{SiteName, derive_name};

        let Some(name) = &self.site else {
            return Ok(None);
        };
        let arms = entries.iter().map(|entry| ServedArm {
            name: entry.name.clone(),
            port: entry.port.clone(),
            is_virtual: entry.is_virtual,
        });
        let site: SiteName = name.parse().map_err(Failure::usage)?;
        let identity = crate::verbs::site::identity(&site)?;
        let is_proved = identity.is_some();
        let machine = crate::mdns::host_name();
        let options = NodeOptions {
            site,
            machine: derive_name(&machine).unwrap_or_else(|| "machine".to_owned()),
            arms: arms.collect(),
            config: self.site_config.clone(),
            identity,
        };
        let node = SiteNode::join(options, station.clone(), tokens.clone()).await?;
        print_linger_warning();
        if !is_proved {
            crate::paint::print_stderr(format_args!(
                "this machine has no certificate of the site {name}: the site sees its arms, but \
                    cannot stop them. `magician site init {name}` creates the first certificate of \
                    a site, `magician site join CODE` gets one from that machine"
            ));
        }
        Ok(Some(SiteMembership {
            name: name.clone(),
            node,
        }))
    }
}

/// Prints a known flaw of this build, if it has one.
#[cfg(feature = "site")]
pub(crate) fn print_linger_warning() {
    if let Some(flaw) = magician_site::carrier::LINGER_WARNING {
        crate::paint::print_stderr(flaw);
    }
}

#[cfg(feature = "site")]
impl SiteMembership {
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn station(&self) -> String {
        self.node.id().to_string()
    }

    pub(super) async fn leave(self) {
        self.node.leave().await;
    }
}

#[cfg(feature = "site")]
impl From<magician_site::carrier::CarrierError> for Failure {
    fn from(error: magician_site::carrier::CarrierError) -> Self {
        use magician::ErrorKind;
        use magician_site::carrier::CarrierError;

        use crate::failure::Kind;

        let message = error.to_string();
        match error {
            CarrierError::Config(_) => Self::invalid(message).hint(
                "the file contains Zenoh's own settings, like the examples in docs/guide/site",
            ),
            CarrierError::Certificate(_) => Self::new(Kind::Driver(ErrorKind::Port), message)
                .hint("`magician site list` shows the certificate of this machine"),
            CarrierError::Taken { .. } => Self::new(Kind::Driver(ErrorKind::Port), message)
                .hint("give the arm another name: --arm NAME=PORT"),
            _ => Self::new(Kind::Driver(ErrorKind::Port), message),
        }
    }
}
