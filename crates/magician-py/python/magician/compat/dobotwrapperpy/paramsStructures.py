"""Parameter structures of dobotWrapperPy's calls, with their fields in wire order."""

from __future__ import annotations

from dataclasses import make_dataclass
from typing import Any

STRUCTURES: dict[str, str] = {
    "tagWithL": "is_with_rail version",
    "tagWithLReturn": "is_with_rail",
    "tagPose": "x y z r jointAngle",
    "tagHomeParams": "x y z r",
    "tagHomeCmd": "reserved",
    "tagAutoLevelingParams": "isAutoLeveling accuracy",
    "tagEndEffectorParams": "xBias yBias zBias",
    "tagJOGJointParams": "velocity acceleration",
    "tagJOGCoordinateParams": "velocity acceleration",
    "tagJOGCommonParams": "velocityRatio accelerationRatio",
    "tagJOGCmd": "isJoint cmd",
    "tagJOGLParams": "velocity acceleration",
    "tagPTPJointParams": "velocity acceleration",
    "tagPTPCoordinateParams": "xyzVelocity rVelocity xyzAcceleration rAcceleration",
    "tagPTPJumpParams": "jumpHeight zLimit",
    "tagPTPCommonParams": "velocityRatio accelerationRatio",
    "tagPTPCmd": "ptpMode x y z r",
    "tagPTPLParams": "velocity acceleration",
    "tagPTPWithLCmd": "ptpMode x y z r l",
    "tagPTPJump2Params": "startJumpHeight endJumpHeight zLimit",
    "tagPOCmd": "ratio address level",
    "tagCPParams": "planAcc junctionAcc acceleratio_or_period realTimeTrack",
    "tagCPCmd": "cpMode x y z velocity_or_power",
    "tagARCParams": "xyzVelocity rVelocity xyzAcceleration rAcceleration",
    "tagARCCmd": "circPoint toPoint",
    "tagWAITCmd": "timeout",
    "tagTRIGCmd": "address mode condition threshold",
    "tagIOMultiplexing": "address multiplex",
    "tagIODO": "address level",
    "tagIOPWM": "address frequency dutyCycle",
    "tagIODI": "address level",
    "IOADC": "address value",
    "tagEMOTOR": "address insEnabled speed",
    "tagEMOTORDistance": "address insEnabled speed distance",
    "tagDevice": "isEnabled port version",
    "tagColor": "red green blue",
    "tagWIFIIPAddress": "dhcp addr",
    "tagWIFINetmask": "addr",
    "tagWIFIGateway": "addr",
    "tagWIFIDNS": "addr",
}

__all__ = [*STRUCTURES]  # pyright: ignore[reportUnsupportedDunderAll]


def _made(name: str, fields: str) -> type[Any]:
    return make_dataclass(name, [(field, Any) for field in fields.split()])


globals().update({name: _made(name, fields) for name, fields in STRUCTURES.items()})
globals()["tagARCCmd"].Point = _made("Point", "x y z r")


def __getattr__(name: str) -> Any:
    raise AttributeError(f"dobotWrapperPy has no structure {name}")
