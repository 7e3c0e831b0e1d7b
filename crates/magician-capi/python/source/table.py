"""What the three DobotDllType.py consist of: enumerations, structures, functions.

The names, the order of the parameters, their defaults and the shape of what comes back are those of the files that
programs were written for (names and shapes are facts; the words and the code here are our own). `generate.py` turns
the table into the three modules.

A function is a row: its name, its Python parameters after `api` and the ids, the C arguments after the ids, and what it
returns. A C argument is one of

    in TYPE EXPRESSION      a structure that is sent
    out TYPE NAME [START]   a structure or number that comes back, or is filled in before (START)
    u8|u32|i32|f32 EXPR     a number
    text EXPRESSION         a string that is sent
    chars NAME SIZE         a string that comes back, in a buffer of SIZE bytes, and that size
    q, index, queue         isQueued; the index; both

The row of a queued command returns `[queuedCmdIndex.value]` unless it says otherwise.
"""

FAMILIES = ("v1", "v2", "v3")
IDS = {"v1": (), "v2": ("dobotId",), "v3": ("masterId", "slaveId")}
EVERY = "v1 v2 v3"

# --- Enumerations: name, families, members ---------------------------------------------------------------------------

ENUMS = [
    ("EndType", EVERY, "EndTypeCustom=0 EndTypeSuctionCup=1 EndTypeGripper=2 EndTypeLaser=3 EndTypePen=4 EndTypeMax=5"),
    ("DevType", "v3", "Idle=0 Conntroller=1 Magician=2 MagicianLite=3"),
    ("ParamsMode", "v3", "JOG=0 other=1"),
    ("ArmOrientation", EVERY, "LeftyArmOrientation=0 RightyArmOrientation=1"),
    (
        "JC",
        EVERY,
        "JogIdle=0 JogAPPressed=1 JogANPressed=2 JogBPPressed=3 JogBNPressed=4 JogCPPressed=5 JogCNPressed=6"
        " JogDPPressed=7 JogDNPressed=8 JogEPPressed=9 JogENPressed=10",
    ),
    (
        "PTPMode",
        EVERY,
        "PTPJUMPXYZMode=0 PTPMOVJXYZMode=1 PTPMOVLXYZMode=2 PTPJUMPANGLEMode=3 PTPMOVJANGLEMode=4"
        " PTPMOVLANGLEMode=5 PTPMOVJANGLEINCMode=6 PTPMOVLXYZINCMode=7 PTPMOVJXYZINCMode=8 PTPJUMPMOVLXYZMode=9",
    ),
    ("InputPin", EVERY, "InputPinNone=0 " + " ".join(f"InputPin{n}={n}" for n in range(1, 9))),
    ("InputLevel", EVERY, "InputLevelBoth=0 InputLevelLow=1 InputLevelHigh=2"),
    ("OutputPin", EVERY, " ".join(f"SIGNALS_O{n}={n}" for n in range(1, 9))),
    ("ContinuousPathMode", EVERY, "CPRelativeMode=0 CPAbsoluteMode=1"),
    ("TRIGMode", EVERY, "TRIGInputIOMode=0 TRIGADCMode=1"),
    ("TRIGInputIOCondition", EVERY, "TRIGInputIOEqual=0 TRIGInputIONotEqual=1"),
    ("TRIGADCCondition", EVERY, "TRIGADCLT=0 TRIGADCLE=1 TRIGADCGE=2 TRIGADCGT=3"),
    ("GPIOType", "v1 v2", "GPIOTypeDummy=0 GPIOTypeDO=1 GPIOTypePWM=2 GPIOTypeDI=3 GPIOTypeADC=4"),
    (
        "GPIOType",
        "v3",
        "GPIOTypeDummy=0 GPIOTypeDO=1 GPIOTypePWM=2 GPIOTypeDI=3 GPIOTypeADC=4 GPIOTypeDIPU=5 GPIOTypeDIPD=6",
    ),
    ("ZDFCalibStatus", EVERY, "ZDFCalibNotFinished=0 ZDFCalibFinished=1"),
    ("ColorPort", EVERY, "PORT_GP1=0 PORT_GP2=1 PORT_GP4=2 PORT_GP5=3"),
    ("InfraredPort", EVERY, "PORT_GP1=0 PORT_GP2=1 PORT_GP4=2 PORT_GP5=3"),
    (
        "UART4PeripheralsType",
        "v1 v3",
        "UART4PeripheralsUART=0 UART4PeripheralsWIFI=1 UART4PeripheralsBLE=2 UART4PeripheralsCH375=3",
    ),
    ("DobotConnect", EVERY, "DobotConnect_NoError=0 DobotConnect_NotFound=1 DobotConnect_Occupied=2"),
    (
        "DobotCommunicate",
        EVERY,
        "DobotCommunicate_NoError=0 DobotCommunicate_BufferFull=1 DobotCommunicate_Timeout=2"
        " DobotCommunicate_InvalidParams=3 DobotCommunicate_InvalidDevice=4",
    ),
]

