//! A hub over stations with virtual arms, in virtual time: three stations whose ids look alike, and
//! clients that see one station.

mod bench;
mod class;
mod hostile;
mod lost;
mod routing;
mod scale;
mod states;
mod stops;
