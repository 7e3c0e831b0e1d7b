//! The vendor's C library `DobotDll` whose functions take master and slave ids. The implementation
//! is `magician-capi`.

magician_capi::export!(v3);
