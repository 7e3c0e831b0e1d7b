"""Enums of dobotWrapperPy."""