# --- Structures: name, families, fields (type: names) ----------------------------------------------------------------

JOINT_VELOCITIES = [f"joint{n}Velocity" for n in range(1, 5)]
JOINT_ACCELERATIONS = [f"joint{n}Acceleration" for n in range(1, 5)]
JOINT_ORDER = " ".join(JOINT_VELOCITIES + JOINT_ACCELERATIONS)
JOINTS = "f32: " + JOINT_ORDER
AXES = [axis + what for what in ("Velocity", "Acceleration") for axis in "xyzr"]
RATIOS = "f32: velocityRatio accelerationRatio"
XYZ_R = "f32: xyzVelocity rVelocity xyzAcceleration rAcceleration"
ADDRESS = "u8: addr1 addr2 addr3 addr4"

STRUCTURES = [
    ("DevInfo", "v3", "i32: devId type; char*50: firmwareName firwareVersion; f32: runTime"),
    ("ConnectInfo", "v3", "DevInfo: masterDevInfo slaveDevInfo1 slaveDevInfo2"),
    ("UpgradeFWReadyCmd", "v3", "u32: fwSize; text: md5"),
    ("DeviceID", "v3", "u32: deviceID1 deviceID2 deviceID3"),
    (
        "DeviceVersion",
        "v3",
        "u8: fw_majorVersion fw_minorVersion fw_revision fw_alphaVersion"
        " hw_majorVersion hw_minorVersion hw_revision hw_alphaVersion",
    ),
    ("DeviceCountInfo", "v1 v3", "u64: deviceRunTime; u32: devicePowerOn devicePowerOff"),
    ("EndTypeParams", EVERY, "f32: xBias yBias zBias"),
    ("Pose", EVERY, "f32: x y z rHead joint1Angle joint2Angle joint3Angle joint4Angle"),
    ("Kinematics", EVERY, "f32: velocity acceleration"),
    ("AlarmsState", EVERY, "i32: alarmsState"),
    ("HOMEParams", EVERY, "f32: x y z r"),
    ("HOMECmd", EVERY, "f32: temp"),
    ("AutoLevelingCmd", EVERY, "u8: controlFlag; f32: precision"),
    ("EMotor", EVERY, "u8: index isEnabled; i32: speed"),
    ("EMotorS", "v1", "u8: index isEnabled; i32: speed; u32: deltaPulse"),
    ("EMotorS", "v2 v3", "u8: index isEnabled; i32: speed; u32: distance"),
    ("JOGJointParams", EVERY, JOINTS),
    ("JOGCoordinateParams", EVERY, "f32: " + " ".join(AXES)),
    ("JOGCommonParams", EVERY, RATIOS),
    ("JOGLParams", EVERY, "f32: velocity acceleration"),
    ("JOGCmd", EVERY, "u8: isJoint cmd"),
    ("PTPJointParams", EVERY, JOINTS),
    ("PTPCoordinateParams", EVERY, XYZ_R),
    ("PTPLParams", EVERY, "f32: velocity acceleration"),
    ("PTPJumpParams", EVERY, "f32: jumpHeight zLimit"),
    ("PTPJump2Params", EVERY, "f32: startJumpHeight endJumpHeight zLimit"),
    ("PTPCommonParams", EVERY, RATIOS),
    ("PTPCmd", EVERY, "u8: ptpMode; f32: x y z rHead"),
    ("PTPWithLCmd", EVERY, "u8: ptpMode; f32: x y z rHead l"),
    ("ParallelOutputCmd", EVERY, "u8: ratio; u16: address; u8: level"),
    ("CPParams", EVERY, "f32: planAcc juncitionVel acc; u8: realTimeTrack"),
    ("CPCmd", EVERY, "u8: cpMode; f32: x y z velocity"),
    ("CP2Cmd", "v3", "u8: cpMode; f32: x y z velocity"),
    ("CPCommonParams", "v1 v3", RATIOS),
    ("ARCPoint", EVERY, "f32: x y z rHead"),
    ("ARCParams", EVERY, XYZ_R),
    ("ARCCmd", EVERY, "ARCPoint: cirPoint toPoint"),
    ("CircleCmd", EVERY, "ARCPoint: cirPoint toPoint; u32: count"),
    ("ARCCommonParams", "v1 v3", RATIOS),
    ("WAITParams", EVERY, "u8: unitType"),
    ("WAITCmd", EVERY, "u32: waitTime"),
    ("TRIGCmd", EVERY, "u8: address mode condition; u16: threshold"),
    ("IOMultiplexing", EVERY, "u8: address multiplex"),
    ("IODO", EVERY, "u8: address level"),
    ("IOPWM", EVERY, "u8: address; f32: frequency dutyCycle"),
    ("IODI", EVERY, "u8: address level"),
    ("IOADC", EVERY, "u8: address; u16: value"),
    ("UserParams", EVERY, "f32: " + " ".join(f"params{n}" for n in range(1, 9))),
    ("WIFIIPAddress", EVERY, "u8: dhcp addr1 addr2 addr3 addr4"),
    ("WIFINetmask", EVERY, ADDRESS),
    ("WIFIGateway", EVERY, ADDRESS),
    ("WIFIDNS", EVERY, ADDRESS),
    ("FirmwareParams", EVERY, "u8: mode"),
    ("FirmwareMode", EVERY, "u8: mode ctl"),
    ("PID", "v1 v2", "u8: index controlLoop; f32: p i d v a"),
    ("PluseCmd", "v1 v3", "f32: j1 j2 j3 j4 e1 e2"),
]

