//! Signing in to a class: codes of pupils, the PIN of the teacher, and the persons of sessions.

use magician::admission::Origin;
use magician::{Message, message};
use magician_protocol::HostInstant;
use serde_json::Value;

use super::class::Person;
use super::newest::{LIST_INTERVAL, Newest};
use super::sessions::RoleSource;
use super::socket::CloseCode;
use super::{Peer, Station};
use crate::api::{Params, Role, RpcError};
use crate::control::{CodeLimit, CodeTry, PersonId, SessionId, TooManyCodes};
use crate::secret::same_secret;

/// Key under which wrong PINs are counted. Cannot collide with a pupil: names contain no control
/// characters.
const TEACHER_KEY: &str = "\n";

impl Station {
    /// Signs in a pupil by name and code. Returns the pupil's name, or `None` if the hello has no
    /// `pupil`.
    ///
    /// # Errors
    /// The name or the code is wrong, or there were too many wrong codes.
    pub(super) fn sign_in(
        &mut self,
        now: HostInstant,
        params: &Params,
        address: &str,
    ) -> Result<Option<String>, RpcError> {
        let Some(given) = params.object("pupil") else {
            return Ok(None);
        };
        let text = |name: &str| given.get(name).and_then(Value::as_str);
        let (Some(name), Some(code), 2) = (text("name"), text("code"), given.len()) else {
            return Err(RpcError::param(
                "pupil",
                message!("`pupil` is {shape}", shape = "{name, code}"),
            ));
        };
        let Some(file) = &self.class.file else {
            let why =
                message!("this station has no class: sign in without `pupil`, or ask the teacher");
            return Err(RpcError::new(RpcError::FORBIDDEN, why));
        };
        // The key of the rate limit: case must not give a name further tries, nor its length
        // memory.
        let key = name.chars().take(40).collect::<String>().to_lowercase();
        let is_pupil = file.has(&key);
        let mut found = None;
        let tried = { &mut self.class.wrong }.attempt(now, &key, is_pupil, address, || {
            found = file.signs_in(name, code).map(|pupil| pupil.name.clone());
            found.is_some()
        });
        match tried {
            Ok(CodeTry::Right) => Ok(found),
            Ok(CodeTry::Wrong) => {
                // The same sentence for both, which does not reveal whether the name exists.
                let why = message!("name or code is not good: both are on the slip of paper");
                Err(RpcError::new(RpcError::FORBIDDEN, why))
            }
            Err(met) => {
                let of = match met.bound {
                    CodeLimit::Name => message!("codes of this name"),
                    CodeLimit::Address => message!("codes from this address"),
                };
                Err(too_many_codes(&of, &met))
            }
        }
    }

    /// Returns true if a hello contains the teacher's PIN. Such a hello must not contain a pupil or
    /// a token.
    ///
    /// # Errors
    /// Same as [`try_pin`](Self::try_pin).
    pub(super) fn teacher_signs_in(
        &mut self,
        now: HostInstant,
        params: &Params,
        peer: &Peer,
    ) -> Result<bool, RpcError> {
        let Some(pin) = params.text("pin") else {
            return Ok(false);
        };
        if params.get("pupil").is_some() || params.get("token").is_some() {
            let why = message!("`pin` is the teacher's: without `pupil` and `token`");
            return Err(RpcError::param("pin", why));
        }
        self.try_pin(now, pin, peer).map(|()| true)
    }

    /// Checks the teacher's PIN. It is valid on this machine alone: six digits are too few for a
    /// network, where tokens are used, and so a remote client cannot use up the teacher's tries.
    ///
    /// # Errors
    /// -32001 for a wrong PIN, without a class, and from elsewhere; -32006 after too many wrong ones.
    pub fn try_pin(&mut self, now: HostInstant, pin: &str, peer: &Peer) -> Result<(), RpcError> {
        let forbidden = |why: Message| Err(RpcError::new(RpcError::FORBIDDEN, why));
        let Some(good) = self.pin().map(str::to_owned) else {
            return forbidden(message!("this station has no class: a PIN is of a class"));
        };
        if peer.origin != Origin::Loopback {
            return forbidden(message!(
                "the PIN is for the computer that has the arms: another one needs a token"
            ));
        }
        let wrong = &mut self.class.wrong;
        match wrong.attempt(now, TEACHER_KEY, true, &peer.place(), || {
            same_secret(&good, pin)
        }) {
            Ok(CodeTry::Right) => Ok(()),
            Ok(CodeTry::Wrong) => forbidden(message!(
                "the PIN is not good: the teacher sees it where the station was started, and by `class.get`"
            )),
            Err(met) => Err(too_many_codes(&message!("PINs"), &met)),
        }
    }

    /// Returns the teacher's PIN. `None` without a class, or before the PIN was made.
    #[must_use]
    pub fn pin(&self) -> Option<&str> {
        let own = self.class.file.as_ref().map(|file| &file.class.pin);
        let pin = own.or(self.class.elsewhere.as_ref())?;
        (!pin.is_empty()).then_some(pin)
    }

