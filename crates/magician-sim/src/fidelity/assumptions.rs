//! List of all assumptions behind the behaviour of the virtual arm.
//!
//! A choice is refused in strict mode if it decides what the arm does or answers. A choice is kept
//! if it decides only a figure (duration, speed, number, initial value) of known behaviour, or if
//! refusing would do the same.

use super::list_assumptions;

list_assumptions! {
    // Position of the arm.
    CommandedPose Measured "1" "GetPose reports the commanded joints and the pose that they make, not where the arm really is";
    BaseUnknown Measured "11" "before homing J1 reads 0 wherever the base stood at power-up";
    PowerUpPose Choice "15a" "at power-up the arm stands at joints (0, 45, 45, 0) with J1 reading 0"
        kept "where an arm stands when it is switched on is the scenario's matter";
    PowerUpTool Measured "6" "at power-up the tool is the one that was chosen before: the suction cup unless something says otherwise";
    ToolBias Measured "2" "the pose is the wrist's, moved by the tool bias, from the moment that the bias is set";
    Zeros Choice "15a" "Kinematics, DeviceInfo, UserParams, UART4PeripheralsModel and the status of the ZDF calibration read as zeros" refused;
    ResetPose Vendor "11" "ResetPose sets what is believed of J2 and J3, or has them read from the sensors";
    UntimelyResetPose Choice "(none)" "ResetPose while the arm moves, or to angles beyond a full turn, does nothing" refused;

    // The arm's identity, and its clock.
    Identity Vendor "15" "name and serial number are kept as they are set, up to 64 and 23 bytes";
    Version Vendor "15" "the firmware version is three bytes, 3.6.14";
    Clock Vendor "15" "the clock counts milliseconds since power-up and wraps at 32 bits";
    DeviceIdWords Choice "15" "the three words of the device id are drawn from a seed"
        kept "any arm has others";
    FlashKeeps Choice "6" "a reset forgets all settings but name, serial number, Wi-Fi, sensor calibration and program"
        kept "a reset is no command";
    ResetAlarm Measured "11" "alarm 0x00 stands from power-up until it is cleared";

    // Settings, and the values that are read back.
    Parameters Vendor "6" "speeds and heights are those of the vendor's printed samples at power-up, and read back as they are set";
    CappedWhenSet Sibling "6" "speeds and accelerations of jogs and point-to-point moves beyond the ceilings are set to the ceiling";
    BeyondCeilings Choice "6" "ratios and speeds of paths beyond the ceilings are stored as they come and capped when a motion is planned" refused;
    RailDefaults Choice "6" "the rail's speeds before any are set read as 100 mm/s and 100 mm/s2" refused;
    JumpSetsBoth Sibling "7" "one jump height is both heights of the second set";
    StoredWithoutEffect Choice "15a" "AutoLeveling, the corrections of the sensors, ArmOrientation, CPRHeadHoldEnable and CPCommonParams are stored and read back, without effect" refused;
    OutsideTheDocument Choice "15a" "FirmwareSwitch, FirmwareMode, PulseMode, UART4 and ZDF are stored or answered, without effect" refused;
    PtpTime Choice "15a" "PTPTime answers how long the move would take from here, in ms, or 0 for one that would be refused" refused;
    MotionFinish Measured "15a" "QueuedCmdMotionFinish answers whether nothing moves";
    WifiSettings Vendor "15" "the settings of the Wi-Fi module are kept as they are set";
    WifiDefaults Choice "15" "the settings of the Wi-Fi module before any are set read as empty, with DHCP" refused;
    WifiStatus ThirdParty "15" "the Wi-Fi module joins any network that has a name, some seconds after power-up or after it leaves its command mode";

    // Frames.
    ForeignBytes ThirdParty "E10" "bytes that are no frame are passed over";
    DamagedFrame Measured "E10" "a frame with a wrong checksum or length is not answered";
    UnknownId Choice "E09" "an unknown id is not answered and raises 0x01" refused;
    WrongCount Choice "E11" "a parameter count of no known form is answered, and nothing is done"
        kept "nothing is done in either mode";
    QueuedBitAlone Measured "E07" "isQueued alone decides queueing, of any command that can be set";
    SteeringQueued Choice "E47" "isQueued on the commands that steer the queue is ignored: they act at once" refused;
    SetOnlyRead Choice "E12" "a command that can only be set, with rw = 0, is answered empty and does nothing"
        kept "nothing is done in either mode";
    GetOnlyWritten ThirdParty "E12" "a value that can only be read is answered whatever rw says";
    DestinationBits Choice "E05" "a frame to another destination or slave is answered as the arm's own" refused;

    // Alarms and limits.
    AlarmBits Vendor "E20" "alarm n is bit n % 8 of byte n / 8 of 16";
    ClearAlarms ThirdParty "E19" "id 20 with rw = 1 clears the alarms whose cause is gone";
    ClearBy21 Vendor "E19" "id 21 clears them, too";
    AlarmHold Measured "4" "an alarm above 0x07 holds the queue until the alarms are cleared";
    QuietAlarms Vendor "4" "the alarms 0x00 to 0x07 hold nothing";
    LatchedHold Choice "4" "a limit alarm that drops by itself leaves its hold on the queue until a clear"
        kept "nothing is done meanwhile";
    LimitDrops Sibling "4" "a limit alarm drops by itself when the joint is back inside";
    ImmediateWhileHeld Choice "15a" "an immediate move is carried out although an alarm holds the queue" refused;
    JogWhileHeld Vendor "4" "a jog is carried out although an alarm holds the queue";
    HomeWhileHeld Measured "4" "homing is carried out although an alarm holds the queue";
    TargetChecked Sibling "4" "a target in space is checked before the arm moves: 0x11 out of reach, 0x12 beyond a limit";
    PathChecked Sibling "4" "a path in space ends where it leaves the reach (0x21) or the limits (0x22)";
    JointTargets Sibling "15a" "a joint target is not checked before: the arm runs to the limit, stops there and raises 0x40 to 0x49 alone";
    SoftLimits ThirdParty "4" "the limits are the controller's soft limits, wider than what the vendor guarantees, and of J2 wider than what every arm is sure to have";
    RefusedFinishes Sibling "15a" "a queued motion that is refused or ends before its target counts as finished";
    NotFinite Choice "15a" "a target that is not a finite number raises 0x11" refused;
    NoSpeed Choice "6" "a motion that needs a speed or acceleration which is not above 0 raises 0x1A" refused;
    LostSteps Vendor "12" "LostStepCmd compares the sensors of J2 and J3 with the commanded angles and raises 0x51, 0x52";
    LostBase Choice "12" "LostStepCmd compares the encoder of J1, too, and raises 0x50" refused;

    // Homing.
    HomingSequence Measured "11" "homing turns J1 to its switch, backs off, creeps on, sets J1 and moves to the home point";
    HomingFigures Choice "15a" "the switch stands at -135, the base backs off 0.5 degrees: 14 s from J1 = 0"
        kept "homing is known, this decides only its time";
    HomePoint Vendor "11" "the home point is the one that was set, else joints (0, 45, 45, 0)";
    HomeOutOfReach Choice "15a" "homing to a point out of reach ends at joints (0, 45, 45, 0), without an alarm" refused;
    HomeUnset Choice "15a" "HOMEParams before any were set read as the pose of joints (0, 45, 45, 0) with the present bias" refused;
    HomeUnchecked Sibling "11" "HOMEParams are stored without a look at whether the arm gets there";

    // Teaching by hand, and the keys.
    TeachKey Vendor "12" "the unlock key releases the motors, and the sensors are read";
    TeachSettings Vendor "12" "the mode and the output of hand teaching are kept as they are set";
    PointCleared Choice "12" "reading a new point of hand teaching clears it" refused;
    TeachPeriod Choice "12" "in the periodic mode a new point comes every 0.5 s"
        kept "the mode is known, this decides only its times";
    MotionWhileUnlocked Choice "12" "while the unlock key is held the queue waits and immediate motions do nothing"
        kept "nothing is done in either mode";
    BaseKey Vendor "12" "the base key, pressed for a short time, runs the stored program";
    BaseKeyHeld Measured "12" "the base key, pressed for a long time, homes the arm";

    // Programs.
    OfflineProgram Vendor "12" "what is queued between StartDownload and StopDownload is stored and not run";
    OfflineMismatch Choice "12" "a program of another length than announced is kept as it came" refused;
    OfflineBusy Sibling "12" "StartDownload while the program runs does nothing";
    StoredLineIndex Choice "(none)" "a stored line is answered with an index of the queue, at which nothing will run"
        kept "a queued command must be answered with an index";

    // Point to point.
    PtpLaw Measured "7" "each axis follows a trapezoid in velocity in periods of 20 ms, the slowest sets the time, and each move ends at rest";
    PlannedAtStart Sibling "7" "a move is planned with the parameters in force when it starts";
    ReplacedMotion Sibling "14" "an immediate motion replaces the one under way; a replaced motion of the queue counts as finished";
    QueueMeanwhile Choice "14" "the queue takes its next command when the immediate motion has ended" refused;
    UnknownMode Choice "15a" "a mode above 9 moves nothing and raises 0x01" refused;
    ModeSeven Vendor "7" "mode 7 is a straight line by a difference in space";
    ModeNine Vendor "7" "mode 9 is a jump to an absolute target with a straight transfer";
    JumpPath Sibling "7" "a jump lifts, goes across and descends with three full stops, checked before it begins";
    JumpAboveLimit Sibling "15a" "a jump that begins or ends above zLimit goes across at the higher end, without 0x15";
    UnequalJump Choice "15a" "a jump with unequal heights lifts by the one, goes across to the other above the target, and descends" refused;
    ShortMove Choice "15a" "a move shorter than 0.0001 finishes at once, without an alarm"
        kept "there is nothing to carry out";
    OutputShare Choice "7" "an output of a move switches when its share of the whole path is done"
        kept "that it switches on the way is known, this decides only when";

    // The rail.
    RailSwitch Vendor "12" "the rail is there when DeviceWithL says so";
    RailIgnored Vendor "12" "without the rail what a command says of it is ignored";
    RailPose Vendor "12" "PoseL reports the rail's place, 0 at power-up";
    RailWithArm Choice "7" "the rail begins and ends with the arm, in the time of the slower"
        kept "that both move is known, this decides only how fast";
    RailRamps Choice "15a" "the rail moves at 100 mm/s and 100 mm/s2 unless it is set"
        kept "that it moves is known, this decides only how fast";
    RailHome Choice "11" "homing takes the rail to its 0 while J1 looks for its switch"
        kept "that it is homed is known, this decides only when and how fast";
    RailEnds Choice "15a" "a place beyond the rail's ends is its end, without an alarm" refused;

    // Continuous path, arcs, jogs.
    CpLaw Sibling "8" "segments follow each other without a stop, within planAcc, junctionVel and the limit of corners";
    CpRotation Sibling "8" "J4 stands along a continuous path, so r drifts with J1";
    CpLaser Sibling "8" "the laser has the power of its segment and is off at rest";
    CpTimes Sibling "8" "a segment takes the nearest whole number of periods, at least one";
    CpFollows Choice "8" "a running segment is planned anew as further ones are queued; an empty queue ends it at rest"
        kept "the path is known, this decides only its speed";
    CpStops Choice "14" "after a stop or an alarm the segment under way ends at its end, at rest"
        kept "a stop is never refused";
    ArcPath Vendor "9" "an arc leads from the tool through cirPoint to toPoint";
    ArcPoints Vendor "9" "points of an arc that coincide raise 0x13, points on a line 0x14";
    ArcSpeeds Sibling "9" "arcs take the point-to-point speeds and ratios, whatever the ARC speeds are";
    ArcRatio Choice "15a" "ARCCommonParams are stored and read back, 100 at power-up" refused;
    CircleTurns Vendor "9" "a circle makes full turns through its three points and ends where it began";
    Jog Measured "10" "a jog accelerates and slows down by the JOG parameters, and turns round through zero";
    JogAxisChange Measured "10" "a jog of another axis takes over the speed of the one under way, with its sign, and then goes for its own";
    UnknownJog Choice "(none)" "a jog command above 10 stops the jog" refused;
    QueuedJog ThirdParty "10" "a queued jog has finished when it begins";

    // Waiting, pins, tools, sensors.
    Wait Vendor "14" "a queued wait counts from its start";
    Trigger Vendor "E35" "a queued trigger blocks until its condition is met";
    MeaninglessTrigger Choice "(none)" "a trigger on a pin that there is not, or of no meaning, is refused and does not block" refused;
    ImmediateWait Choice "E34" "an immediate wait or trigger is answered and does nothing" refused;
    IoFunctions Vendor "13" "pin functions: 1 output, 2 pulses, 3 input, 4 analog, 5 and 6 input with a resistor";
    PinTable ThirdParty "13" "what each pin can do";
    LackingFunction Choice "15a" "a function that a pin lacks is stored and read back, without effect" refused;
    IoOutputs Vendor "13" "outputs and pulses are kept as they are set";
    IoInputs Vendor "13" "an input reads what is connected to it";
    OpenInput Choice "13" "an input with nothing connected reads low"
        kept "a floating input may read anything";
    LastPin Choice "E39" "a get of a pin without an address answers for the pin addressed last" refused;
    Steppers Vendor "13" "the stepper outputs give pulses at the rate that is set";
    StepperDistance Choice "(none)" "a queued EMotorS has finished when its pulses are out"
        kept "that the motor turns so far is known, this decides only when the next command begins";
    ToolPins ThirdParty "13" "the tools hang on pins: laser 2 and 4, valve 16, pump 17; one that is made an output drives its tool";
    Sensors Vendor "13" "colour and infrared sensor read what is before them when enabled";
    InfraredPort Choice "15a" "GetIRSwitch without a connector answers for the one set last" refused;
    Tools Vendor "13" "laser, suction cup and gripper do and read back what they are told";
    VacuumDelay Choice "15a" "the suction cup takes 0.3 s to hold or let go"
        kept "that it holds is known, this decides only when";
    GripperDelay Choice "15a" "the gripper takes 0.5 s to close or open"
        kept "that it closes is known, this decides only when";

    // The queue.
    Indices Measured "14" "a queued command is answered with an index, one more than the last";
    FirstIndex Sibling "14" "the first index is 2";
    CurrentIndex Measured "14" "the current index is that of the last finished command";
    CurrentAtFirst Choice "15a" "the current index is 0 until the first command has finished"
        kept "hosts read it to begin with, and whatever it is it says that nothing has finished";
    IndexAfterClear Sibling "15a" "after a clear numbering goes on, and the current index stands";
    QueueDepth ThirdParty "14" "the queue has 32 places";
    RunningPlace Choice "14" "the running command keeps its place until it has finished"
        kept "this decides only a figure, by one";
    FullQueue Choice "14" "a command that finds the queue full is answered with index 0 and Ctrl bit 2, and not stored" refused;
    Start Vendor "14" "a start lets the queue take its commands";
    QueueStopped Vendor "E47" "at power-up the queue is stopped until the first start";
    StartAgain Sibling "14" "a start ends the running motion where it is, and its command counts as finished";
    StopFinishes Vendor "14" "after a stop the running motion finishes, and commands are still taken";
    StopCutsWait Sibling "14" "a stop ends a running wait or trigger";
    ForceStop Sibling "14" "a forced stop brakes at twice the acceleration, and its motion counts as finished";
    ForceStopStops Choice "14" "after a forced stop the queue is stopped"
        kept "a stop is never refused";
    Clear Vendor "14" "a clear drops what waits";
    ClearWhileMoving Sibling "14" "a clear ends the running motion where it is, and its command counts as finished";
}
