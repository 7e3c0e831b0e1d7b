//! The vendor's C library `DobotDll` whose functions take no ids. The implementation is
//! `magician-capi`.

magician_capi::export!(v1);
