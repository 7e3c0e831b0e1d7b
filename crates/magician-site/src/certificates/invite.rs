//! An invitation: the authority's side of joining.
//!
//! The authority listens for joining machines until enough have joined, time is up, or the secret
//! was guessed wrongly too often. The listener is open to the network, so everything is bounded:
//! silent connections, all connections, time per connection, wrong attempts, and certificates per
//! machine.

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
use super::wire::{self, Answer, MAX_REQUEST_SIZE, Request};
use super::{Authority, CertificateError, JoinCode, Refusal};

/// Timeout for one machine: handshake, request and reply. Much longer than a school network needs.
const EXCHANGE_TIMEOUT: Duration = Duration::from_secs(10);
/// Most connections that have not sent a request. A new one evicts the oldest, so that silent
/// connections cannot keep a machine out: a machine has the time in which this number of others
/// connect.
const MAX_SILENT_CONNECTIONS: usize = 64;
/// Most connections, including connections whose request is being answered. Further ones wait in
/// the backlog of the listener.
const MAX_CONNECTIONS: usize = 2 * MAX_SILENT_CONNECTIONS;
/// Pause after a failed accept: the system may have run out of file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Wrong secrets after which the code is void. A joining machine never sends a mistyped secret, so
/// each wrong one is a guess.
const MAX_WRONG_SECRETS: u32 = 3;
/// Most certificates for one machine. It asks again if a reply was lost. All of them go on the list
/// once the machine is revoked, and the size of that list is bounded.
const MAX_CERTIFICATES_PER_MACHINE: u32 = 8;

/// Invitation to join a site: one secret, valid for a number of machines.
#[derive(Debug)]
pub struct Invitation {
    authority: Authority,
    secret: String,
    machines: usize,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Machines that joined, with the number of certificates of each.
    joined: BTreeMap<String, u32>,
    wrong: u32,
    /// Decided requests whose event was not reported yet.
    unreported: usize,
}

/// Event at an invitation.
#[derive(Debug)]
#[non_exhaustive]
pub enum InvitationEvent {
    /// A machine joined, or renewed its certificate.
    Joined {
        /// Name of the machine.
        name: String,
        /// End of validity of its certificate, Unix seconds.
        ends: i64,
        /// True if it had a certificate before.
        is_renewal: bool,
    },
    /// A machine was refused.
    Refused {
        /// Requested name. Untrusted: any text.
        name: String,
        /// Reason given to the machine.
        refusal: Refusal,
        /// Cause of [`Refusal::Failed`], otherwise `None`.
        error: Option<CertificateError>,
    },
}

/// Reason why an invitation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvitationEnd {
    /// All invited machines have joined.
    Full,
    /// Time is up.
    Expired,
    /// Too many wrong secrets.
    Void,
}

impl Invitation {
    /// Creates an invitation for this number of machines.
    ///
    /// # Errors
    /// [`CertificateError::Random`] if the system provides no random numbers.
    pub fn new(authority: Authority, machines: usize) -> Result<Self, CertificateError> {
        Ok(Self {
            authority,
            secret: new_secret()?,
            machines,
            state: Mutex::default(),
        })
    }

    /// Code for machines that reach this one at `address`, `HOST:PORT`.
    #[must_use]
    pub fn code(&self, address: &str) -> JoinCode {
        JoinCode::new(address, &self.secret, self.authority.certificate())
    }

    /// The inviting authority.
    #[must_use]
    pub fn authority(&self) -> &Authority {
        &self.authority
    }

    /// Number of machines that have joined.
    #[must_use]
    pub fn joined(&self) -> usize {
        self.state().joined.len()
    }

    /// Serves machines until enough have joined, `until` has passed, or the code is void. Dropping
    /// the future ends the invitation; its code is then no longer valid.
    ///
    /// # Errors
    /// [`CertificateError::Tls`] if TLS cannot use the authority's certificate.
    pub async fn run(
        self: Arc<Self>,
        listener: TcpListener,
        until: Instant,
        mut tell: impl FnMut(InvitationEvent),
    ) -> Result<InvitationEnd, CertificateError> {
        let acceptor = TlsAcceptor::from(Arc::new(self.authority.invitation_server()?));
        let mut exchanges = JoinSet::new();
        let mut silent = VecDeque::new();
        let mut tell = |event| {
            if let Ok(Some(event)) = event {
                self.state().unreported -= 1;
                tell(event);
            }
        };
        while self.end().is_none() {
            tokio::select! {
                // Polled in this order: report finished joins before the deadline ends the loop.
                biased;
                Some(event) = exchanges.join_next() => tell(event),
                () = sleep_until(until) => break,
                accepted = listener.accept(), if exchanges.len() < MAX_CONNECTIONS => {
                    let Ok((stream, _)) = accepted else {
                        sleep(ACCEPT_PAUSE).await;
                        continue;
                    };
                    // A closed sender belongs to a connection whose request has arrived, or that
                    // has ended.
                    silent.retain(|stay: &oneshot::Sender<Infallible>| !stay.is_closed());
                    if silent.len() >= MAX_SILENT_CONNECTIONS {
                        silent.pop_front();
                    }
                    let (stay, stays) = oneshot::channel();
                    silent.push_back(stay);
                    let (invitation, acceptor) = (self.clone(), acceptor.clone());
                    exchanges.spawn(async move {
                        let may_evict = async { drop(stays.await) };
                        invitation.answer(&acceptor, stream, may_evict).await
                    });
                }
            }
        }
        drop(listener);
        // Machines whose certificate was signed still get their reply; each has its exchange
        // timeout.
        while self.state().unreported > 0
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
        } else if state.wrong >= MAX_WRONG_SECRETS {
            Some(InvitationEnd::Void)
        } else {
            None
        }
    }

    /// Serves one connection. Until its request has arrived, `may_evict` can end it. Returns `None`
    /// if no request arrived in time.
    pub(super) async fn answer(
        &self,
        acceptor: &TlsAcceptor,
        stream: impl AsyncRead + AsyncWrite + Unpin,
        may_evict: impl Future<Output = ()>,
    ) -> Option<InvitationEvent> {
        let mut event = None;
        let exchange = async {
            let asked = async {
                let mut stream = acceptor.accept(stream).await?;
                let request: Request = wire::read(&mut stream, MAX_REQUEST_SIZE).await?;
                io::Result::Ok((stream, request))
            };
            let (mut stream, request) = tokio::select! {
                asked = asked => asked?,
                () = may_evict => return Err(io::ErrorKind::ConnectionAborted.into()),
            };
            let (answer, happened) = self.decide(&request);
            self.state().unreported += 1;
            event = Some(happened);
            wire::write(&mut stream, &answer).await?;
            stream.shutdown().await
        };
        // The decision is recorded, so it is reported even if the machine did not get the reply.
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
        if state.wrong >= MAX_WRONG_SECRETS || is_full || had >= MAX_CERTIFICATES_PER_MACHINE {
            return refused(Refusal::Over, None);
        }
        if !is_equal_constant_time(&request.secret, &self.secret) {
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

/// Compares secrets in constant time, apart from their lengths: timing must not reveal how much of
/// a guess is right.
fn is_equal_constant_time(one: &str, other: &str) -> bool {
    let differences = one.bytes().zip(other.bytes()).map(|(a, b)| a ^ b);
    let difference = differences.fold(0, |sum, bits| std::hint::black_box(sum | bits));
    one.len() == other.len() && difference == 0
}