    /// Sets the PIN of the class held by the stations behind this one.
    ///
    /// `None` if they have no class. If it changes, the sockets of anonymous clients of this
    /// machine, and of those with the PIN, are closed and reconnect with their new role.
    pub fn set_class_elsewhere(&mut self, now: HostInstant, pin: Option<String>) {
        if self.class.elsewhere == pin {
            return;
        }
        self.class.elsewhere = pin;
        let out: Vec<_> = { self.sessions.iter() }
            // Only these have their role from the class.
            .filter(|(_, session)| {
                matches!(session.role_source, RoleSource::Place | RoleSource::Pin)
            })
            .map(|(id, session)| (*id, session.socket))
            .collect();
        for (session, socket) in out {
            if let Some(socket) = socket {
                self.end_socket(socket, CloseCode::RECONNECT);
            }
            self.control.expel(now, session);
        }
        self.carry_out_effects(now);
    }

    /// Adjusts the role of anonymous clients of this machine when a class begins or ends. With a
    /// class they become viewers, and their leases end like those of a revoked token; without one
    /// they are teachers again.
    pub(super) fn anonymous_role_changed(&mut self, now: HostInstant) {
        let role = self.anonymous_role();
        let mut changed = Vec::new();
        for (id, session) in &mut self.sessions {
            if role == Role::Teacher && session.role_source == RoleSource::Pin {
                // Signed in with the PIN of a class that is over.
                session.role_source = RoleSource::Place;
            }
            let own = role.min(session.max_role);
            if session.role_source == RoleSource::Place && session.grant.role != own {
                session.grant.role = own;
                changed.push(*id);
            }
        }
        for session in changed {
            self.notice_rates.changed(Newest::Sessions, LIST_INTERVAL);
            if role == Role::Teacher {
                self.control.unbind(session);
                continue;
            }
            for arm in self.control.held_by(session).collect::<Vec<_>>() {
                // Evicted and not released: motion of a session that becomes a viewer has to stop.
                self.control.evict(now, arm);
            }
            // The waits and questions of the session end too. The session itself stays as a viewer.
            self.control.leave(now, session);
            if self.sessions[&session].socket.is_some() {
                self.control.rejoin(now, session);
            }
            self.identify(now, session);
        }
    }

    /// Reports the person of a session to control. Teachers are not reported.
    pub(super) fn identify(&mut self, now: HostInstant, session: SessionId) {
        let Some(known) = self.sessions.get(&session) else {
            return;
        };
        if known.grant.role == Role::Teacher {
            return;
        }
        let person = match (&known.pupil, &known.grant.token) {
            (Some(name), _) => Some(Person::Pupil(name.clone())),
            (None, Some(token)) => Some(Person::Token(token.clone())),
            (None, None) => None,
        };
        let person = person.map(|person| self.number_of(person));
        self.control.identify(now, session, person);
    }

    /// Returns the number of a person. A token with the name of a pupil is that pupil, on another
    /// page: two numbers would mean two turns for one name.
    pub(super) fn number_of(&mut self, person: Person) -> PersonId {
        let file = self.class.file.as_ref();
        let person = match person {
            Person::Token(name) => match file.and_then(|file| file.named_ignoring_case(&name)) {
                Some(pupil) => Person::Pupil(pupil.name.clone()),
                None => Person::Token(name),
            },
            pupil @ Person::Pupil(_) => pupil,
        };
        let persons = &mut self.class.persons;
        let at = persons.iter().position(|known| *known == person);
        let at = at.unwrap_or_else(|| {
            // Numbers are never reused, because claims and turns refer to them.
            persons.push(person);
            persons.len() - 1
        });
        PersonId(at as u64)
    }

    /// Identifies the sessions of tokens again after a change of the class, which may have added or
    /// removed a pupil with that name. A session that becomes another person loses turn, place and
    /// queued jobs.
    pub(super) fn identify_tokens(&mut self, now: HostInstant) {
        let tokens: Vec<_> = { self.sessions.iter() }
            .filter(|(_, session)| session.pupil.is_none())
            .filter_map(|(id, session)| Some((*id, session.grant.token.clone()?)))
            .collect();
        for (session, token) in tokens {
            let Some(before) = self.control.person(session) else {
                continue;
            };
            if self.number_of(Person::Token(token)) != before {
                self.control.leave_turn(now, before);
                self.stop_queued_of(now, before);
                self.identify(now, session);
            }
        }
    }

    pub(super) fn person_name(&self, person: PersonId) -> &str {
        let known = self.class.persons.get(person.0 as usize);
        known.map_or("", Person::name)
    }
}

fn too_many_codes(of: &Message, met: &TooManyCodes) -> RpcError {
    let wait = met.wait.as_secs_f64().ceil();
    let why = message!("too many wrong {of}: wait {wait} s", of, wait);
    let error = RpcError::new(RpcError::TOO_MANY, why).with("limit", met.limit);
    error.with("wait_s", wait)
}
