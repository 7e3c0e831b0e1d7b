//! Folders of the sites that this machine belongs to.

use std::fs;
use std::io;
use std::path::PathBuf;

use magician_site::certificates::{Authority, Identity, day_of, is_machine_name};
use magician_site::keys::{SiteName, derive_name, is_name};

use crate::failure::Failure;
use crate::paint::print_stderr;
use crate::serving::unix_time;

/// Folder below the state folder.
const SITES_FOLDER: &str = "site";
/// Remaining validity below which a certificate is reported: 60 days, in seconds.
const EXPIRY_WARNING_TIME: i64 = 60 * 86_400;

/// Returns the folder that contains one folder per site.
pub(super) fn folders() -> Result<PathBuf, Failure> {
    let state = magician::dirs::state().ok_or_else(|| {
        let message = "no folder for certificates: neither XDG_STATE_HOME nor HOME is set";
        Failure::invalid(message)
    })?;
    Ok(state.join(SITES_FOLDER))
}

/// Returns the names of the sites, sorted.
pub(super) fn sites() -> Result<Vec<String>, Failure> {
    let folders = folders()?;
    let unreadable =
        |error| Failure::invalid(format!("{} cannot be read: {error}", folders.display()));
    let entries = match fs::read_dir(&folders) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(unreadable)?,
    };
    let mut names = Vec::new();
    for entry in entries {
        let name = entry.map_err(unreadable)?.file_name();
        names.extend(name.into_string().ok().filter(|name| is_name(name)));
    }
    names.sort();
    Ok(names)
}

/// Opens the authority of the named site, or of the only one on this machine.
pub(super) fn authority(site: Option<&str>) -> Result<Authority, Failure> {
    let folders = folders()?;
    if let Some(site) = site.filter(|site| !site.is_empty()) {
        let none = || {
            let message = format!("the site {} was not created on this machine", shown(site));
            Failure::invalid(message).hint("`magician site list` shows the sites of this machine")
        };
        if !is_name(site) {
            return Err(none());
        }
        return Authority::open(&folders.join(site))?.ok_or_else(none);
    }
    let mut authorities = Vec::new();
    for site in sites()? {
        authorities.extend(Authority::open(&folders.join(site))?);
    }
    let names: Vec<_> = authorities.iter().map(Authority::site).collect();
    let names = names.join(", ");
    match (authorities.pop(), authorities.is_empty()) {
        (Some(only), true) => Ok(only),
        (None, _) => Err(
            Failure::invalid("no site was created on this machine").hint(
                "create one: `magician site init NAME`; or use the machine where it was created",
            ),
        ),
        (Some(_), false) => {
            let message = format!("several sites were created on this machine: {names}");
            Err(Failure::usage(message).hint("give the name of one"))
        }
    }
}

/// Opens this machine's identity on a site; `None` if it has none. Warns the user if the
/// certificate expires soon.
pub(crate) fn identity(site: &SiteName) -> Result<Option<Identity>, Failure> {
    let Some(state) = magician::dirs::state() else {
        return Ok(None);
    };
    let identity = Identity::open(&state.join(SITES_FOLDER).join(site.as_str()))?;
    if let Some(identity) = &identity {
        let now = i64::try_from(unix_time().as_secs()).unwrap_or(i64::MAX);
        let ends = identity.ends();
        let renew = "to renew it, run `magician site invite` where the site was created, and \
            `magician site join CODE` here";
        if now < identity.begins() {
            print_stderr(format_args!(
                "the clock of this machine shows {}, but its certificate is valid from {}: set the \
                    clock, otherwise no other machine is found",
                day_of(now),
                day_of(identity.begins())
            ));
        } else if now >= ends {
            print_stderr(format_args!(
                "the certificate of this machine expired {}: {renew}",
                day_of(ends)
            ));
        } else if ends - now < EXPIRY_WARNING_TIME {
            print_stderr(format_args!(
                "the certificate of this machine expires {}: {renew}",
                day_of(ends)
            ));
        }
    }
    Ok(identity)
}

/// Returns this machine's name on a site: its host name, if that is a valid name.
pub(super) fn own_name() -> Option<String> {
    derive_name(&crate::mdns::host_name()).filter(|name| is_machine_name(name))
}

fn shown(name: &str) -> String {
    magician_protocol::visible(name).to_string()
}
