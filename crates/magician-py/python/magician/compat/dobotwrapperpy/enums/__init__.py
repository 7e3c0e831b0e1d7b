"""The enums of dobotWrapperPy."""
