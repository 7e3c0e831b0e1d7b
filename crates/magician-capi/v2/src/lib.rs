//! The vendor's C library `DobotDll` whose functions take one id. The implementation is
//! `magician-capi`.

magician_capi::export!(v2);
