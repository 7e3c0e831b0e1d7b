//! What C and C++ programmers get: headers, and the drop-in for the vendor's library as it is installed.

pub(crate) mod headers;