# --- Functions -------------------------------------------------------------------------------------------------------


class Row:
    """A function; `ids` are the ids in the C call where they are not the family's own."""

    def __init__(self, name, parameters="", c="", result=None, families=EVERY, doc="", c_name=None, ids=None, after=""):
        self.name, self.parameters, self.families, self.doc = name, parameters, families.split(), doc
        self.c_name, self.ids, self.after = c_name or name, ids, after
        self.arguments = [part.strip() for part in c.split(";") if part.strip()]
        self.result = result


class One:
    """One value: bare in v1, in a list elsewhere."""

    def __init__(self, expression):
        self.expression = expression


def fields(variable, names):
    """A list of the fields of a structure."""
    return "[" + ", ".join(f"{variable}.{name}" for name in names.split()) + "]"


def params(what, structure, names, parameters=None, families=EVERY, result=None, order=None):
    """The Set and the Get of parameters: the parameters in Python's order, the fields in that of the structure."""
    parameters = parameters or ", ".join(names.split())
    given = dict(zip(names.split(), parameters.split(", ")))
    sent = ", ".join(given[name] for name in (order or names).split())
    return [
        Row(f"Set{what}", f"{parameters}, isQueued=0", f"in {structure} {structure}({sent}); queue", families=families),
        Row(f"Get{what}", "", f"out {structure} found", result or fields("found", names), families),
    ]


PAIRS = " ".join(f"joint{n}Velocity joint{n}Acceleration" for n in range(1, 5))
PAIRED = ", ".join(f"j{n}Velocity, j{n}Acceleration" for n in range(1, 5))
AXIS_PAIRS = " ".join(f"{axis}Velocity {axis}Acceleration" for axis in "xyzr")
RATIO_NAMES = "velocityRatio accelerationRatio"
WIFI_ADDRESS = "addr1, addr2, addr3, addr4"
BOX = ("masterId", "-1")
IO_SET = [
    ("SetIOMultiplexing", "address, multiplex", "IOMultiplexing(address, multiplex)"),
    ("SetIODO", "address, level", "IODO(address, level)"),
    ("SetIOPWM", "address, frequency, dutyCycle", "IOPWM(address, frequency, dutyCycle)"),
]
IO_GET = [
    ("GetIOMultiplexing", "IOMultiplexing", "[found.multiplex]"),
    ("GetIODO", "IODO", "[found.level]"),
    ("GetIOPWM", "IOPWM", "[found.frequency, found.dutyCycle]"),
    ("GetIODI", "IODI", "[found.level]"),
    ("GetIOADC", "IOADC", "[found.value]"),
]


def io(suffix="", ids=None, families=EVERY):
    """The rows of the I/O; with a suffix, those of the control box."""
    rows = []
    for name, parameters, made in IO_SET:
        structure = made.split("(")[0]
        sent = f"in {structure} {made}; queue"
        rows.append(Row(name + suffix, f"{parameters}, isQueued=0", sent, c_name=name, ids=ids, families=families))
    for name, structure, result in IO_GET:
        made = f"out {structure} found {structure}(addr)"
        rows.append(Row(name + suffix, "addr", made, result, c_name=name, ids=ids, families=families))
    return rows


def motors(suffix="", ids=None, families="v2 v3", last="distance"):
    """The rows of the stepper outputs."""
    return [
        Row("SetEMotor" + suffix, "index, isEnabled, speed, isQueued=0",
            "in EMotor EMotor(index, isEnabled, speed); queue", c_name="SetEMotor", ids=ids, families=families),
        Row("SetEMotorS" + suffix, f"index, isEnabled, speed, {last}, isQueued=0",
            f"in EMotorS EMotorS(index, isEnabled, speed, {last}); queue", c_name="SetEMotorS", ids=ids,
            families=families),
    ]


def wifi(what, structure, parameters):
    """The rows of a Wi-Fi address."""
    return [
        Row(f"SetWIFI{what}", parameters, f"in {structure} {structure}({parameters})"),
        Row(f"GetWIFI{what}", "", f"out {structure} found", fields("found", parameters.replace(",", ""))),
    ]


