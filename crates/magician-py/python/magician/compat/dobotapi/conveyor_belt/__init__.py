"""Belt of dobotapi."""
