//! Many stations as one site: who is there, what all arms do, and commands to any of them.
//!
//! Nothing on a site has to live for the others to work: every station keeps its arms, their leases and their jobs.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
