"""Stand-ins for other libraries of the arm, so that programs written for them run on this package.

* :mod:`magician.compat.pydobot`, :mod:`~magician.compat.pydobotplus` and :mod:`~magician.compat.pydobot2` have the
  interfaces of the libraries of the same name.
* So have :mod:`~magician.compat.pydobotpp`, :mod:`~magician.compat.pydobotlab`, :mod:`~magician.compat.dobotapi`,
  :mod:`~magician.compat.dobotwrapperpy` and :mod:`~magician.compat.dobotedu`.
* ``python -m magician.compat script.py`` runs an unchanged script that imports one of them or ``DobotDllType``, or
  that uses the protocol over ``serial.Serial``.
"""

from __future__ import annotations
