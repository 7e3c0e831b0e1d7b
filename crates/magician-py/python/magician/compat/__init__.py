"""Programs for other people's libraries, on this package.

* :mod:`magician.compat.pydobot`, :mod:`~magician.compat.pydobotplus` and :mod:`~magician.compat.pydobot2` have the
  interfaces of those libraries.
* ``python -m magician.compat script.py`` runs a script that imports one of them, or ``DobotDllType``, as it is.
"""

from __future__ import annotations
