//! An invitation: the authority's side of joining.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, sleep_until, timeout};
use tokio_rustls::TlsAcceptor;

use super::code::new_secret;
use super::wire::{self, Answer, LARGEST_REQUEST, Request};
use super::{Authority, CertificateError, JoinCode, Refusal};

/// Time for one machine: handshake, request and answer. A network of a school takes much less.
const EXCHANGE_TIMEOUT: Duration = Duration::from_secs(10);
/// Connections without a request at once. The oldest gives way to one that comes, so that silent ones
/// keep no machine out: it has as long as so many others need to come.
const MOST_SILENT: usize = 64;
/// Connections at once, with those that are answered; more wait to be accepted.
const MOST_CONNECTIONS: usize = 2 * MOST_SILENT;
/// Pause after a connection that cannot be accepted: the system may lack descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Wrong secrets until the code is void. A joining machine sends no mistyped one, so each is a guess.
const WRONG_TRIES: u32 = 3;
/// Certificates for one machine, at most: it asks again if an answer was lost. Each is in the list once
/// the machine is revoked, and a list has an end.
const CERTIFICATES: u32 = 8;

/// An invitation to join a site: one secret, good for some machines.
#[derive(Debug)]
pub struct Invitation {
    authority: Authority,
    secret: String,
    machines: usize,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// The machines that joined, with the number of certificates of each.
    joined: BTreeMap<String, u32>,
    wrong: u32,
    /// Requests that were decided and whose event was not told yet.
    untold: usize,
}

/// What happens at an invitation.
#[derive(Debug)]
#[non_exhaustive]
pub enum InvitationEvent {
    /// A machine joined, or renewed its certificate.
    Joined {
        /// Its name.
        name: String,
        /// End of the validity of its certificate, Unix seconds.
        ends: i64,
        /// True if it had a certificate before.
        is_renewal: bool,
    },
    /// A machine was refused.
    Refused {
        /// The name that it wanted: any text at all.
        name: String,
        /// What it was told.
        refusal: Refusal,
        /// Why the authority failed, for [`Refusal::Failed`].
        error: Option<CertificateError>,
    },
}

/// How an invitation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvitationEnd {
    /// As many machines have joined as were invited.
    Full,
    /// The time is over.
    Expired,
    /// The secret was guessed wrongly too often.
    Void,
}

impl Invitation {
    /// Invites this many machines.
    ///
    /// # Errors
    /// [`CertificateError::Random`].
    pub fn new(authority: Authority, machines: usize) -> Result<Self, CertificateError> {
        Ok(Self {
            authority,
            secret: new_secret()?,
            machines,
            state: Mutex::default(),
        })
    }

    /// The code for machines that reach this one by `HOST:PORT`.
    #[must_use]
    pub fn code(&self, address: &str) -> JoinCode {
        JoinCode::new(address, &self.secret, self.authority.certificate())
    }

    /// The authority.
    #[must_use]
    pub fn authority(&self) -> &Authority {
        &self.authority
    }

    /// Number of machines that have joined.
    #[must_use]
    pub fn joined(&self) -> usize {
        self.state().joined.len()
    }

    /// Answers machines until enough have joined, or the code is no longer good. May be dropped at any
    /// time; the code is not good after it.
    ///
    /// # Errors
    /// [`CertificateError::Tls`] if TLS cannot use the authority's certificate.
    pub async fn run(
        self: Arc<Self>,
        listener: TcpListener,
        until: Instant,
        mut tell: impl FnMut(InvitationEvent),
    ) -> Result<InvitationEnd, CertificateError> {
        let acceptor = TlsAcceptor::from(Arc::new(self.authority.inviting()?));
        let mut exchanges = JoinSet::new();
        let mut silent = VecDeque::new();
        let mut tell = |event| {
            if let Ok(Some(event)) = event {
                self.state().untold -= 1;
                tell(event);
            }
        };
        while self.end().is_none() {
            tokio::select! {
                // Joins before the end of the time.
                biased;
                Some(event) = exchanges.join_next() => tell(event),
                () = sleep_until(until) => break,
                accepted = listener.accept(), if exchanges.len() < MOST_CONNECTIONS => {
                    let Ok((stream, _)) = accepted else {
                        sleep(ACCEPT_PAUSE).await;
                        continue;
                    };
                    silent.retain(|stay: &oneshot::Sender<Infallible>| !stay.is_closed());
                    if silent.len() >= MOST_SILENT {
                        silent.pop_front();
                    }
                    let (stay, stays) = oneshot::channel();
                    silent.push_back(stay);
                    let (invitation, acceptor) = (self.clone(), acceptor.clone());
                    exchanges.spawn(async move {
                        let gives_way = async { drop(stays.await) };
                        invitation.answer(&acceptor, stream, gives_way).await
                    });
                }
            }
        }
        drop(listener);
        // Machines that got a certificate get it whole, each within the time of an exchange.
        while self.state().untold > 0
            && let Some(event) = exchanges.join_next().await
        {
            tell(event);
        }
        Ok(self.end().unwrap_or(InvitationEnd::Expired))
    }

