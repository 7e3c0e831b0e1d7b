"""Checks that are counted: one printed line each, and a verdict at the end."""

import re
import struct
import sys
import traceback

# Timeout of operations that should complete at once, s. A success is noticed immediately, so only
# failures wait this long. Generous, for a machine under load.
TIMEOUT = 60

VERDICT = re.compile(r"(\d+) passed, (\d+) failed\n")


class Checks:
    """Counts passed and failed checks."""

    def __init__(self):
        self.passed = 0
        self.failed = 0

    def ok(self, name, condition, detail=""):
        """Checks a condition."""
        if condition:
            self.passed += 1
        else:
            self.failed += 1
        verdict = "ok  " if condition else "FAIL"
        print(f"  {verdict} {name}{': ' + str(detail) if detail != '' else ''}", flush=True)
        return bool(condition)

    def equal(self, name, got, want):
        """Checks that a value equals the expected one."""
        shown = _short(got)
        return self.ok(name, got == want, shown if got == want else f"{shown}, want {_short(want)}")

    def near(self, name, got, want, tolerance=1e-3):
        """Checks that one or several numbers are within the tolerance."""
        got, want = list(_iterable(got)), list(_iterable(want))
        good = len(got) == len(want) and all(abs(a - b) <= tolerance for a, b in zip(got, want))
        shown = " ".join(f"{v:.4f}" for v in got)
        return self.ok(name, good, shown if good else f"{shown}, want {' '.join(f'{v:.4f}' for v in want)}")

    def section(self, part, *arguments):
        """Runs a group of checks. An exception counts as a failure, and the remaining groups still
        run."""
        try:
            part(self, *arguments)
        except (AssertionError, OSError, RuntimeError, ValueError, struct.error) as error:
            self.ok(f"{part.__name__} came to its end", False, f"{type(error).__name__}: {error}")
            traceback.print_exc()

    def finish(self):
        """Prints the verdict and exits."""
        print(f"{self.passed} passed, {self.failed} failed", flush=True)
        sys.exit(1 if self.failed or not self.passed else 0)


def _iterable(value):
    return value if hasattr(value, "__iter__") else (value,)


def _short(value):
    text = value.hex(" ") if isinstance(value, (bytes, bytearray)) else str(value)
    return text if len(text) <= 160 else text[:157] + "..."
