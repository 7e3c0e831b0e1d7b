//! The vendor's C library `DobotDll`, functions without ids; `magician-capi` is what it is made of.

magician_capi::export!(v1);