    pub(super) fn end(&self) -> Option<InvitationEnd> {
        let state = self.state();
        if state.joined.len() >= self.machines {
            Some(InvitationEnd::Full)
        } else if state.wrong >= WRONG_TRIES {
            Some(InvitationEnd::Void)
        } else {
            None
        }
    }

    /// Answers one connection, which may have to give way until its request is there. `None` if it was
    /// no joining machine, or did not wait for its answer.
    pub(super) async fn answer(
        &self,
        acceptor: &TlsAcceptor,
        stream: impl AsyncRead + AsyncWrite + Unpin,
        gives_way: impl Future<Output = ()>,
    ) -> Option<InvitationEvent> {
        let mut event = None;
        let exchange = async {
            let asked = async {
                let mut stream = acceptor.accept(stream).await?;
                let request: Request = wire::read(&mut stream, LARGEST_REQUEST).await?;
                io::Result::Ok((stream, request))
            };
            let (mut stream, request) = tokio::select! {
                asked = asked => asked?,
                () = gives_way => return Err(io::ErrorKind::ConnectionAborted.into()),
            };
            let (answer, happened) = self.decide(&request);
            self.state().untold += 1;
            event = Some(happened);
            wire::write(&mut stream, &answer).await?;
            stream.shutdown().await
        };
        // What was decided counts, whether the machine heard it or not.
        let _ = timeout(EXCHANGE_TIMEOUT, exchange).await;
        event
    }

    fn decide(&self, request: &Request) -> (Answer, InvitationEvent) {
        let refused = |refusal, error| {
            let name = request.name.clone();
            let event = InvitationEvent::Refused {
                name,
                refusal,
                error,
            };
            (Answer::Refused(refusal), event)
        };
        let mut state = self.state();
        let had = state.joined.get(&request.name).copied().unwrap_or(0);
        let is_full = state.joined.len() >= self.machines && had == 0;
        if state.wrong >= WRONG_TRIES || is_full || had >= CERTIFICATES {
            return refused(Refusal::Over, None);
        }
        if !is_same(&request.secret, &self.secret) {
            state.wrong += 1;
            return refused(Refusal::Secret, None);
        }
        let revoked = || -> Result<String, CertificateError> {
            let list = self.authority.folder().list(self.authority.certificate())?;
            Ok(list.map_or_else(String::new, |list| list.to_pem()))
        };
        let signed = self.authority.sign(&request.request, &request.name);
        match signed.and_then(|signed| Ok((signed, revoked()?))) {
            Ok((signed, revoked)) => {
                state.joined.insert(request.name.clone(), had + 1);
                let event = InvitationEvent::Joined {
                    name: request.name.clone(),
                    ends: signed.ends,
                    is_renewal: signed.is_renewal,
                };
                let certificate = signed.certificate;
                let answer = Answer::Joined {
                    certificate,
                    revoked,
                };
                (answer, event)
            }
            Err(CertificateError::Name(_)) => refused(Refusal::Name, None),
            Err(CertificateError::Taken(_)) => refused(Refusal::Taken, None),
            Err(CertificateError::Revoked(_)) => refused(Refusal::Revoked, None),
            Err(CertificateError::Request) => refused(Refusal::Request, None),
            Err(error) => refused(Refusal::Failed, Some(error)),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Compares secrets in a time that depends on their lengths alone.
fn is_same(one: &str, other: &str) -> bool {
    let differences = one.bytes().zip(other.bytes()).map(|(a, b)| a ^ b);
    let difference = differences.fold(0, |sum, bits| std::hint::black_box(sum | bits));
    one.len() == other.len() && difference == 0
}
