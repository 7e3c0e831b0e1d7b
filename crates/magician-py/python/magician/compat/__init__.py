"""Programs for other people's libraries, on this package.

* :mod:`magician.compat.pydobot`, :mod:`~magician.compat.pydobotplus` and :mod:`~magician.compat.pydobot2` have the
  interfaces of those libraries.
* So have :mod:`~magician.compat.pydobotpp`, :mod:`~magician.compat.pydobotlab`, :mod:`~magician.compat.dobotapi`,
  :mod:`~magician.compat.dobotwrapperpy` and :mod:`~magician.compat.dobotedu`.
* ``python -m magician.compat script.py`` runs a script that imports one of them or ``DobotDllType``, or that speaks the
  protocol over ``serial.Serial``, as it is.
"""

from __future__ import annotations
