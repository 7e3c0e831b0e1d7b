//! Assumptions of the virtual arm's behaviour, each with its source and confidence.
//!
//! Strict mode refuses (`refused`) a choice that decides what the arm does or replies. It keeps
//! (`kept`, with the reason) a choice that decides only a value (duration, speed, count, initial
//! state) of known behaviour. It also keeps a choice if the refusal would have the same effect, or
//! if the command must not be refused, like a stop.

use super::list_assumptions;

list_assumptions! {
    // Position of the arm.
    CommandedPose Measured "1" "GetPose reports the commanded joint angles and the pose computed from them, not the arm's true position";
    BaseUnknown Measured "11" "before homing J1 reads 0, wherever the base stood at power-up";
    PowerUpPose Choice "15a" "at power-up the arm stands at joints (0, 45, 45, 0) with J1 reading 0"
        kept "the scenario decides where the arm stands at power-up";
    PowerUpTool Measured "6" "at power-up the tool is the one chosen before; the suction cup by default";
    ToolBias Measured "2" "the pose is that of the wrist plus the tool bias, as soon as the bias is set";
    Zeros Choice "15a" "Kinematics, DeviceInfo, UserParams, UART4PeripheralsModel and the status of the ZDF calibration read as zeros" refused;
    ResetPose Vendor "11" "ResetPose sets the controller's angles of J2 and J3, or reads them from the sensors";
    UntimelyResetPose Choice "(none)" "ResetPose has no effect while the arm moves, or with angles beyond a full turn" refused;

    // The arm's identity, and its clock.
    Identity Vendor "15" "name and serial number are stored as set, up to 64 and 23 bytes";
    Version Vendor "15" "the firmware version is three bytes, 3.6.14";
    Clock Vendor "15" "the clock counts milliseconds since power-up and wraps at 32 bits";
    DeviceIdWords Choice "15" "the three words of the device id are drawn from a seed"
        kept "they differ on every arm";
    FlashKeeps Choice "6" "a reset discards all settings except name, serial number, Wi-Fi, sensor calibration and program"
        kept "a reset is not a command";
    ResetAlarm Measured "11" "alarm 0x00 is active from power-up until it is cleared";

    // Settings, and the values that are read back.
    Parameters Vendor "6" "at power-up speeds and heights are those of the vendor's printed samples; they read back as set";
    CappedWhenSet Sibling "6" "speeds and accelerations of jogs and point-to-point moves are clamped to the ceilings when set";
    BeyondCeilings Choice "6" "ratios and speeds of paths beyond the ceilings are stored as sent and clamped when a motion is planned" refused;
    RailDefaults Choice "6" "until set, speed and acceleration of the rail read as 100 mm/s and 100 mm/s2" refused;
    JumpSetsBoth Sibling "7" "setting the jump height also sets both heights of PTPJump2Params";
    StoredWithoutEffect Choice "15a" "AutoLeveling, the corrections of the sensors, ArmOrientation, CPRHeadHoldEnable and CPCommonParams are stored and read back, without effect" refused;
    OutsideTheDocument Choice "15a" "FirmwareSwitch, FirmwareMode, PulseMode, UART4 and ZDF are stored or answered, without effect" refused;
    PtpTime Choice "15a" "PTPTime replies with the duration of the move from the current pose, in ms, or 0 if the move would be refused" refused;
    MotionFinish Measured "15a" "QueuedCmdMotionFinish replies 1 if nothing moves";
    WifiSettings Vendor "15" "the settings of the Wi-Fi module are stored as set";
    WifiDefaults Choice "15" "until set, the settings of the Wi-Fi module read as empty, with DHCP" refused;
    WifiStatus ThirdParty "15" "the Wi-Fi module joins any network with a name, some seconds after power-up or after it leaves its command mode";

    // Frames.
    ForeignBytes ThirdParty "E10" "bytes that do not form a frame are skipped";
    DamagedFrame Measured "E10" "a frame with a wrong checksum or length is not answered";
    UnknownId Choice "E09" "an unknown id is not answered and raises 0x01" refused;
    WrongCount Choice "E11" "a frame with an unknown parameter count is answered and has no effect"
        kept "no effect in either mode";
    QueuedBitAlone Measured "E07" "isQueued alone decides whether a command with a set is queued";
    SteeringQueued Choice "E47" "isQueued is ignored for commands that control the queue: they take effect immediately" refused;
    SetOnlyRead Choice "E12" "a set-only command with rw = 0 is answered without parameters and has no effect"
        kept "no effect in either mode";
    GetOnlyWritten ThirdParty "E12" "a get-only command is answered regardless of rw";
    DestinationBits Choice "E05" "a frame to another destination or slave is handled as one for this arm" refused;

    // Alarms and limits.
    AlarmBits Vendor "E20" "alarm n is bit n % 8 of byte n / 8 of 16";
    ClearAlarms ThirdParty "E19" "id 20 with rw = 1 clears the alarms whose cause is gone";
    ClearBy21 Vendor "E19" "id 21 also clears them";
    AlarmHold Measured "4" "an alarm above 0x07 holds the queue until the alarms are cleared";
    QuietAlarms Vendor "4" "the alarms 0x00 to 0x07 do not hold the queue";
    LatchedHold Choice "4" "a limit alarm that clears by itself keeps holding the queue until the alarms are cleared"
        kept "nothing runs meanwhile";
    LimitDrops Sibling "4" "a limit alarm clears by itself when the joint is back within its limits";
    ImmediateWhileHeld Choice "15a" "an immediate move runs even while an alarm holds the queue" refused;
    JogWhileHeld Vendor "4" "a jog runs even while an alarm holds the queue";
    HomeWhileHeld Measured "4" "homing runs even while an alarm holds the queue";
    TargetChecked Sibling "4" "a Cartesian target is checked before the arm moves: 0x11 if out of reach, 0x12 if beyond a limit";
    PathChecked Sibling "4" "a Cartesian path ends where it leaves the workspace (0x21) or the limits (0x22)";
    JointTargets Sibling "15a" "a joint target is not checked in advance: the arm moves to the limit, stops there and raises only 0x40 to 0x49";
    SoftLimits ThirdParty "4" "the limits are the controller's soft limits: wider than those that the vendor guarantees, and for J2 wider than those certain for every arm";
    RefusedFinishes Sibling "15a" "a queued motion that is refused, or ends before its target, counts as finished";
    NotFinite Choice "15a" "a target with NaN or infinity raises 0x11" refused;
    NoSpeed Choice "6" "a motion whose speed or acceleration is not above 0 raises 0x1A" refused;
    LostSteps Vendor "12" "LostStepCmd compares the sensors of J2 and J3 with the commanded angles and raises 0x51 or 0x52";
    LostBase Choice "12" "LostStepCmd also compares the encoder of J1 and raises 0x50" refused;

    // Homing.
    HomingSequence Measured "11" "homing turns J1 to its switch, backs off, creeps to the switch again, sets J1 and moves to the home point";
    HomingFigures Choice "15a" "the switch stands at -135, the base backs off 0.5 degrees: 14 s from J1 = 0"
        kept "homing is known; this decides only its duration";
    HomePoint Vendor "11" "the home point is the one set, by default joints (0, 45, 45, 0)";
    HomeOutOfReach Choice "15a" "homing to a home point out of reach ends at joints (0, 45, 45, 0), without an alarm" refused;
    HomeUnset Choice "15a" "until set, HOMEParams read as the pose of joints (0, 45, 45, 0) with the current bias" refused;
    HomeUnchecked Sibling "11" "HOMEParams are stored without a check of reach";

    // Teaching by hand, and the keys.
    TeachKey Vendor "12" "the unlock key releases the motors, and the sensors are read";
    TeachSettings Vendor "12" "mode and output of hand teaching are stored as set";
    PointCleared Choice "12" "reading the flag of a new taught point clears it" refused;
    TeachPeriod Choice "12" "in periodic mode a new point is reported every 0.5 s"
        kept "the mode is known; this decides only its period";
    MotionWhileUnlocked Choice "12" "while the unlock key is held the queue waits and immediate motions have no effect"
        kept "no effect in either mode";
    BaseKey Vendor "12" "a short press of the base key runs the stored program";
    BaseKeyHeld Measured "12" "a long press of the base key homes the arm";

    // Programs.
    OfflineProgram Vendor "12" "commands queued between StartDownload and StopDownload are stored, not run";
    OfflineMismatch Choice "12" "a program whose length differs from the announced one is stored as received" refused;
    OfflineBusy Sibling "12" "StartDownload has no effect while the program runs";
    StoredLineIndex Choice "(none)" "a stored command is answered with a queue index under which nothing runs"
        kept "a queued command must be answered with an index";

    // Point to point.
    PtpLaw Measured "7" "each axis follows a trapezoidal velocity profile in periods of 20 ms, the slowest axis sets the duration, and each move ends at rest";
    PlannedAtStart Sibling "7" "a move is planned with the parameters in force when it starts";
    ReplacedMotion Sibling "14" "an immediate motion replaces the running one; a replaced queued motion counts as finished";
    QueueMeanwhile Choice "14" "the queue starts its next command after the immediate motion has ended" refused;
    UnknownMode Choice "15a" "a mode above 9 causes no motion and raises 0x01" refused;
    ModeSeven Vendor "7" "mode 7 is a straight line by a Cartesian offset";
    ModeNine Vendor "7" "mode 9 is a jump to an absolute target with a straight transfer";
    JumpPath Sibling "7" "a jump lifts, transfers and descends, with a full stop after each, and is checked before it starts";
    JumpAboveLimit Sibling "15a" "a jump that starts or ends above zLimit transfers at the height of the higher end, without 0x15";
    UnequalJump Choice "15a" "a jump with unequal heights lifts by the first, transfers to the second above the target, and descends" refused;
    ShortMove Choice "15a" "a move shorter than 0.0001 finishes at once, without an alarm"
        kept "nothing to carry out";
    OutputShare Choice "7" "an output of a move switches when its percentage of the whole path is done"
        kept "switching on the way is known; this decides only when";

    // The rail.
    RailSwitch Vendor "12" "the rail is in use if DeviceWithL is 1";
    RailIgnored Vendor "12" "without the rail, rail parameters of commands are ignored";
    RailPose Vendor "12" "PoseL reports the rail position, 0 at power-up";
    RailWithArm Choice "7" "rail and arm start and end together, in the time of the slower one"
        kept "the common move is known; this decides only its speed";
    RailRamps Choice "15a" "the rail moves at 100 mm/s and 100 mm/s2 by default"
        kept "the move is known; this decides only its speed";
    RailHome Choice "11" "homing moves the rail to 0 while J1 searches for its switch"
        kept "homing of the rail is known; this decides only its time and speed";
    RailEnds Choice "15a" "a rail position beyond an end is clamped to that end, without an alarm" refused;

    // Continuous path, arcs, jogs.
    CpLaw Sibling "8" "segments follow each other without a stop, within planAcc, junctionVel and the speed limit of corners";
    CpRotation Sibling "8" "J4 does not move along a continuous path, so r drifts with J1";
    CpLaser Sibling "8" "the laser has the power of the running segment and is off at rest";
    CpTimes Sibling "8" "a segment takes the nearest whole number of periods, at least one";
    CpFollows Choice "8" "a running segment is replanned as further ones are queued; with an empty queue it ends at rest"
        kept "the path is known; this decides only its speed";
    CpStops Choice "14" "after a stop or an alarm the running segment comes to rest at its end"
        kept "a stop is never refused";
    ArcPath Vendor "9" "an arc leads from the tool through cirPoint to toPoint";
    ArcPoints Vendor "9" "coincident points of an arc raise 0x13, collinear points 0x14";
    ArcSpeeds Sibling "9" "arcs use the point-to-point speeds and ratios, regardless of the ARC speeds";
    ArcRatio Choice "15a" "ARCCommonParams are stored and read back, 100 at power-up" refused;
    CircleTurns Vendor "9" "a circle makes full turns through its three points and ends at its start";
    Jog Measured "10" "a jog accelerates and decelerates by the JOG parameters, and reverses through zero speed";
    JogAxisChange Measured "10" "a jog of another axis takes over the speed of the running jog, with its sign, and then changes to its own";
    UnknownJog Choice "(none)" "a jog command above 10 stops the jog" refused;
    QueuedJog ThirdParty "10" "a queued jog counts as finished when it starts";

    // Waiting, pins, tools, sensors.
    Wait Vendor "14" "a queued wait is timed from its start";
    Trigger Vendor "E35" "a queued trigger blocks until its condition is met";
    MeaninglessTrigger Choice "(none)" "a trigger with an unknown pin or a meaningless condition is refused and does not block" refused;
    ImmediateWait Choice "E34" "an immediate wait or trigger is answered and has no effect" refused;
    IoFunctions Vendor "13" "pin functions: 1 output, 2 PWM, 3 input, 4 analog input, 5 and 6 input with a resistor";
    PinTable ThirdParty "13" "the functions that each pin supports";
    LackingFunction Choice "15a" "a function that a pin does not support is stored and read back, without effect" refused;
    IoOutputs Vendor "13" "digital and PWM outputs keep the values set";
    IoInputs Vendor "13" "an input reads the signal connected to it";
    OpenInput Choice "13" "an input with nothing connected reads low"
        kept "a floating input may read anything";
    LastPin Choice "E39" "a get of a pin without an address replies for the pin addressed last" refused;
    Steppers Vendor "13" "the stepper outputs emit pulses at the rate set";
    StepperDistance Choice "(none)" "a queued EMotorS has finished when all its pulses are emitted"
        kept "the distance is known; this decides only when the next command starts";
    ToolPins ThirdParty "13" "the tools are wired to pins: laser 2 and 4, valve 16, pump 17; a pin set as output drives its tool";
    Sensors Vendor "13" "colour and infrared sensors read what is in front of them when enabled";
    InfraredPort Choice "15a" "GetIRSwitch without a connector replies for the one set last" refused;
    Tools Vendor "13" "laser, suction cup and gripper act as set and read back the values set";
    VacuumDelay Choice "15a" "the suction cup takes 0.3 s to hold or release"
        kept "holding is known; this decides only when";
    GripperDelay Choice "15a" "the gripper takes 0.5 s to close or open"
        kept "closing is known; this decides only when";

    // The queue.
    Indices Measured "14" "a queued command is answered with an index, one more than the last";
    FirstIndex Sibling "14" "the first index is 2";
    CurrentIndex Measured "14" "the current index is that of the last finished command";
    CurrentAtFirst Choice "15a" "the current index is 0 until the first command has finished"
        kept "hosts read it first, and any value means that nothing has finished";
    IndexAfterClear Sibling "15a" "after a clear the numbering continues, and the current index is unchanged";
    QueueDepth ThirdParty "14" "the queue has 32 slots";
    RunningPlace Choice "14" "the running command keeps its slot until it has finished"
        kept "this changes a count only, by one";
    FullQueue Choice "14" "a command sent to a full queue is answered with index 0 and Ctrl bit 2, and not stored" refused;
    Start Vendor "14" "after a start the queue runs its commands";
    QueueStopped Vendor "E47" "at power-up the queue is stopped until the first start";
    StartAgain Sibling "14" "a start ends the running motion where it is; its command counts as finished";
    StopFinishes Vendor "14" "after a stop the running motion finishes, and the queue still accepts commands";
    StopCutsWait Sibling "14" "a stop ends a running wait or trigger";
    ForceStop Sibling "14" "a forced stop decelerates at twice the acceleration; the stopped motion counts as finished";
    ForceStopStops Choice "14" "after a forced stop the queue is stopped"
        kept "a stop is never refused";
    Clear Vendor "14" "a clear discards the pending commands";
    ClearWhileMoving Sibling "14" "a clear ends the running motion where it is; its command counts as finished";
}