def sensor(what, port):
    """The rows of the colour and the infrared sensor, whose Set differs in every family."""
    set_name = f"Set{what}Sensor"
    both = f"u8 _byte(isEnable); i32 {port}"
    v3 = f"u8 _byte(isEnable); u8 _byte({port}); u8 _byte(version)"
    bare = f"isEnable, {port}=ColorPort.PORT_GP2" if what == "Color" else f"isEnable, {port}"
    return [
        Row(set_name, bare, both, families="v1"),
        Row(set_name, f"isEnable, {port}", both, families="v2"),
        Row(set_name, f"isEnable, {port}, version=0", f"{v3}; u8 1; index", "None", families="v3"),
        Row(f"{set_name}Ext", f"isEnable, {port}, version=0, isQueued=0", f"{v3}; queue", families="v3",
            c_name=set_name, ids=BOX),
    ]


FUNCTIONS = [
    ("Queue", [
        Row("GetQueuedCmdCurrentIndex", "", "out u64 found", "[found.value]", "v1 v2",
            after="_waited(api, ARM, found.value)"),
        Row("GetQueuedCmdCurrentIndex", "", "out u64 found", "[found.value, 0]", "v3",
            after="_waited(api, ARM, found.value)",
            doc="The second number is the index of a control box, which this arm lacks."),
        Row("GetQueuedCmdMotionFinish", "", "out u8 found", "[bool(found.value)]", "v1 v3"),
        Row("SetQueuedCmdStartExec"),
        Row("SetQueuedCmdStopExec"),
        Row("SetQueuedCmdForceStopExec"),
        Row("SetQueuedCmdStartDownload", "totalLoop, linePerLoop", "u32 totalLoop; u32 linePerLoop"),
        Row("SetQueuedCmdStopDownload"),
        Row("SetQueuedCmdClear", "", "", One("DobotCommunicate.DobotCommunicate_NoError")),
    ]),
    ("Device", [
        Row("SetDeviceSN", "str", "text str"),
        Row("GetDeviceSN", "", "chars found 64", One("_string(found)")),
        Row("SetDeviceName", "str", "text str"),
        Row("SetDeviceNumName", "num", "text _decimal(num)", families="v2 v3", c_name="SetDeviceName"),
        Row("GetDeviceName", "", "chars found 100", One("_string(found)")),
        Row("GetDeviceVersion", "", "out u8 major; out u8 minor; out u8 revision",
            "[major.value, minor.value, revision.value]", "v1 v2"),
        Row("GetDeviceVersion", "", "out DeviceVersion found",
            fields("found", "fw_majorVersion fw_minorVersion fw_revision fw_alphaVersion"), "v3"),
        Row("GetDeviceVersionEx", "", "out DeviceVersion found",
            "[" + fields("found", "fw_majorVersion fw_minorVersion fw_revision fw_alphaVersion") + ", "
            + fields("found", "hw_majorVersion hw_minorVersion hw_revision hw_alphaVersion") + "]",
            "v3", c_name="GetDeviceVersion", doc="Firmware and hardware."),
        Row("SetDeviceWithL", "isWithL, isQueued=0", "u8 _byte(isWithL); queue", families="v1"),
        Row("SetDeviceWithL", "isWithL", "u8 _byte(isWithL)", families="v2"),
        Row("SetDeviceWithL", "isWithL, version=0, isQueued=0", "u8 _byte(isWithL); u8 _byte(version); queue",
            families="v3"),
        Row("GetDeviceWithL", "", "out u8 found", One("bool(found.value)")),
        Row("GetDeviceTime", "", "out u32 found", "[found.value]"),
        Row("GetDeviceInfo", "", "out DeviceCountInfo found",
            fields("found", "deviceRunTime devicePowerOn devicePowerOff"), "v1 v3"),
        Row("GetDeviceID", "", "out DeviceID found", "[0, found.deviceID1, found.deviceID2, found.deviceID3]", "v3"),
        Row("GetMarlinVersion", families="v1 v3"),
        Row("GetUserParams", "", "out UserParams found", fields("found", " ".join(f"params{n}" for n in range(1, 9)))),
    ]),
    ("Pose and alarms", [
        Row("GetPose", "", "out Pose pose",
            fields("pose", "x y z rHead joint1Angle joint2Angle joint3Angle joint4Angle")),
        Row("GetPoseL", "", "out f32 found", "[found.value]"),
        Row("ResetPose", "manual, rearArmAngle, frontArmAngle",
            "u8 _byte(manual); f32 rearArmAngle; f32 frontArmAngle"),
        Row("GetKinematics", "", "out Kinematics found", "[found.velocity, found.acceleration]"),
        Row("GetAlarmsState", "maxLen=1000", "alarms", "[alarmsState.raw, length.value]"),
        Row("ClearAllAlarmsState"),
    ]),
    ("Homing and levelling", [
        *params("HOMEParams", "HOMEParams", "x y z r"),
        Row("SetHOMECmd", "temp, isQueued=0", "in HOMECmd HOMECmd(temp); queue", families="v1 v2",
            after="_expect(api, ARM, queuedCmdIndex.value, HOMING)"),
        Row("SetHOMECmd", "temp, isQueued=0", "in HOMECmd HOMECmd(temp); queue", "[queuedCmdIndex.value, 0]", "v3",
            after="_expect(api, ARM, queuedCmdIndex.value, HOMING)",
            doc="The second number is the index in the queue of a control box, which this arm lacks."),
        Row("SetAutoLevelingCmd", "controlFlag, precision, isQueued=0",
            "in AutoLevelingCmd AutoLevelingCmd(controlFlag, precision); queue",
            after="_expect(api, ARM, queuedCmdIndex.value, HOMING)"),
        Row("GetAutoLevelingResult", "", "out f32 found", "[found.value]"),
        Row("SetArmOrientation", "armOrientation, isQueued=0", "i32 armOrientation; queue"),
        Row("GetArmOrientation", "", "out i32 found", "[found.value]"),
    ]),
    ("Hand-hold teaching", [
        Row("SetHHTTrigMode", "hhtTrigMode", "i32 hhtTrigMode"),
        Row("GetHHTTrigMode", "", "out i32 found", "[found.value]"),
        Row("SetHHTTrigOutputEnabled", "isEnabled", "u8 _byte(isEnabled)"),
        Row("GetHHTTrigOutputEnabled", "", "out u8 found", "[found.value]"),
        Row("GetHHTTrigOutput", "", "out u8 found", One("bool(found.value)")),
    ]),
    ("End effector", [
        *params("EndEffectorParams", "EndTypeParams", "xBias yBias zBias"),
        Row("SetEndEffectorLaser", "enableCtrl, on, isQueued=0", "u8 _byte(enableCtrl); u8 _byte(on); queue"),
        Row("GetEndEffectorLaser", "", "out u8 isCtrlEnabled; out u8 isOn", "[isCtrlEnabled.value, isOn.value]"),
        Row("SetEndEffectorSuctionCup", "enableCtrl, on, isQueued=0", "u8 _byte(enableCtrl); u8 _byte(on); queue"),
        Row("GetEndEffectorSuctionCup", "", "out u8 isCtrlEnabled; out u8 isOn", "[isOn.value]"),
        Row("SetEndEffectorGripper", "enableCtrl, on, isQueued=0", "u8 _byte(enableCtrl); u8 _byte(on); queue"),
        Row("GetEndEffectorGripper", "", "out u8 isCtrlEnabled; out u8 isOn", "[isOn.value]"),
        Row("SetEndEffectorType", "endType=0, isQueued=0", "q; u8 _byte(endType); index", families="v3"),
        Row("GetEndEffectorType", "", "out u8 found", "[found.value]", "v3"),
    ]),
    ("Jog", [
        *params("JOGJointParams", "JOGJointParams", PAIRS, PAIRED, order=JOINT_ORDER),
        *params("JOGCoordinateParams", "JOGCoordinateParams", AXIS_PAIRS, order=" ".join(AXES)),
        *params("JOGLParams", "JOGLParams", "velocity acceleration"),
        *params("JOGCommonParams", "JOGCommonParams", RATIO_NAMES, "value_velocityratio, value_accelerationratio"),
        Row("SetJOGCmd", "isJoint, cmd, isQueued=0", "in JOGCmd JOGCmd(isJoint, cmd); queue"),
    ]),
    ("Point to point", [
        *params("PTPJointParams", "PTPJointParams", PAIRS, PAIRED, order=JOINT_ORDER),
        *params("PTPCoordinateParams", "PTPCoordinateParams", "xyzVelocity xyzAcceleration rVelocity rAcceleration",
                result=fields("found", "xyzVelocity rVelocity xyzAcceleration rAcceleration"),
                order="xyzVelocity rVelocity xyzAcceleration rAcceleration"),
        *params("PTPLParams", "PTPLParams", "velocity acceleration"),
        *params("PTPJumpParams", "PTPJumpParams", "jumpHeight zLimit"),
        *params("PTPJump2Params", "PTPJump2Params", "startJumpHeight endJumpHeight zLimit"),
        *params("PTPCommonParams", "PTPCommonParams", RATIO_NAMES),
        Row("SetPTPCmd", "ptpMode, x, y, z, rHead, isQueued=0", "in PTPCmd PTPCmd(ptpMode, x, y, z, rHead); queue"),
        Row("SetPTPWithLCmd", "ptpMode, x, y, z, rHead, l, isQueued=0",
            "in PTPWithLCmd PTPWithLCmd(ptpMode, x, y, z, rHead, l); queue"),
        Row("SetPTPPOCmd", "ptpMode, x, y, z, rHead, parallelCmd, isQueued=0",
            "in PTPCmd PTPCmd(ptpMode, x, y, z, rHead); outputs; queue", 
            doc="parallelCmd: (ratio, address, level) of every output on the way."),
        Row("SetPTPPOWithLCmd", "ptpMode, x, y, z, rHead, l, parallelCmd, isQueued=0",
            "in PTPWithLCmd PTPWithLCmd(ptpMode, x, y, z, rHead, l); outputs; queue", 
            doc="parallelCmd: (ratio, address, level) of every output on the way."),
        Row("GetPTPTime", "ptpMode, x, y, z, rHead",
            "in PTPCmd PTPCmd(ptpMode, x, y, z, rHead); out u32 found", "[found.value]"),
    ]),
    ("Continuous path", [
        Row("SetCPParams", "planAcc, juncitionVel, acc, realTimeTrack=0, isQueued=0",
            "in CPParams CPParams(planAcc, juncitionVel, acc, realTimeTrack); queue"),
        Row("GetCPParams", "", "out CPParams found", "[found.planAcc, found.juncitionVel, found.acc]", "v1 v2"),
        Row("GetCPParams", "", "out CPParams found",
            "[found.planAcc, found.juncitionVel, found.acc, found.realTimeTrack]", "v3"),
        Row("SetCPCmd", "cpMode, x, y, z, velocity, isQueued=0", "in CPCmd CPCmd(cpMode, x, y, z, velocity); queue"),
        Row("SetCP2Cmd", "cpMode, x, y, z, isQueued=0", "in CP2Cmd CP2Cmd(cpMode, x, y, z, 100); queue", families="v3"),
        Row("SetCPLECmd", "cpMode, x, y, z, power, isQueued=0", "in CPCmd CPCmd(cpMode, x, y, z, power); queue"),
        Row("SetCPRHoldEnable", "isEnable", "u8 _byte(isEnable)", families="v1 v3"),
        Row("GetCPRHoldEnable", "", "out u8 found", "[bool(found.value)]", "v1 v3"),
        *params("CPCommonParams", "CPCommonParams", RATIO_NAMES, families="v1 v3"),
    ]),
    ("Arc and circle", [
        *params("ARCParams", "ARCParams", "xyzVelocity rVelocity xyzAcceleration rAcceleration"),
        Row("SetARCCmd", "cirPoint, toPoint, isQueued=0",
            "in ARCCmd ARCCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint)); queue"),
        Row("SetCircleCmd", "cirPoint, toPoint, isQueued=0, count=1",
            "in CircleCmd CircleCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint), count); queue", families="v1"),
        Row("SetCircleCmd", "cirPoint, toPoint, isQueued=0",
            "in CircleCmd CircleCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint), 1); queue", families="v2 v3"),
        *params("ARCCommonParams", "ARCCommonParams", RATIO_NAMES, families="v1 v3"),
    ]),
    ("Wait and trigger", [
        Row("SetWAITCmd", "waitTime, isQueued=0", "in WAITCmd WAITCmd(int(waitTime * 1000)); queue", families="v1",
            after="_expect(api, ARM, queuedCmdIndex.value, waitTime)", doc="waitTime: seconds."),
        Row("SetWAITCmd", "waitTime, isQueued=0", "in WAITCmd WAITCmd(int(waitTime)); queue", families="v2 v3",
            after="_expect(api, ARM, queuedCmdIndex.value, waitTime / 1000)", doc="waitTime: milliseconds."),
        Row("SetTRIGCmd", "address, mode, condition, threshold, isQueued=0",
            "in TRIGCmd TRIGCmd(address, mode, condition, threshold); queue",
            after="_expect(api, ARM, queuedCmdIndex.value, FOR_EVER)"),
    ]),
    ("Extended I/O", [*io(), *motors(families="v1", last="deltaPulse"), *motors()]),
    ("Sensors", [
        *sensor("Color", "colorPort"),
        Row("GetColorSensor", "", "out u8 r; out u8 g; out u8 b", "[r.value, g.value, b.value]"),
        *sensor("Infrared", "infraredPort"),
        Row("GetInfraredSensor", "infraredPort", "i32 infraredPort; out u8 found", "[found.value]"),
    ]),
    ("Calibration", [
        Row("SetAngleSensorStaticError", "rearArmAngleError, frontArmAngleError",
            "f32 rearArmAngleError; f32 frontArmAngleError"),
        Row("GetAngleSensorStaticError", "", "out f32 rear; out f32 front", "[rear.value, front.value]"),
        Row("SetAngleSensorCoef", "rearArmAngleCoef, frontArmAngleCoef", "f32 rearArmAngleCoef; f32 frontArmAngleCoef"),
        Row("GetAngleSensorCoef", "", "out f32 rear; out f32 front", "[rear.value, front.value]"),
        Row("SetBaseDecoderStaticError", "baseDecoderError", "f32 baseDecoderError"),
        Row("GetBaseDecoderStaticError", "", "out f32 found", "[found.value]"),
        Row("SetLRHandCalibrateValue", "lrHandCalibrateValue", "f32 lrHandCalibrateValue"),
        Row("GetLRHandCalibrateValue", "", "out f32 found", "[found.value]"),
    ]),
    ("Wi-Fi", [
        Row("GetWIFIConnectStatus", "", "out u8 found", One("bool(found.value)")),
        Row("SetWIFIConfigMode", "enable", "u8 _byte(enable)"),
        Row("GetWIFIConfigMode", "", "out u8 found", One("bool(found.value)")),
        Row("SetWIFISSID", "ssid", "text ssid"),
        Row("GetWIFISSID", "", "chars found 100", One("_string(found)")),
        Row("SetWIFIPassword", "password", "text password"),
        Row("GetWIFIPassword", "", "chars found 100", One("_string(found)")),
        *wifi("IPAddress", "WIFIIPAddress", f"dhcp, {WIFI_ADDRESS}"),
        *wifi("Netmask", "WIFINetmask", WIFI_ADDRESS),
        *wifi("Gateway", "WIFIGateway", WIFI_ADDRESS),
        *wifi("DNS", "WIFIDNS", WIFI_ADDRESS),
    ]),
    ("Firmware", [
        Row("UpdateFirmware", "mode", "in FirmwareParams FirmwareParams(mode)"),
        Row("SetFirmwareMode", "mode, ctl=0", "in FirmwareMode FirmwareMode(mode, ctl)"),
        Row("GetFirmwareMode", "", "out FirmwareMode found", "[found.mode, found.ctl]"),
    ]),
    ("Lost steps", [
        Row("SetLostStepParams", "threshold, isQueued=0", "f32 threshold; queue", families="v1 v3"),
        Row("SetLostStepParams", "threshold", "f32 threshold", families="v2"),
        Row("SetLostStepCmd", "isQueued=0", "queue", after="_expect(api, ARM, queuedCmdIndex.value, HOMING)"),
        Row("SetLostStepEnableAndParamsCmd", "enable, threshlod, isQueued=0",
            "u8 _byte(enable); f32 threshlod; queue", families="v3"),
        Row("GetLostStepEnableAndParamsCmd", "", "out u8 enable; out f32 threshold", "[enable.value, threshold.value]",
            "v3"),
    ]),
    ("What this arm has not", [
        Row("GetUART4PeripheralsType", "", "out u8 found", "[found.value]", "v1 v3"),
        Row("SetUART4PeripheralsEnable", "isEnable", "u8 _byte(isEnable)", families="v1 v3"),
        Row("GetUART4PeripheralsEnable", "", "out u8 found", "[bool(found.value)]", "v1 v3"),
        Row("SendPluse", "pluseCmd, isQueued=0", "in PluseCmd _filled(PluseCmd, pluseCmd); queue", families="v1 v3"),
        Row("SendPluseEx", "pluseCmd", "in PluseCmd _filled(PluseCmd, pluseCmd)", families="v1 v3"),
        Row("GetServoPIDParams", "index, controlLoop", "out PID found PID(index, controlLoop)",
            fields("found", "p i d v a"), "v1 v2"),
        Row("SetServoPIDParams", "pid, isQueued=0", "in PID _filled(PID, pid); queue", families="v1 v2"),
        Row("GetServoControlLoop", "index", "u8 _byte(index); out u8 found", "[found.value]", "v1 v2"),
        Row("SetServoControlLoop", "p_index, controlLoop, isQueued=0",
            "u8 _byte(p_index); u8 _byte(controlLoop); queue", families="v1 v2"),
        Row("SaveServoPIDParams", "p_index, controlLoop, isQueued=0",
            "u8 _byte(p_index); u8 _byte(controlLoop); queue", families="v1 v2"),
        Row("GetDobotDHParams", families="v3"),
        Row("SetMotorMode", "mode", "i32 mode", families="v3"),
        Row("GetMotorMode", "", "out i32 found", "[found.value]", "v3"),
        Row("SetServoAngle", "servoId, angle, isQueued=0", "q; u8 _byte(servoId); f32 angle; index", families="v3",
            ids=BOX),
        Row("GetServoAngle", "servoId", "u8 _byte(servoId); out f32 found", "[found.value]", "v3", ids=BOX),
        Row("SetArmSpeedRatio", "paramsMode, speedRatio, isQueued=0",
            "q; u8 _byte(paramsMode); u8 _byte(speedRatio); index", families="v3"),
        Row("GetArmSpeedRatio", "paramsMode=0", "u8 _byte(paramsMode); out u8 found", "[found.value]", "v3"),
        Row("SetLSpeedRatio", "paramsMode, speedRatio, isQueued=0",
            "q; u8 _byte(paramsMode); u8 _byte(speedRatio); index", families="v3", ids=BOX),
        Row("GetLSpeedRatio", "paramsMode", "u8 _byte(paramsMode); out u8 found", "[found.value]", "v3", ids=BOX),
        Row("RestartMagicBox", families="v3", ids=BOX),
        Row("PrintInfo", "info", "text info", families="v3", ids=BOX),
        Row("SetProgbar", "progbar", "u8 _byte(progbar)", families="v3", ids=BOX),
        Row("SetUpgradeFWReadyCmd", "fwSize, md5", "in UpgradeFWReadyCmd UpgradeFWReadyCmd(fwSize, bytes.fromhex(md5))",
            families="v3"),
        Row("GetUpgradeFWReadyCmd", "fwSize, md5",
            "in UpgradeFWReadyCmd UpgradeFWReadyCmd(fwSize, bytes.fromhex(md5)); out u8 found", "[found.value]", "v3"),
        *io("Ext", BOX, "v3"),
        *motors("Ext", BOX, "v3"),
        Row("GetInfraredSensorExt", "infraredPort", "i32 infraredPort; out u8 found", "[found.value]", "v3",
            c_name="GetInfraredSensor", ids=BOX),
        Row("GetColorSensorExt", "index", "out u8 r; out u8 g; out u8 b", "[r.value, g.value, b.value][index]", "v3",
            c_name="GetColorSensor", ids=BOX),
        Row("GetSeeedColorSensorExt", "", "out u16 r; out u16 g; out u16 b; out u16 cct",
            "[r.value, g.value, b.value, cct.value]", "v3", c_name="GetSeeedColorSensor"),
        Row("SetSeeedColorSensorExt", "SeeedPort, isQueued=0", "u8 _byte(SeeedPort); queue", families="v3",
            c_name="SetSeeedColorSensor"),
        Row("GetSeeedDistanceSensorExt", "SeeedPort", "u8 _byte(SeeedPort); out u8 found", "[found.value]", "v3",
            c_name="GetSeeedDistanceSensor"),
        Row("SetSeeedTempSensorExt", "SeeedPort, isQueued=0", "u8 _byte(SeeedPort); queue", families="v3",
            c_name="SetSeeedTempSensor"),
        Row("GetSeeedTempSensorExt", "", "out u16 tem; out u16 hum", "[tem.value, hum.value]", "v3",
            c_name="GetSeeedTempSensor"),
        Row("SetSeeedLightSensorExt", "SeeedPort, isQueued=0", "u8 _byte(SeeedPort); queue", families="v3",
            c_name="SetSeeedLightSensor"),
        Row("GetSeeedLightSensorExt", "", "out u16 lux", "[lux.value]", "v3", c_name="GetSeeedLightSensor"),
        Row("SetSeeedRgbExt", "SeeedPort, Rgb, isQueued=0", "u8 _byte(SeeedPort); f32 Rgb; queue", families="v3",
            c_name="SetSeeedRgb"),
    ]),
]

