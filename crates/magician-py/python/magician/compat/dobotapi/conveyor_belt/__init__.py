"""dobotapi's belt."""
