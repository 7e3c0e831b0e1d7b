mod engrave;
mod outline;
