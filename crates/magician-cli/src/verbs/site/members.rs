//! `site init`, `site join`, `site revoke`: create a site, join one, and remove a machine.

use magician_site::carrier::distribute_revoked;
use magician_site::certificates::{Authority, JoinCode, day_of, join};
use serde_json::json;

use super::folders::{authority, folders, own_name};
use super::{Init, Join};
use crate::context::Context;
use crate::failure::Failure;
use crate::paint::print_stderr;
use crate::serving::unix_time;

fn no_name() -> Failure {
    Failure::usage("the host name of this machine is not a valid name on a site")
        .hint("give it one: --name MACHINE")
}

impl Init {
    pub(super) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let folder = folders()?.join(&self.site);
        let machine = self.name.or_else(own_name).ok_or_else(no_name)?;
        let authority = Authority::init(&folder, &self.site, &machine)?;
        let identity = authority.identity()?;
        let (site, fingerprint) = (authority.site(), authority.fingerprint());
        let made = json!({
            "site": site,
            "machine": machine,
            "folder": folder,
            "fingerprint": fingerprint,
            "ends": identity.ends(),
            "authority_ends": authority.ends(),
        });
        context.show(&made, |out| {
            out.line(format_args!(
                "site {site} created; this machine is {machine} on it"
            ))?;
            out.line(format_args!("  in           {}", folder.display()))?;
            out.line(format_args!("  fingerprint  {fingerprint}"))?;
            let ends = day_of(identity.ends());
            out.line(format_args!(
                "  valid until  {ends}; the authority until {}",
                day_of(authority.ends())
            ))?;
            out.line(
                "Keep ca.key in this folder secret, and a backup of the folder where only you \
                can read it: anyone with ca.key can add machines, and without it no one can.",
            )?;
            out.line(format_args!(
                "Next, for each other machine: magician site invite {site}"
            ))
        })
    }
}

impl Join {
    pub(super) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let code: JoinCode = self.code.parse().map_err(|rule: &str| {
            Failure::usage(rule)
                .hint("`magician site invite` prints it on the machine that created the site")
        })?;
        let folders = folders()?;
        // A machine that is already on the site keeps its name there, so an unusable host name is
        // no error yet.
        let usual = own_name().unwrap_or_default();
        let name = self.name;
        let joined = context.run_with_own_line(async |_| {
            let joined = join(&code, &folders, name.as_deref(), &usual).await;
            joined.map_err(Failure::from)
        })?;
        let (identity, is_renewal) = (joined.identity, joined.is_renewal);
        let (site, machine, ends) = (identity.site(), identity.machine(), identity.ends());
        let fingerprint = identity.fingerprint();
        let told = json!({
            "site": site,
            "machine": machine,
            "folder": folders.join(site),
            "fingerprint": fingerprint,
            "ends": ends,
            "renewed": is_renewal,
        });
        context.show(&told, |out| {
            let until = day_of(ends);
            if is_renewal {
                return out.line(format_args!(
                    "the certificate of {machine} on the site {site} is \
                    renewed until {until}; restart programs that use it"
                ));
            }
            out.line(format_args!("this machine is {machine} on the site {site}"))?;
            out.line(format_args!(
                "  in           {}",
                folders.join(site).display()
            ))?;
            out.line(format_args!("  fingerprint  {fingerprint}"))?;
            out.line(format_args!("  valid until  {until}"))?;
            out.line(format_args!("Next: magician serve --site {site}"))
        })?;
        let now = i64::try_from(unix_time().as_secs()).unwrap_or(i64::MAX);
        if !(identity.begins()..ends).contains(&now) {
            print_stderr(format_args!(
                "note: the clock of this machine shows {}: set it, otherwise certificates of other \
                    machines count as expired",
                day_of(now)
            ));
        }
        Ok(())
    }
}

/// Revokes the certificate of a machine.
pub(super) fn revoke(
    machine: &str,
    site: Option<&str>,
    context: &mut Context,
) -> Result<(), Failure> {
    let authority = authority(site)?;
    authority.revoke(machine)?;
    let site = authority.site();
    let identity = authority.identity()?;
    let name = site.parse().map_err(Failure::usage)?;
    // The revocation is stored. Members that are absent now learn of it when they start.
    let distributed =
        context.run_with_own_line(async |_| Ok(distribute_revoked(name, None, &identity).await))?;
    context.show(&json!({"site": site, "revoked": machine, "told": distributed.is_ok()}), |out| {
        out.line(format_args!("{machine} is revoked on the site {site}; its name is not reused"))?;
        out.line(match &distributed {
            Ok(()) => "Machines now on the site have been informed; others learn it when they connect.".to_owned(),
            Err(error) => format!("No other machine has been informed ({error}): they learn it \
                while this machine runs `magician serve --site {site}`"),
        })?;
        out.line("It may know tokens: create new ones for all stations, and new codes and PIN of \
            the class if it had a teacher's token.")
    })
}
