//! `site list`: lists the sites of this machine.

use magician_site::certificates::{Authority, Identity, day_of};
use serde_json::{Value, json};

use super::folders::{folders, sites};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;
use crate::serving::unix_time;

/// Site as this machine knows it.
struct LocalSite {
    folder: std::path::PathBuf,
    identity: Identity,
    authority: Option<Authority>,
}

pub(super) fn run(name: Option<&str>, context: &mut Context) -> Result<(), Failure> {
    let folders = folders()?;
    let names = name.map_or_else(sites, |name| Ok(vec![name.to_owned()]))?;
    let mut known = Vec::new();
    for site in names {
        let folder = folders.join(site);
        if let Some(identity) = Identity::open(&folder)? {
            known.push(LocalSite {
                authority: Authority::open(&folder)?,
                identity,
                folder,
            });
        }
    }
    if let (Some(name), true) = (name, known.is_empty()) {
        let message = format!("this machine is not a member of a site {name}");
        return Err(Failure::invalid(message).hint(
            "create it: `magician site init NAME`; or join it: `magician site invite` where it was created",
        ));
    }
    let sites: Vec<_> = known.iter().map(as_json).collect::<Result<_, _>>()?;
    context.show(&json!({ "sites": sites }), |out| {
        if known.is_empty() {
            out.line(
                "this machine is not a member of any site: `magician site init NAME` creates one",
            )?;
        }
        known.iter().try_for_each(|site| show(site, out))
    })
}

fn as_json(site: &LocalSite) -> Result<Value, Failure> {
    let identity = &site.identity;
    let mut object = json!({
        "name": identity.site(),
        "machine": identity.machine(),
        "folder": site.folder,
        "fingerprint": identity.fingerprint(),
        "ends": identity.ends(),
        "revoked": identity.is_revoked(),
    });
    if let Some(authority) = &site.authority {
        let machines = authority.members()?;
        let machines = machines.iter().map(
            |member| json!({"name": member.name, "ends": member.ends, "revoked": member.revoked}),
        );
        object["machines"] = machines.collect();
        object["authority_ends"] = json!(authority.ends());
    }
    Ok(object)
}

fn show(site: &LocalSite, out: &mut Output) -> Result<(), Failure> {
    let identity = &site.identity;
    out.line(format_args!(
        "{}: authority {}",
        identity.site(),
        identity.fingerprint()
    ))?;
    let mut columns = Columns::indented(2);
    let now = i64::try_from(unix_time().as_secs()).unwrap_or(i64::MAX);
    let until = |ends| {
        let word = if ends <= now { "ended" } else { "until" };
        format!("{word} {}", day_of(ends))
    };
    match &site.authority {
        Some(authority) => {
            for member in authority.members()? {
                let state = match member.revoked {
                    Some(at) => format!("revoked {}", day_of(at)),
                    None => until(member.ends),
                };
                let note = if member.name == identity.machine() {
                    "this machine, the authority"
                } else {
                    ""
                };
                columns.row([&*member.name, &state, note]);
            }
        }
        None => {
            let state = if identity.is_revoked() {
                "revoked".to_owned()
            } else {
                until(identity.ends())
            };
            columns.row([identity.machine(), &state, "this machine"]);
        }
    }
    columns.write(out)
}
