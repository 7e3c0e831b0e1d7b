"""Tools of dobotapi."""
