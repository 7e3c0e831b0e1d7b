//! The vendor's C library `DobotDll`, functions with a dobotId; `magician-capi` is what it is made of.

magician_capi::export!(v2);
