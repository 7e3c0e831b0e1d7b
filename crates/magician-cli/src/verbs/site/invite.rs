//! `site invite`: accepts a new machine by a code.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::time::Duration;

use magician::ErrorKind;
use magician_site::certificates::{Invitation, InvitationEnd, InvitationEvent, Refusal, day_of};
use serde_json::json;
use tokio::net::TcpListener;
use tokio::time::Instant;

use super::Invite;
use super::folders::authority;
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;

impl Invite {
    pub(super) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let machines = usize::try_from(self.machines).unwrap_or(usize::MAX);
        let invitation = Invitation::new(authority(self.site.as_deref())?, machines)?;
        let invitation = Arc::new(invitation);
        let json = context.global.json;
        let end = context.run_without_arm(async |out, signals| {
            let listener = TcpListener::bind(self.listen).await;
            let listener = listener.map_err(|error| cannot_listen(self.listen, &error))?;
            let at = listener
                .local_addr()
                .map_err(|error| cannot_listen(self.listen, &error))?;
            self.print_code(&invitation, at, out, json)?;
            let until = Instant::now() + Duration::from_secs(self.minutes * 60);
            // A broken pipe must not end the invitation: the first error of output is reported at
            // the end.
            let mut told = Ok(());
            let tell = |event| {
                let now = print_event(&event, out, json);
                told = std::mem::replace(&mut told, Ok(())).and(now);
            };
            let end = tokio::select! {
                end = invitation.clone().run(listener, until, tell) => end?,
                _ = signals.next() => return Err(Failure::interrupted()),
            };
            told.map(|()| end)
        })?;
        self.ended(&invitation, end)
    }

    /// Prints the command to type on the other machine.
    fn print_code(
        &self,
        invitation: &Invitation,
        at: SocketAddr,
        out: &mut Output,
        json: bool,
    ) -> Result<(), Failure> {
        let site = invitation.authority().site();
        let addresses = external_addresses(at);
        let addresses: Vec<_> = addresses.iter().map(ToString::to_string).collect();
        let [first, others @ ..] = &addresses[..] else {
            return Err(Failure::invalid("this machine has no network address"));
        };
        let code = invitation.code(first).to_string();
        let line = format!("magician site join {code}");
        if json {
            out.event(&json!({
                "event": "invited",
                "site": site,
                "code": code,
                "line": line,
                "addresses": addresses,
                "machines": self.machines,
                "seconds": self.minutes * 60,
            }))?;
            return out.flush();
        }
        let who = match self.machines {
            1 => "the other machine".to_owned(),
            machines => format!("{machines} other machines"),
        };
        let minutes = self.minutes;
        out.line(format_args!(
            "to join the site {site}, run on {who} within {minutes} min:"
        ))?;
        out.line("")?;
        out.line(format_args!("  {line}"))?;
        out.line("")?;
        if !others.is_empty() {
            let others = others.join(", ");
            out.line(format_args!(
                "if {first} cannot be reached from there, other addresses of this machine are: {others}"
            ))?;
        }
        out.flush()
    }

    fn ended(&self, invitation: &Invitation, end: InvitationEnd) -> Result<(), Failure> {
        let site = invitation.authority().site();
        let again = format!("for a new code: `magician site invite {site}`");
        match end {
            InvitationEnd::Full => Ok(()),
            InvitationEnd::Void => {
                let message = "too many wrong codes: this code is no longer valid";
                Err(Failure::unexpected(message).hint(again))
            }
            _ => {
                let (joined, machines) = (invitation.joined(), self.machines);
                let message = format!(
                    "{joined} of {machines} machines joined within {} min",
                    self.minutes
                );
                Err(Failure::new(Kind::Driver(ErrorKind::Timeout), message).hint(again))
            }
        }
    }
}

/// Prints an event of the invitation.
fn print_event(event: &InvitationEvent, out: &mut Output, json: bool) -> Result<(), Failure> {
    match event {
        InvitationEvent::Joined {
            name,
            ends,
            is_renewal,
        } => {
            if json {
                let event = json!({"event": "joined", "machine": name, "ends": ends, "renewed": is_renewal});
                out.event(&event)?;
            } else {
                let done = if *is_renewal {
                    "renewed its certificate"
                } else {
                    "joined"
                };
                out.line(format_args!("{name} {done}, until {}", day_of(*ends)))?;
            }
        }
        InvitationEvent::Refused {
            name,
            refusal,
            error,
        } => {
            let why = match (refusal, error) {
                (Refusal::Failed, Some(error)) => error.to_string(),
                _ => refusal.to_string(),
            };
            if json {
                out.event(&json!({"event": "refused", "machine": name, "reason": refusal, "message": why}))?;
            } else {
                let name = magician_protocol::visible(name);
                out.line(format_args!("`{name}` was refused: {why}"))?;
            }
        }
        _ => {}
    }
    out.flush()
}

fn cannot_listen(at: SocketAddr, error: &io::Error) -> Failure {
    let message = format!("{at} cannot be served: {error}");
    Failure::new(Kind::Driver(ErrorKind::Port), message)
        .hint("--listen 0.0.0.0:0 takes any free port")
}

/// Returns the addresses by which other machines reach a listener, this machine's outgoing address
/// first.
fn external_addresses(at: SocketAddr) -> Vec<SocketAddr> {
    if !at.ip().is_unspecified() {
        return vec![at];
    }
    let is_of_use = |ip: &IpAddr| match ip {
        IpAddr::V4(ip) => !ip.is_loopback() && !ip.is_link_local(),
        IpAddr::V6(ip) => at.is_ipv6() && !ip.is_loopback() && !ip.is_unicast_link_local(),
    };
    let interfaces = if_addrs::get_if_addrs().unwrap_or_default();
    let own = interfaces.iter().map(if_addrs::Interface::ip);
    let mut addresses: Vec<_> = outgoing_address()
        .ok()
        .into_iter()
        .chain(own)
        .filter(is_of_use)
        .collect();
    // Last resort, for a second site member on the same machine.
    addresses.push(Ipv4Addr::LOCALHOST.into());
    let mut seen = std::collections::HashSet::new();
    addresses.retain(|ip| seen.insert(*ip));
    if addresses.len() > 1 {
        addresses.pop();
    }
    { addresses.into_iter() }
        .map(|ip| SocketAddr::new(ip, at.port()))
        .collect()
}

/// Returns this machine's outgoing address.
fn outgoing_address() -> io::Result<IpAddr> {
    // Connecting a UDP socket sends nothing; it only makes the system choose a source address.
    // 192.0.2.1 is reserved for documentation (RFC 5737).
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9))?;
    Ok(socket.local_addr()?.ip())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explicit_address_is_the_only_one() {
        let at: SocketAddr = "127.0.0.1:7".parse().unwrap();
        assert_eq!(external_addresses(at), [at]);
    }

    #[test]
    fn a_listener_at_all_addresses_is_reached_by_each_of_the_machine_once() {
        let found = external_addresses("0.0.0.0:7".parse().unwrap());
        let mut seen = std::collections::HashSet::new();
        assert!(!found.is_empty());
        for address in found {
            assert!(
                address.is_ipv4() && !address.ip().is_unspecified(),
                "{address}"
            );
            assert_eq!(address.port(), 7);
            assert!(seen.insert(address), "{address} twice");
        }
    }
}