# Functions with a variant that waits for its command: name, parameters if they differ, families.
FINISHED = [
    ("SetHOMECmd", None, EVERY),
    ("SetEndEffectorParams", None, EVERY),
    ("SetPTPJointParams", None, EVERY),
    ("SetPTPCoordinateParams", None, "v3"),
    ("SetPTPLParams", "lVelocity, lAcceleration, isQueued=0", EVERY),
    ("SetPTPCommonParams", None, EVERY),
    ("SetPTPJumpParams", "jumpHeight, maxJumpHeight, isQueued=0", EVERY),
    ("SetPTPCmd", None, EVERY),
    ("SetPTPWithLCmd", None, EVERY),
    ("SetIOMultiplexing", None, EVERY),
    ("SetIODO", None, EVERY),
    ("SetIOPWM", None, EVERY),
    ("SetEMotor", None, EVERY),
    ("SetEMotorS", None, EVERY),
    ("SetEndEffectorSuctionCup", None, EVERY),
    ("SetEndEffectorGripper", None, EVERY),
    ("SetAutoLevelingCmd", "controlFlag, precision, isQueued=1", EVERY),
    ("SetLostStepCmd", "isQueued=1", EVERY),
    ("SetTRIGCmd", "address, mode, condition, threshold, isQueued=1", "v3"),
    ("SetARCCmd", "cirPoint, toPoint, isQueued=1", "v3"),
    ("SetWAITCmd", None, "v3"),
    *[(f"{name}Ext", None, "v3") for name in (
        "SetIOMultiplexing", "SetIODO", "SetIOPWM", "SetEMotor", "SetEMotorS", "SetColorSensor", "SetInfraredSensor",
        "SetSeeedColorSensor", "SetSeeedTempSensor", "SetSeeedLightSensor", "SetSeeedRgb")],
    ("SetEndEffectorType", "endType=0, isQueued=1", "v3"),
    ("SetServoAngle", "servoId, angle, isQueued=1", "v3"),
    ("SetArmSpeedRatio", "paramsMode=0, speedRatio=0, isQueued=1", "v3"),
    ("SetLSpeedRatio", "paramsMode, speedRatio, isQueued=1", "v3"),
]
# Functions that in v1 report an error and do nothing unless the arm is on a rail.
ON_RAIL = {"SetPTPLParams", "SetPTPWithLCmd"}
