"""dobotapi's tools."""
