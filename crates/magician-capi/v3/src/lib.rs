//! The vendor's C library `DobotDll`, functions with master and slave ids; `magician-capi` is what it is made of.

magician_capi::export!(v3);
