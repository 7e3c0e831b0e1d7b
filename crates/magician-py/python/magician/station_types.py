"""Types of the messages of a station, for programs that talk JSON-RPC to it: `cargo xtask station` writes this
module from the tables that the station itself works by. docs/reference/STATION-API.md says what they mean.

`XxxYyyParams` and `XxxYyyResult` are of the method `xxx.yyy`, `XxxYyyNotification` are parameters of a notification.
"""

from __future__ import annotations

from typing import Literal, TypedDict, Union

__all__ = [
    "AlarmClearedEvent",
    "AlarmRaisedEvent",
    "ArmAlarmsParams",
    "ArmAlarmsResult",
    "ArmAlarmsResultAlarmsItem",
    "ArmClearAlarmsParams",
    "ArmClearAlarmsResult",
    "ArmEnqueueParams",
    "ArmEnqueueResult",
    "ArmEventNotification",
    "ArmFenceParams",
    "ArmFenceResult",
    "ArmGetParams",
    "ArmGetResult",
    "ArmHomeParams",
    "ArmHomeResult",
    "ArmInfoParams",
    "ArmInfoResult",
    "ArmIoParams",
    "ArmIoResult",
    "ArmIoResultAnalog",
    "ArmIoResultFunctionsItem",
    "ArmIoResultPinsItem",
    "ArmIoResultRowsItem",
    "ArmListParams",
    "ArmListResult",
    "ArmListResultArmsItem",
    "ArmListResultArmsItemWaitingItem",
    "ArmModelParams",
    "ArmModelResult",
    "ArmModelResultLimits",
    "ArmModelResultLinksItem",
    "ArmModelResultTool",
    "ArmMoveParams",
    "ArmMoveResult",
    "ArmMoveResultItem",
    "ArmSetParams",
    "ArmSetResult",
    "ArmSpeedParams",
    "ArmSpeedResult",
    "ArmStateNotification",
    "ArmStateParams",
    "ArmStateResult",
    "ArmStopParams",
    "ArmStopResult",
    "ArmSubscribeParams",
    "ArmSubscribeResult",
    "ArmToolParams",
    "ArmToolResult",
    "ArmUnsubscribeParams",
    "ArmUnsubscribeResult",
    "Bounds",
    "Box",
    "Choice",
    "Class",
    "ClassClass",
    "ClassCodesParams",
    "ClassCodesResult",
    "ClassFreeParams",
    "ClassFreeResult",
    "ClassFreezeParams",
    "ClassFreezeResult",
    "ClassGetParams",
    "ClassGetResult",
    "ClassPupilsItem",
    "ClassResultsParams",
    "ClassResultsResult",
    "ClassResultsResultResultsItem",
    "ClassSendParams",
    "ClassSendResult",
    "ClassSendResultJobsItem",
    "ClassSetParams",
    "ClassSetResult",
    "ClientName",
    "CommandFinishedEvent",
    "Complaint",
    "ErrorData",
    "Event",
    "EventsSinceParams",
    "EventsSinceResult",
    "ExpectedArm",
    "Fence",
    "FenceChange",
    "Field",
    "Fields",
    "GivenRow",
    "HandTriggerEvent",
    "Holder",
    "Job",
    "JobChangedNotification",
    "JobCheckParams",
    "JobCheckResult",
    "JobDeleteParams",
    "JobDeleteResult",
    "JobError",
    "JobEvent",
    "JobGetParams",
    "JobGetResult",
    "JobHistoryParams",
    "JobHistoryResult",
    "JobHistoryResultTotals",
    "JobListParams",
    "JobListResult",
    "JobPauseParams",
    "JobPauseResult",
    "JobReorderParams",
    "JobReorderResult",
    "JobResumeParams",
    "JobResumeResult",
    "JobStartParams",
    "JobStartResult",
    "JobStopParams",
    "JobStopResult",
    "JogEndedNotification",
    "JogEvent",
    "JogKeepParams",
    "JogStartParams",
    "JogStartResult",
    "JogStepParams",
    "JogStepResult",
    "JogStopParams",
    "JogStopResult",
    "Laser",
    "Lease",
    "LeaseAcquireParams",
    "LeaseAcquireResult",
    "LeaseAnswerParams",
    "LeaseAnswerResult",
    "LeaseAskParams",
    "LeaseAskResult",
    "LeaseAskedNotification",
    "LeaseChangedNotification",
    "LeaseEvent",
    "LeaseQueueNotification",
    "LeaseReleaseParams",
    "LeaseReleaseResult",
    "LeaseRenewParams",
    "LeaseRenewResult",
    "LeaseTakeParams",
    "LeaseTakeResult",
    "LibraryUse",
    "LinkFoundEvent",
    "LinkLostEvent",
    "MeasuredSheet",
    "MeasuredSurface",
    "MissedEvent",
    "MotionForwardParams",
    "MotionForwardResult",
    "MotionInverseParams",
    "MotionInverseResult",
    "MotionReachParams",
    "MotionReachResult",
    "Note",
    "NoteHelp",
    "Option",
    "Part",
    "PenSetup",
    "Pin",
    "PinAddress",
    "Plan",
    "PlanName",
    "PlanOrigin",
    "PlanOutput",
    "PlanStep",
    "PlanStepArc",
    "PlanStepBurn",
    "PlanStepCommand",
    "PlanStepGripper",
    "PlanStepHome",
    "PlanStepJoints",
    "PlanStepLaser",
    "PlanStepMove",
    "PlanStepPart",
    "PlanStepPartPart",
    "PlanStepPath",
    "PlanStepPause",
    "PlanStepShift",
    "PlanStepSuction",
    "PlanStepWait",
    "PlanSurface",
    "Plane",
    "Pose",
    "Preset",
    "PresetListParams",
    "PresetListResult",
    "PresetRemoveParams",
    "PresetRemoveResult",
    "PresetSaveParams",
    "PresetSaveResult",
    "PresetShowParams",
    "PresetShowResult",
    "Preview",
    "PreviewStrokesItem",
    "ProgramConvertParams",
    "ProgramConvertResult",
    "ProgramConvertResultNotesItem",
    "ProgramDeleteParams",
    "ProgramDeleteResult",
    "ProgramGetParams",
    "ProgramGetResult",
    "ProgramListParams",
    "ProgramListResult",
    "ProgramListResultProgramsItem",
    "ProgramOptionsParams",
    "ProgramOptionsResult",
    "ProgramPutParams",
    "ProgramPutResult",
    "Pupil",
    "RecordSaveLastParams",
    "RecordSaveLastResult",
    "RecordStartParams",
    "RecordStartResult",
    "RecordStopParams",
    "RecordStopResult",
    "RecordingLostEvent",
    "RecordingSavedEvent",
    "Remedy",
    "Report",
    "ReportFence",
    "ReportPlaced",
    "ReportPower",
    "ReportWouldFit",
    "ResetEvent",
    "Row",
    "ScheduleGetParams",
    "ScheduleGetResult",
    "ScheduleGetResultSlotsItem",
    "ScheduleSetParams",
    "ScheduleSetResult",
    "ScheduleSetResultSlotsItem",
    "SentenceValue",
    "ServerEndingNotification",
    "ServerInfoParams",
    "ServerInfoResult",
    "Session",
    "SessionChangedNotification",
    "SessionHelloParams",
    "SessionHelloResult",
    "SessionHelloResultLimits",
    "SessionListParams",
    "SessionListResult",
    "Setup",
    "SiteExpectParams",
    "SiteExpectResult",
    "SiteRosterParams",
    "SiteRosterResult",
    "State",
    "StateChange",
    "Stood",
    "StopEvent",
    "Surface",
    "SurfaceChangedNotification",
    "SurfaceCornerParams",
    "SurfaceCornerResult",
    "SurfaceGetParams",
    "SurfaceGetResult",
    "SurfaceTouchParams",
    "SurfaceTouchResult",
    "TeachCaptureParams",
    "TeachCaptureResult",
    "TeachGuideParams",
    "TeachGuideResult",
    "TeachOutputParams",
    "TeachOutputResult",
    "TeachPlanParams",
    "TeachPlanResult",
    "TeachRowsParams",
    "TeachRowsResult",
    "Tool",
    "TurnChangedNotification",
    "TurnChangedNotificationArmsItem",
    "TurnChangedNotificationArmsItemJobsItem",
    "TurnChangedNotificationArmsItemSlot",
    "TurnChangedNotificationQueueItem",
    "TurnEndParams",
    "TurnEndResult",
    "TurnEndingNotification",
    "TurnGrantedNotification",
    "TurnJoinParams",
    "TurnJoinResult",
    "TurnLeaveParams",
    "TurnLeaveResult",
    "TurnList",
    "TurnListArmsItem",
    "TurnListArmsItemJobsItem",
    "TurnListArmsItemSlot",
    "TurnListParams",
    "TurnListQueueItem",
    "TurnListResult",
    "TurnListYou",
    "TurnNextParams",
    "TurnNextResult",
    "Turns",
    "TurnsArmsItem",
    "TurnsArmsItemJobsItem",
    "TurnsArmsItemSlot",
    "TurnsQueueItem",
    "UnaccountedEvent",
    "WorldFaultParams",
    "WorldFaultResult",
    "WorldGuideParams",
    "WorldGuideResult",
    "WorldInputParams",
    "WorldInputResult",
    "WorldLookParams",
    "WorldLookResult",
    "WorldLookResultBelt",
    "WorldLookResultObjectsItem",
    "WorldLookResultStrokesItem",
    "WorldLookResultTable",
    "WorldPaperParams",
    "WorldPaperResult",
    "WorldPlaceParams",
    "WorldPlaceResult",
    "WorldPressParams",
    "WorldPressResult",
    "WorldScenarioParams",
    "WorldScenarioResult",
    "WorldScenariosParams",
    "WorldScenariosResult",
    "WorldScenariosResultScenariosItem",
    "WorldUnlockParams",
    "WorldUnlockResult",
    "WorldUnplugParams",
    "WorldUnplugResult",
]


class State(TypedDict):
    """Latest state of an arm."""

    t: float
    """Time of the reading, by the station's clock, Unix seconds."""
    arm: str
    """Name of the arm."""
    x: float
    """Position of the tool tip, mm."""
    y: float
    """Position of the tool tip, mm."""
    z: float
    """Position of the tool tip, mm."""
    r: float
    """Rotation of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""
    rail: Union[float, None]
    """Position on the rail, mm; null: the arm has no rail."""
    current_index: int
    """Queue index of the last finished command."""
    left_space: int
    """Free places in the arm's queue; 0 if it is full, and the station waits. The size of the queue depends on the firmware; the virtual arm has 32 places, commands."""
    alarms: list[int]
    """Codes of the active alarms; `arm.alarms` explains them."""
    link: Literal["up", "lost"]
    """State of the line to the arm."""
    moving: bool
    """True if the arm moves, or may move."""
    homed: Union[bool, None]
    """True if homed since power-up; false if it reported a reset and was not homed since; null: unknown: no reset was reported, and this computer saw no homing."""
    tool: Tool
    """State of the tools."""
    speed: Union[float, None]
    """Speed ratio of moves, percent; null: unknown: neither read nor set on this connection."""
    pins: list[Pin]
    """Pins watched by subscribers of the arm."""
    job: Union[str, None]
    """Current job; null: no job is in progress."""
    jog: Union[str, None]
    """Current jog; null: no jog is in progress."""
    holder: Union[Holder, None]
    """Holder of the lease, who may move the arm; null: the arm is free."""

class Tool(TypedDict):
    """State of the tools of an arm, derived from the commands sent to it; null means unknown."""

    name: Union[Literal["none", "suction", "gripper", "pen", "laser"], None]
    """Mounted tool; null: unknown, or no named tool has this tip."""
    bias: Union[list[float], None]
    """Offset of the tip from the flange, x, y, z, mm; null: unknown."""
    suction: Union[bool, None]
    """True if the suction cup is on; null: unknown."""
    gripper: Union[Literal["open", "closed", "off"], None]
    """State of the gripper; off: its pump is off; null: unknown."""
    laser: Union[bool, None]
    """True if the laser may burn by the last known command; null: unknown."""

class Pin(TypedDict):
    """Level of a watched pin."""

    kind: Literal["input", "output", "analog"]
    """Kind of reading."""
    address: int
    """EIO address, 1 to 20."""
    value: int
    """0 or 1; for an analog input counts, 4095 at 3.3 V."""

class Holder(TypedDict):
    """Session that holds the lease of an arm."""

    session: str
    """Id of the session."""
    name: str
    """Name of the session."""

class Pose(TypedDict):
    """Pose of an arm."""

    x: float
    """Position of the tool tip, mm."""
    y: float
    """Position of the tool tip, mm."""
    z: float
    """Position of the tool tip, mm."""
    r: float
    """Rotation of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""

class LibraryUse(TypedDict):
    """Use of the library of programs."""

    programs: int
    """Number of programs."""
    bytes: int
    """Total size, bytes."""

class Stood(TypedDict):
    """Arm at standstill after a stop."""

    arm: str
    """Name of the arm."""
    stood: bool
    """True if two consecutive readings were equal."""
    pose: Pose
    """Pose of the arm."""

class Lease(TypedDict):
    """Granted lease."""

    arm: str
    """Name of the arm."""
    lease: str
    """Id, for `lease.renew` and `lease.release`."""
    ttl_s: float
    """Lease timeout: the lease ends if the holder sends nothing for this long, s."""

class Session(TypedDict):
    """Session of the station."""

    session: str
    """Id of the session."""
    name: str
    """Name of the session."""
    role: Literal["viewer", "student", "teacher"]
    """Role of the session."""
    leases: list[str]
    """Arms whose lease it holds."""
    since: float
    """Begin of the session, Unix seconds."""

class Job(TypedDict):
    """Job, in progress or finished."""

    job: str
    """Id, never reused."""
    arm: str
    """Name of the arm."""
    title: Union[str, None]
    """Title of the program; null: not read yet, or no title."""
    state: Literal["queued", "checking", "running", "pausing", "paused", "stopping", "done", "stopped", "failed", "interrupted"]
    """State; from `done` on the job has ended."""
    step: int
    """Finished steps of loop `loop`; the pair never decreases."""
    steps: Union[int, None]
    """Steps of one loop; null: not read yet."""
    first_step: Union[int, None]
    """First step, from 1; null: not read yet."""
    loops: int
    """Number of repetitions; 0 until stopped."""
    loop: int
    """Current loop, from 1."""
    seconds_left: Union[float, None]
    """Estimated time left, s; null: unknown, or unlimited."""
    drawn_mm: Union[float, None]
    """Drawn or burnt length, mm; null: not done."""
    travel_mm: Union[float, None]
    """Length of travel moves, mm; null: not done."""
    started: Union[float, None]
    """Start time, Unix seconds; null: queued."""
    ended: Union[float, None]
    """End time, Unix seconds; null: not ended."""
    holder: Union[Holder, None]
    """Owner of the job; null: unknown."""
    part: Union[int, None]
    """Next part, from 1; null: not waiting between parts."""
    reason: Union[Literal["person", "part", "program", "stopped", "yes", "restart", "unkept"], None]
    """For a `paused` job: `person`: on request, or because the lease ended; `part`: a part is done; `program`: the program asks for it. For a `queued` job that does not start by itself: `stopped`: the arm was stopped; `yes`: it may burn or is dangerous, and needs `job.resume` with `yes`; `restart`: the station was restarted; `unkept`: the disk could not store its start. `job.resume` continues all of them; null: neither paused nor held back."""
    text: Union[str, None]
    """Instruction for the person at the arm before the job continues; null: no instruction."""
    place: Union[int, None]
    """Place in the queue of its arm, from 1; null: not queued."""
    error: Union[JobError, None]
    """Cause of the failure or interruption; null: not failed."""
    notes: Union[list[Note], None]
    """Outputs left switched on, and grips of a virtual arm that picked nothing up; null: no notes."""
    digest: Union[str, None]
    """Digest of its program, as from `job.check`; null: not read yet."""

class _JobError(TypedDict):
    message: str
    """Cause, as a sentence."""

_JobErrorWords = TypedDict(
    "_JobErrorWords",
    {"from": "int", }, total=False,
)

class JobError(_JobErrorWords, _JobError, total=False):
    """Cause of a failed job: `data` of the error, and its message."""

    kind: str
    """Kind from the table of errors."""
    code: str
    """Identity of the error: programs decide by it, not by the message."""
    param: str
    """Name of the invalid parameter."""
    row: int
    """Invalid row of `teach.plan`, from 1."""
    method: str
    """Method that helps, or that is concerned."""
    command: str
    """Command of the protocol."""
    danger: Literal["laser", "arm"]
    """Danger that `yes` confirms."""
    step: int
    """Step of the program, from 1."""
    value: float
    """Requested value."""
    limit: float
    """Limit of the value, or of the number."""
    unit: str
    """Unit of both."""
    fence: str
    """Bound of the fence that would be crossed."""
    to: int
    """Last index or step in doubt."""
    remedies: list[Remedy]
    """Possible remedies."""
    template: str
    """Message with the names of its values in braces: key for translations."""
    values: list[SentenceValue]
    """Values in the template."""
    report: Report
    """Result of the check of the program."""
    digest: str
    """Current digest of the program."""
    expected: Pose
    """Expected pose."""
    pose: Pose
    """Current pose."""
    arm: str
    """Arm that is frozen, or reserved by the schedule."""
    until: Union[float, None]
    """End of the reservation, Unix time, s; null: unknown."""
    arms: list[Stood]
    """Arms that stand nevertheless."""
    role: Literal["viewer", "student", "teacher"]
    """Role of the session."""
    needs: Literal["viewer", "student", "teacher"]
    """Required role."""
    may: list[Literal["owner", "holder", "teacher"]]
    """Who may change a queued job: its owner, the holder of the lease, a teacher."""
    wait_s: float
    """Time until codes are accepted again, s."""
    quota: LibraryUse
    """Quota of the library."""
    used: LibraryUse
    """Used part of the quota."""
    holder: Union[Holder, None]
    """Holder of the lease; null: the arm is free."""
    free_in_s: float
    """Time until the lease of a holder without a socket ends, s."""
    reason: Literal["unkept"]
    """The disk could not store it."""
    by: Union[str, None]
    """Session that stopped it; null: not stopped by a session."""
    job: str
    """Job that has the arm."""
    jog: str
    """Jog that has the arm."""
    recording: str
    """Recording in progress."""

_ErrorDataWords = TypedDict(
    "_ErrorDataWords",
    {"from": "int", }, total=False,
)

class ErrorData(_ErrorDataWords, total=False):
    """`data` of an error. Its members depend on the kind: see the table of errors."""

    kind: str
    """Kind from the table of errors."""
    code: str
    """Identity of the error: programs decide by it, not by the message."""
    param: str
    """Name of the invalid parameter."""
    row: int
    """Invalid row of `teach.plan`, from 1."""
    method: str
    """Method that helps, or that is concerned."""
    command: str
    """Command of the protocol."""
    danger: Literal["laser", "arm"]
    """Danger that `yes` confirms."""
    step: int
    """Step of the program, from 1."""
    value: float
    """Requested value."""
    limit: float
    """Limit of the value, or of the number."""
    unit: str
    """Unit of both."""
    fence: str
    """Bound of the fence that would be crossed."""
    to: int
    """Last index or step in doubt."""
    remedies: list[Remedy]
    """Possible remedies."""
    template: str
    """Message with the names of its values in braces: key for translations."""
    values: list[SentenceValue]
    """Values in the template."""
    report: Report
    """Result of the check of the program."""
    digest: str
    """Current digest of the program."""
    expected: Pose
    """Expected pose."""
    pose: Pose
    """Current pose."""
    arm: str
    """Arm that is frozen, or reserved by the schedule."""
    until: Union[float, None]
    """End of the reservation, Unix time, s; null: unknown."""
    arms: list[Stood]
    """Arms that stand nevertheless."""
    role: Literal["viewer", "student", "teacher"]
    """Role of the session."""
    needs: Literal["viewer", "student", "teacher"]
    """Required role."""
    may: list[Literal["owner", "holder", "teacher"]]
    """Who may change a queued job: its owner, the holder of the lease, a teacher."""
    wait_s: float
    """Time until codes are accepted again, s."""
    quota: LibraryUse
    """Quota of the library."""
    used: LibraryUse
    """Used part of the quota."""
    holder: Union[Holder, None]
    """Holder of the lease; null: the arm is free."""
    free_in_s: float
    """Time until the lease of a holder without a socket ends, s."""
    reason: Literal["unkept"]
    """The disk could not store it."""
    by: Union[str, None]
    """Session that stopped it; null: not stopped by a session."""
    job: str
    """Job that has the arm."""
    jog: str
    """Jog that has the arm."""
    recording: str
    """Recording in progress."""

class Remedy(TypedDict, total=False):
    """Remedy for an error: one of `action`, `option`, `without` and `system`."""

    action: str
    """Action, such as `home`, `clear-alarms`."""
    option: str
    """Option to set."""
    value: Union[float, bool, str, list[float]]
    """Value of the option; without it the user chooses one."""
    without: str
    """Option to leave out."""
    system: str
    """Shell command for the station's machine."""
    effect: str
    """Effect."""

class _SentenceValue(TypedDict):
    name: str
    """Name in the template."""

class SentenceValue(_SentenceValue, total=False):
    """Value in a template: one of `text`, `option` and `template`."""

    text: str
    """Number or quotation, as printed."""
    option: str
    """Name of an option, which a client may translate."""
    template: str
    """Nested template."""
    values: list[SentenceValue]
    """Values of the nested template."""

class TurnsArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """Id of the job."""
    title: Union[str, None]
    """Title; null: no title."""
    person: Union[str, None]
    """Owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """Reason for waiting: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is frozen; schedule: no slot of its owner is open; turn: another person's turn; busy: the arm moves, or its lease is taken; lost: the line to the arm is lost; null: only the jobs before it."""

class TurnsArmsItemSlot(TypedDict):
    """Open slot of the schedule; null: free for all, or no slot is open."""

    who: list[str]
    """Who may acquire the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """End, Unix time, s; null: unlimited."""

class TurnsArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Name of the arm."""
    person: Union[str, None]
    """Person whose turn it is; null: no turn."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: the person is away; suspended: a teacher has the arm; null: no turn."""
    left_s: Union[float, None]
    """Time left in the turn, s; null: unlimited, or no turn."""
    frozen: bool
    """True if a teacher has frozen the arm."""
    jobs: list[TurnsArmsItemJobsItem]
    """Jobs queued for the arm, in order."""
    slot: Union[TurnsArmsItemSlot, None]
    """Open slot of the schedule; null: free for all, or no slot is open."""
    free_at: Union[float, None]
    """Begin of the next slot, Unix time, s; null: available now, or no slot is known."""

_TurnsQueueItemWords = TypedDict(
    "_TurnsQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnsQueueItem(_TurnsQueueItemWords):
    """Part of a message."""

    place: int
    """Place, from 1."""
    person: str
    """Person that waits."""
    arms: list[str]
    """Acceptable arms."""
    missed: bool
    """True if a turn came while the person was away."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """Reason for waiting: no slot of the person is open, all acceptable arms are frozen, or the person is away; null: only the persons before it."""

class Turns(TypedDict):
    """Turns and queue of a class."""

    turn_s: Union[float, None]
    """Length of a turn; 0 for unlimited turns, s; null: there are no turns."""
    arms: list[TurnsArmsItem]
    """Arms of the station."""
    queue: list[TurnsQueueItem]
    """Waiting persons, in order."""

class TurnListArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """Id of the job."""
    title: Union[str, None]
    """Title; null: no title."""
    person: Union[str, None]
    """Owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """Reason for waiting: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is frozen; schedule: no slot of its owner is open; turn: another person's turn; busy: the arm moves, or its lease is taken; lost: the line to the arm is lost; null: only the jobs before it."""

class TurnListArmsItemSlot(TypedDict):
    """Open slot of the schedule; null: free for all, or no slot is open."""

    who: list[str]
    """Who may acquire the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """End, Unix time, s; null: unlimited."""

class TurnListArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Name of the arm."""
    person: Union[str, None]
    """Person whose turn it is; null: no turn."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: the person is away; suspended: a teacher has the arm; null: no turn."""
    left_s: Union[float, None]
    """Time left in the turn, s; null: unlimited, or no turn."""
    frozen: bool
    """True if a teacher has frozen the arm."""
    jobs: list[TurnListArmsItemJobsItem]
    """Jobs queued for the arm, in order."""
    slot: Union[TurnListArmsItemSlot, None]
    """Open slot of the schedule; null: free for all, or no slot is open."""
    free_at: Union[float, None]
    """Begin of the next slot, Unix time, s; null: available now, or no slot is known."""

_TurnListQueueItemWords = TypedDict(
    "_TurnListQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnListQueueItem(_TurnListQueueItemWords):
    """Part of a message."""

    place: int
    """Place, from 1."""
    person: str
    """Person that waits."""
    arms: list[str]
    """Acceptable arms."""
    missed: bool
    """True if a turn came while the person was away."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """Reason for waiting: no slot of the person is open, all acceptable arms are frozen, or the person is away; null: only the persons before it."""

class TurnListYou(TypedDict):
    """The caller."""

    person: Union[str, None]
    """Name under which the caller takes turns; null: none."""
    arms: list[str]
    """Arms meant by `turn.join` without `arm`."""

class _TurnList(TypedDict):
    turn_s: Union[float, None]
    """Length of a turn; 0 for unlimited turns, s; null: there are no turns."""
    arms: list[TurnListArmsItem]
    """Arms of the station."""
    queue: list[TurnListQueueItem]
    """Waiting persons, in order."""

class TurnList(_TurnList, total=False):
    """Turns, with the caller's own part."""

    you: TurnListYou
    """The caller."""

class _ClientName(TypedDict):
    name: str
    """Name, 1 to 80 characters."""

class ClientName(_ClientName, total=False):
    """Client program that begins a session."""

    version: str
    """Version, up to 80 characters."""

class Pupil(TypedDict):
    """Sign-in of a pupil."""

    name: str
    """Name of the pupil."""
    code: str
    """Code of the pupil."""

class _ExpectedArm(TypedDict):
    arm: str
    """Name of the arm."""

class ExpectedArm(_ExpectedArm, total=False):
    """Arm expected on a site."""

    machine: str
    """Machine of its station."""

class PinAddress(TypedDict):
    """Pin to watch."""

    kind: Literal["input", "output", "analog"]
    """Kind of reading."""
    address: int
    """EIO address, 1 to 20."""

class _Laser(TypedDict):
    on: bool
    """True to switch it on."""

class Laser(_Laser, total=False):
    """Command for the laser."""

    power: float
    """0 to 100; while the arm stands only 100 is possible, less is `unsupported`, percent."""

class Box(TypedDict):
    """Axis-aligned box."""

    x: list[float]
    """Least and most, mm."""
    y: list[float]
    """Least and most, mm."""
    z: list[float]
    """Least and most, mm."""

class Fence(TypedDict):
    """Bounds of an arm: position, speed and laser power."""

    floor: Union[float, None]
    """Smallest z of the tip, mm; null: no bound."""
    box: Union[Box, None]
    """Box that the tip must stay in; null: no bound."""
    keep_out: list[Box]
    """Boxes that the tip must not enter."""
    speed: Union[float, None]
    """Highest speed, mm/s; null: no bound."""
    power: Union[float, None]
    """Highest power of the laser, percent; null: no bound."""

class FenceChange(TypedDict, total=False):
    """Members of a fence to change; null removes the bound."""

    floor: Union[float, None]
    """Smallest z of the tip, mm; null: no bound."""
    box: Union[Box, None]
    """Box that the tip must stay in; null: no bound."""
    keep_out: Union[list[Box], None]
    """Boxes that the tip must not enter; null: no box."""
    speed: Union[float, None]
    """Highest speed, mm/s; null: no bound."""
    power: Union[float, None]
    """Highest power of the laser, percent; null: no bound."""

class _Surface(TypedDict):
    height: float
    """Z of the surface at x = y = 0, as the arm reports it when the tool touches, mm."""

class Surface(_Surface, total=False):
    """Work surface of a plan."""

    slope: list[float]
    """Slope in x and in y, mm per mm; default level."""

class MeasuredSurface(TypedDict):
    """Measured work surface of an arm."""

    touches: int
    """Number of touches; 0 if nothing was measured."""
    plane: Union[Plane, None]
    """Surface; null: nothing measured."""
    residual: Union[float, None]
    """Largest distance of a touch from the plane, mm; null: nothing measured."""
    corners: list[Literal["lower-left", "lower-right", "upper-left"]]
    """Corners measured so far of an incomplete sheet."""
    sheet: Union[MeasuredSheet, None]
    """Sheet of paper; null: no sheet."""

class Plane(TypedDict):
    """Plane through a point."""

    at: list[float]
    """X and y of the point, mm."""
    z: float
    """Z at the point, as the arm reports it when the tool touches, mm."""
    slope_x: float
    """Slope in x, mm per mm."""
    slope_y: float
    """Slope in y, mm per mm."""

class MeasuredSheet(TypedDict):
    """Position of a sheet of paper."""

    corner: list[float]
    """X and y of its lower left corner, as its reader sees it, mm."""
    rotation: float
    """Angle from the arm's X to its lower edge, deg."""
    size: Union[list[float], None]
    """Width and height, mm; null: unknown."""
    outline: list[list[float]]
    """Four corners, counterclockwise from the lower left one, mm."""

class Row(TypedDict):
    """Row of the table of a plan: target, action of the tool, waiting time."""

    name: str
    """Name of the row."""
    motion: Union[PlanStep, None]
    """Step as in plan files; null: the arm stays."""
    gripper: Union[Literal["off", "open", "close"], None]
    """Action of the gripper; null: unchanged."""
    suction: Union[bool, None]
    """Action of the suction cup; null: unchanged."""
    wait: Union[float, None]
    """Waiting time, s; null: no wait."""

class GivenRow(TypedDict, total=False):
    """Row for `teach.plan`: as Row, but null members may be missing."""

    name: str
    """Name of the row."""
    motion: Union[PlanStep, None]
    """Step as in plan files; null: the arm stays."""
    gripper: Union[Literal["off", "open", "close"], None]
    """Action of the gripper; null: unchanged."""
    suction: Union[bool, None]
    """Action of the suction cup; null: unchanged."""
    wait: Union[float, None]
    """Waiting time, s; null: no wait."""

class _StateChange(TypedDict):
    t: float
    """Time of the reading, by the station's clock, Unix seconds."""

class StateChange(_StateChange, total=False):
    """A State, or what of it is other than in the last one: each member that is there takes the place of the one before, whole."""

    arm: str
    """Name of the arm."""
    x: float
    """Position of the tool tip, mm."""
    y: float
    """Position of the tool tip, mm."""
    z: float
    """Position of the tool tip, mm."""
    r: float
    """Rotation of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""
    rail: Union[float, None]
    """Position on the rail, mm; null: the arm has no rail."""
    current_index: int
    """Queue index of the last finished command."""
    left_space: int
    """Free places in the arm's queue; 0 if it is full, and the station waits. The size of the queue depends on the firmware; the virtual arm has 32 places, commands."""
    alarms: list[int]
    """Codes of the active alarms; `arm.alarms` explains them."""
    link: Literal["up", "lost"]
    """State of the line to the arm."""
    moving: bool
    """True if the arm moves, or may move."""
    homed: Union[bool, None]
    """True if homed since power-up; false if it reported a reset and was not homed since; null: unknown: no reset was reported, and this computer saw no homing."""
    tool: Tool
    """State of the tools."""
    speed: Union[float, None]
    """Speed ratio of moves, percent; null: unknown: neither read nor set on this connection."""
    pins: list[Pin]
    """Pins watched by subscribers of the arm."""
    job: Union[str, None]
    """Current job; null: no job is in progress."""
    jog: Union[str, None]
    """Current jog; null: no jog is in progress."""
    holder: Union[Holder, None]
    """Holder of the lease, who may move the arm; null: the arm is free."""

class AlarmRaisedEvent(TypedDict):
    """An alarm became active."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["alarm-raised"]
    code: int
    """Code of the alarm; `arm.alarms` explains active alarms."""

class AlarmClearedEvent(TypedDict):
    """An alarm was cleared."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["alarm-cleared"]
    code: int
    """Code of the alarm; `arm.alarms` explains active alarms."""

class CommandFinishedEvent(TypedDict):
    """The arm finished commands of its queue."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["command-finished"]
    index: int
    """Queue index of the last one."""

class UnaccountedEvent(TypedDict):
    """The arm finished commands that this station did not send."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["unaccounted"]
    index: int
    """Queue index of the last one."""

class LinkLostEvent(TypedDict):
    """The line to the arm broke."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["link-lost"]

class LinkFoundEvent(TypedDict):
    """The arm answers again."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["link-found"]

class ResetEvent(TypedDict):
    """The arm was reset or switched on: its queue is empty, and its settings have power-up values."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["reset"]

class MissedEvent(TypedDict):
    """The station could not keep up and dropped events."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["missed"]
    count: int
    """Number of dropped events."""

class HandTriggerEvent(TypedDict):
    """The unlock key was released while `teach.guide` is on."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["hand-trigger"]
    step: PlanStep
    """Step to the position of the arm."""

class StopEvent(TypedDict):
    """The arm was stopped. Further stops within 50 ms are not reported."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["stop"]
    by: Union[str, None]
    """Session that stopped it; null: stopped by the end of a lease."""

class LeaseEvent(TypedDict):
    """The holder of the lease changed."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["lease"]
    holder: Union[Holder, None]
    """Current holder; null: the arm is free."""

class JobEvent(TypedDict):
    """The state of a job changed."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["job"]
    job: str
    """Id of the job."""
    state: Literal["queued", "checking", "running", "pausing", "paused", "stopping", "done", "stopped", "failed", "interrupted"]
    """State of the job."""

class _JogEvent(TypedDict):
    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["jog"]
    jog: str
    """Id of the jog."""

class JogEvent(_JogEvent, total=False):
    """A jog began (`axis`) or ended (`why`)."""

    axis: Literal["x+", "x-", "y+", "y-", "z+", "z-", "r+", "r-", "j1+", "j1-", "j2+", "j2-", "j3+", "j3-", "j4+", "j4-", "l+", "l-"]
    """Axis and direction, at the beginning."""
    why: Literal["released", "not-kept", "stopped", "lease", "link", "replaced", "limit"]
    """Reason of the end: stopped by its session, or the session ended; hold time expired; the arm was stopped; the lease ended; the line broke; replaced by another jog of the session; a limit or the fence was reached."""

class RecordingSavedEvent(TypedDict):
    """The last minutes were saved to a file because of an alarm."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["recording-saved"]
    name: str
    """File name, for GET /api/v1/recordings/{name}."""
    bytes: int
    """Size of the file."""

class RecordingLostEvent(TypedDict):
    """A recording ended because its file could not be written."""

    arm: str
    """Name of the arm."""
    seq: int
    """Sequence number at this arm, from 1, for `events.since`."""
    t: float
    """Time, by the station's clock, Unix seconds."""
    event: Literal["recording-lost"]
    name: str
    """File name, for GET /api/v1/recordings/{name}."""
    message: str
    """Cause."""

class Setup(TypedDict, total=False):
    """How a program is drawn or engraved."""

    preset: str
    """A preset, which says what the rest leaves open."""
    work: Literal["draw", "engrave"]
    """Kind of work for drawings and images: draw with a pen, or engrave with the laser."""
    font: str
    """Font of text: a built-in font or a font file."""
    size: float
    """Height of capital letters, mm."""
    wrap: float
    """Width at which text wraps, mm."""
    place: bool
    """Place a program (G-code, a plan, playback, points) like a drawing."""
    tool: Union[str, list[float]]
    """Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm."""
    fill: Literal["none", "hatch", "cross", "contour"]
    """Fill visible shapes, and letters of outline fonts, with lines."""
    image: Literal["outline", "centerline", "halftone", "squiggle", "hatch"]
    """Style in which the pen draws an image."""
    surface: float
    """Height of the work surface, mm."""
    at: list[float]
    """Position of the centre of the artwork, mm."""
    scale: float
    """Scale factor; 1 is the original size."""
    width: float
    """Width to scale to, mm."""
    rotate: float
    """Counter-clockwise rotation, deg."""
    fit: bool
    """Shrink the artwork until all of it is within the arm's reach and on the page."""
    height: float
    """Height to scale to, instead of a width, mm."""
    clip_page: bool
    """Clip a drawing to its page."""
    page: str
    """Paper size of the page to draw on; also a size in mm, such as 200x150."""
    margin: float
    """Margin kept to the edges of the page when fitting, mm."""
    turn: bool
    """Rotate the artwork by 90 degrees if it fits better."""
    mirror: bool
    """Mirror the artwork left to right."""
    move: list[float]
    """Offset added to the position, mm."""
    grid: str
    """Repeat the artwork at each position of a grid, such as 2x3:40x30."""
    raw: bool
    """Use the coordinates of the file as arm coordinates, unchanged."""
    fill_spacing: float
    """Spacing of the fill lines, mm."""
    fill_angle: float
    """Angle of the fill lines, counter-clockwise from x, deg."""
    fill_inset: float
    """Inset of the fill lines from the edge of the shape, mm."""
    white: Literal["skip", "draw"]
    """Handling of white lines and shapes."""
    align: Literal["left", "center", "right"]
    """Alignment of lines of text."""
    line_height: float
    """Line spacing of text, as a multiple of the height of capital letters."""
    text: Literal["outline", "stroke"]
    """Rendering of text in a drawing."""
    system_fonts: Literal["on", "off"]
    """Use of installed fonts for text in a drawing."""
    strict_text: bool
    """Refuse text if the font lacks a character; by default the character is skipped, with a note."""
    parts: Literal["none", "layer", "color"]
    """Split a drawing into parts; the job pauses between them for a pen change."""
    only: list[str]
    """Parts to draw, each by its name, colour (#rrggbb or a CSS name) or number."""
    passes: int
    """Number of times to draw each part before the next one."""
    pens: list[PenSetup]
    """Pens of the parts; the first pen that matches a part is used."""
    no_pause: bool
    """Never pause for the operator, neither between parts nor where the program asks for it."""
    levels: int
    """Number of superimposed hatchings, or of dot sizes."""
    despeckle: float
    """Largest size of spots in an image to remove; 0 keeps all, mm."""
    pen_width: float
    """Line width of the pen, for images, mm."""
    spacing: float
    """Spacing of the lines or dots of an image, mm."""
    threshold: int
    """Grey level below which a pixel counts as dark, if the image is drawn or burnt in black and white."""
    crop: list[int]
    """Area of an image to keep, in pixels from the upper left corner, px."""
    brightness: float
    """Brightness adjustment of an image."""
    contrast: float
    """Contrast adjustment of an image."""
    gamma: float
    """Gamma, the exponent of the darkness; above 1 makes mid-tones lighter."""
    invert: bool
    """Draw or burn the white areas instead of the black ones."""
    power: Union[float, str]
    """Full laser power, or the range of all powers above 0, such as 5..80, %."""
    mode: Literal["grey", "threshold", "dither"]
    """Rendering of grey levels: as laser power, in black and white, or by dithering."""
    one_way: bool
    """Burn all lines in the same direction: slower, but without errors from backlash."""
    overscan: float
    """Overscan: run-up and run-out of the tool at the ends of a line, mm."""
    frame: Literal["box", "hull", "outline"]
    """Trace the frame of the job instead of marking it."""
    frame_power: float
    """Laser power while tracing a frame, %."""
    lift: float
    """Pen lift between lines, mm."""
    hop: float
    """Smallest pen lift, between lines that are close together, mm."""
    travel_speed: float
    """Travel speed between lines, mm/s."""
    stay: bool
    """Leave the pen down at the end and after a stop."""
    depths: Literal["flatten", "keep"]
    """Handling of depths below the surface."""
    order: bool
    """Reorder lines for the shortest travel."""
    merge: float
    """Largest gap between line ends to join; 0 disables joining, mm."""
    dedupe: bool
    """Draw duplicate lines only once."""
    simplify: float
    """Tolerance of line simplification: a point is dropped if the line stays within this distance without it; 0 keeps all points, mm."""
    tolerance: float
    """Tolerance of curve flattening: largest distance of a line from its curve, at the drawn size, mm."""
    speed: float
    """Speed while drawing or burning, mm/s."""
    speed_ratio: float
    """Speed ratio of point-to-point moves, %."""
    park: list[float]
    """Position at which to park the tool tip at the end, mm."""
    dialect: Literal["pen", "laser", "servo"]
    """Type of machine that a G-code file is for; the pen servo is moved by M3, M280 or M300."""
    s_max: float
    """Value of S for full laser power in a G-code file."""
    pen_z: float
    """Z at which the pen touches the surface in placed G-code, mm."""
    start: list[float]
    """Start position of the tool for a G-code program that does not set it, mm."""
    resample: float
    """Tolerance of simplifying a recording: points closer than this to the line are dropped, mm."""

class _PenSetup(TypedDict):
    match: Union[str, int]
    """The parts that it is for: a name or a colour, or a number from 1."""

class PenSetup(_PenSetup, total=False):
    """Part of a message."""

    surface_offset: float
    """How much higher it draws, mm."""
    lift: float
    """Pen lift between lines, mm."""
    speed: float
    """Speed along the lines, mm/s."""
    power: float
    """Power along the lines, percent."""
    passes: int
    """How often its parts are drawn."""
    fill: str
    """How their shapes are filled."""

class _PlanSurface(TypedDict):
    height: float

class PlanSurface(_PlanSurface, total=False):
    """Part of a message."""

    slope: list[float]
    """How much higher it is for each mm in x and in y; level if left out."""

class _Plan(TypedDict):
    steps: list[PlanStep]
    """What is done, in this order. One step is one command of the protocol, but for parts and pauses."""
    format: Literal["magician-plan"]
    """What the file is."""
    version: Literal[1, 2]
    """The version of this form: 2 with parts or pauses, else 1."""

class Plan(_Plan, total=False):
    """What a Dobot Magician arm is to do, step by step. Lengths are mm, angles degrees, times seconds; coordinates are the arm's, for the tip of the tool."""

    title: str
    """What the plan is called."""
    tool: Union[None, Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """The tool that it is made for, or its bias from the wrist as x, y, z; null or nothing for the bias in force on the arm."""
    surface: Union[None, PlanSurface]
    """The surface that it works on."""
    names: list[str]
    """Names that steps refer to by number, from 1; left out where each step says its name itself."""

class PlanOutput(TypedDict):
    """Part of a message."""

    ratio: int
    address: int
    level: int

class _PlanStepMove(TypedDict):
    move: list[float]
    """Goes to x, y, z, r."""

class PlanStepMove(_PlanStepMove, total=False):
    """Goes to a pose."""

    by: Literal["joints", "line", "jump"]
    """Which way: all joints together, on a straight line, or up, across and down. joints if left out."""
    at: PlanOrigin
    name: PlanName

class _PlanStepJoints(TypedDict):
    joints: list[float]
    """Goes to J1, J2, J3, J4."""

class PlanStepJoints(_PlanStepJoints, total=False):
    """Goes to joint angles."""

    by: Literal["joints", "line", "jump"]
    """Which way: all joints together, on a straight line, or up, across and down. joints if left out."""
    at: PlanOrigin
    name: PlanName

class _PlanStepShift(TypedDict):
    shift: list[float]
    """Goes by so much in x, y, z, r."""

class PlanStepShift(_PlanStepShift, total=False):
    """Goes on from where the arm is."""

    by: Literal["joints", "line"]
    """Which way: all joints together, or on a straight line. joints if left out."""
    at: PlanOrigin
    name: PlanName

class _PlanStepArc(TypedDict):
    arc: list[float]
    """Where it ends: x, y, z, r."""
    via: list[float]
    """A pose on the way: x, y, z, r."""

class PlanStepArc(_PlanStepArc, total=False):
    """Goes on an arc of a circle."""

    at: PlanOrigin
    name: PlanName

class _PlanStepPath(TypedDict):
    path: list[float]
    """Where the segment ends: x, y, z."""

class PlanStepPath(_PlanStepPath, total=False):
    """A segment of a continuous path."""

    at: PlanOrigin
    name: PlanName

class _PlanStepBurn(TypedDict):
    burn: list[float]
    """Where the segment ends: x, y, z."""
    power: float

class PlanStepBurn(_PlanStepBurn, total=False):
    """A segment of a continuous path with the laser."""

    at: PlanOrigin
    name: PlanName

class _PlanStepSuction(TypedDict):
    suction: bool

class PlanStepSuction(_PlanStepSuction, total=False):
    """Switches the suction cup."""

    at: PlanOrigin
    name: PlanName

class _PlanStepGripper(TypedDict):
    gripper: Literal["off", "open", "close"]

class PlanStepGripper(_PlanStepGripper, total=False):
    """Has the gripper do something; off switches its pump off."""

    at: PlanOrigin
    name: PlanName

class _PlanStepLaser(TypedDict):
    laser: bool

class PlanStepLaser(_PlanStepLaser, total=False):
    """Switches the laser."""

    at: PlanOrigin
    name: PlanName

class _PlanStepPartPart(TypedDict):
    n: int
    """Its number."""

_PlanStepPartPartWords = TypedDict(
    "_PlanStepPartPartWords",
    {"pass": "int", }, total=False,
)

class PlanStepPartPart(_PlanStepPartPartWords, _PlanStepPartPart, total=False):
    """Part of a message."""

    name: Union[None, str]
    """Its layer, pen or tool."""
    color: Union[None, str]
    """Its colour: #rrggbb, or a name of CSS."""

class _PlanStepPart(TypedDict):
    part: PlanStepPartPart

class PlanStepPart(_PlanStepPart, total=False):
    """A part of the work begins: what is drawn with one pen, or one pass over it. Nothing is sent. Version 2."""

    at: PlanOrigin
    name: PlanName

class _PlanStepPause(TypedDict):
    pause: str
    """What the person is told."""
    reason: Literal["part", "program"]
    """Why it waits: between two parts, or because the program says so."""

class PlanStepPause(_PlanStepPause, total=False):
    """Waits for a person, with nothing in the arm, the pen up and the laser off. Nothing is sent. Version 2."""

    at: PlanOrigin
    name: PlanName

class _PlanStepWait(TypedDict):
    wait: float
    """Seconds, in whole ms."""

class PlanStepWait(_PlanStepWait, total=False):
    """Waits."""

    at: PlanOrigin
    name: PlanName

class _PlanStepHome(TypedDict):
    home: Literal[True]

class PlanStepHome(_PlanStepHome, total=False):
    """Finds the reference and goes to the home point."""

    at: PlanOrigin
    name: PlanName

class _PlanStepCommand(TypedDict):
    command: str
    """The vendor's name of a command that can be queued, without Get and Set."""

class PlanStepCommand(_PlanStepCommand, total=False):
    """Any other command: speeds, pins, sensors, the rail, motors."""

    values: dict[str, Union[float, str, list[Union[float, str, PlanOutput]]]]
    """Its fields, under the names of the protocol's table."""
    at: PlanOrigin
    name: PlanName

class Field(TypedDict):
    """Part of a message."""

    name: str
    about: str
    unit: str
    kind: str
    least: Union[float, None]
    most: Union[float, None]
    choices: list[Choice]

class Choice(TypedDict):
    """Part of a message."""

    value: float
    name: str

_OptionWords = TypedDict(
    "_OptionWords",
    {"with": "Union[str, None]", },
)

class Option(_OptionWords):
    """Part of a message."""

    name: str
    kind: Literal["choice", "number", "integer", "point", "place", "area", "switch", "text", "list", "pens"]
    unit: str
    choices: list[str]
    default: Union[float, str, bool, None]
    least: Union[float, None]
    above: Union[float, None]
    most: Union[float, None]
    when: list[str]
    group: Literal["place", "fill", "text", "parts", "image", "laser", "pen", "more"]
    usual: bool
    about: str

class ReportPower(TypedDict):
    """Part of a message."""

    most: float
    least: float

class ReportWouldFit(TypedDict):
    """Part of a message."""

    scale: float
    rotate: float

class ReportFence(TypedDict):
    """Part of a message."""

    floor: Union[float, None]
    box: Union[list[list[float]], None]
    keep_out: list[list[list[float]]]
    top_speed: Union[float, None]
    strongest_laser: Union[float, None]

class _ReportPlaced(TypedDict):
    scale: float
    turn: float
    at: list[float]

class ReportPlaced(_ReportPlaced, total=False):
    """Part of a message."""

    page: list[list[float]]

class _Report(TypedDict):
    ok: bool
    seconds: Union[float, None]
    steps: Union[float, None]
    drawn_mm: float
    travel_mm: float
    refused: float
    complaints: list[Complaint]
    parts: list[Part]

class Report(_Report, total=False):
    """Part of a message."""

    bounds: Bounds
    travel_bounds: Bounds
    power: ReportPower
    would_fit: Union[ReportWouldFit, None]
    fence: ReportFence
    placed: ReportPlaced
    notes: list[Note]
    preview: Preview
    digest: str

class Bounds(TypedDict):
    """Part of a message."""

    x: list[float]
    y: list[float]
    z: list[float]

class _Complaint(TypedDict):
    step: float
    kind: str
    message: str

_ComplaintWords = TypedDict(
    "_ComplaintWords",
    {"from": "float", }, total=False,
)

class Complaint(_ComplaintWords, _Complaint, total=False):
    """Part of a message."""

    line: float
    column: float
    name: str
    template: str
    values: list[SentenceValue]
    beyond: float
    code: str
    command: str
    value: float
    limit: float
    unit: str
    fence: str
    to: float
    remedies: list[Remedy]

class _NoteHelp(TypedDict):
    template: str

class NoteHelp(_NoteHelp, total=False):
    """Part of a message."""

    values: list[SentenceValue]

class _Note(TypedDict):
    code: str
    text: str

class Note(_Note, total=False):
    """Part of a message."""

    template: str
    values: list[SentenceValue]
    help: NoteHelp
    line: float
    element: str
    remedies: list[Remedy]

class Part(TypedDict):
    """Part of a message."""

    n: float
    name: Union[str, None]
    color: Union[str, None]
    strokes: float
    drawn_mm: float
    seconds: Union[float, None]
    skipped: bool

class PreviewStrokesItem(TypedDict):
    """Part of a message."""

    points: list[list[float]]
    height: float
    part: Union[float, None]
    power: float
    reachable: bool

class Preview(TypedDict):
    """Part of a message."""

    strokes: list[PreviewStrokesItem]
    travels: list[list[list[float]]]

class _Preset(TypedDict):
    name: str
    shipped: bool
    note: Union[str, None]
    path: Union[str, None]

class Preset(_Preset, total=False):
    """Part of a message."""

    options: Setup
    text: str
    problem: str

class ClassClass(TypedDict):
    """Part of a message."""

    turn_s: float
    grace_s: float
    finish_job: bool
    speed: Union[float, None]
    fence: Union[FenceChange, None]
    arms: list[str]

class ClassPupilsItem(TypedDict):
    """Part of a message."""

    name: str
    group: Union[str, None]
    code: Union[str, None]
    here: Union[bool, None]
    place: Union[float, None]
    arm: Union[str, None]

__ClassWords = TypedDict(
    "__ClassWords",
    {"class": "Union[ClassClass, None]", },
)

class _Class(__ClassWords):
    groups: dict[str, list[str]]
    pupils: list[ClassPupilsItem]
    pin: Union[str, None]
    text: Union[str, None]

class Class(_Class, total=False):
    """Part of a message."""

    codes_kept: list[str]

class _SessionHelloParams(TypedDict):
    client: ClientName
    """Client program: `name`, and optionally `version`."""

class SessionHelloParams(_SessionHelloParams, total=False):
    """Parameters of a method."""

    token: str
    """Token of the station."""
    pupil: Pupil
    """Sign-in of a pupil: `name` and `code`; replaces a token."""
    pin: str
    """Teacher's PIN of the class, on this machine only; replaces a token."""
    resume: str
    """Secret of a session to resume, from an earlier answer."""
    role: Literal["viewer", "student", "teacher"]
    """Upper limit for the role of the session, below that of its token."""

class SessionHelloResultLimits(TypedDict):
    """Part of a message."""

    message: float
    rate: float
    sockets: float

class SessionHelloResult(TypedDict):
    """Result of a method."""

    session: str
    resume: str
    resumed: bool
    role: str
    api: float
    version: str
    arms: list[str]
    limits: SessionHelloResultLimits

class SessionListParams(TypedDict):
    """Parameters of a method."""

class SessionListResult(TypedDict):
    """Result of a method."""

    sessions: list[Session]

class ServerInfoParams(TypedDict):
    """Parameters of a method."""

class ServerInfoResult(TypedDict):
    """Result of a method."""

    version: str
    api: float
    uptime_s: float
    arms: list[str]
    programs: Union[str, None]
    recording: bool
    features: list[str]

class ArmListParams(TypedDict):
    """Parameters of a method."""

class ArmListResultArmsItemWaitingItem(TypedDict):
    """Part of a message."""

    session: str
    name: str
    asks: bool

class ArmListResultArmsItem(TypedDict):
    """Part of a message."""

    name: str
    port: str
    virtual: bool
    link: str
    holder: Union[Holder, None]
    waiting: list[ArmListResultArmsItemWaitingItem]
    job: Union[str, None]

class ArmListResult(TypedDict):
    """Result of a method."""

    arms: list[ArmListResultArmsItem]

class ArmInfoParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class ArmInfoResult(TypedDict):
    """Result of a method."""

    port: str
    device_name: str
    device_sn: str
    firmware: str
    device_id: Union[list[float], None]
    uptime_ms: float
    with_l: bool
    alarms: list[float]
    queue_current_index: float
    queue_left_space: float
    laser: Union[bool, None]
    suction: Union[bool, None]
    gripper: Union[str, None]
    fence: Union[Fence, None]

class ArmIoParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class ArmIoResultAnalog(TypedDict):
    """Part of a message."""

    counts: float
    volts: float

class ArmIoResultFunctionsItem(TypedDict):
    """Part of a message."""

    value: float
    name: str
    about: str
    watch: Union[str, None]

class ArmIoResultPinsItem(TypedDict):
    """Part of a message."""

    address: float
    function: float
    can: Union[list[float], None]
    level: Union[float, None]
    frequency: Union[float, None]
    duty_cycle: Union[float, None]

class ArmIoResultRowsItem(TypedDict):
    """Part of a message."""

    role: str
    command: str
    about: str
    asks: Union[list[Field], None]
    tells: Union[list[Field], None]
    sets: Union[list[Field], None]

class ArmIoResult(TypedDict):
    """Result of a method."""

    analog: ArmIoResultAnalog
    functions: list[ArmIoResultFunctionsItem]
    pins: list[ArmIoResultPinsItem]
    rows: list[ArmIoResultRowsItem]

class ArmStateParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _ArmSubscribeParams(TypedDict):
    rate: int
    """States per second."""

class ArmSubscribeParams(_ArmSubscribeParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    frame: Literal["json", "binary"]
    """Encoding of the states; default json."""
    pins: list[PinAddress]
    """Pins to read as well: `kind` (input, output, analog) and `address` (1 to 20)."""

class ArmSubscribeResult(TypedDict):
    """Result of a method."""

    subscription: float
    rate: float
    fields: list[str]

class ArmUnsubscribeParams(TypedDict):
    """Parameters of a method."""

    subscription: int
    """Id of the subscription."""

class _ArmGetParams(TypedDict):
    command: str
    """A command of the protocol."""

class ArmGetParams(_ArmGetParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    query: Fields
    """Fields of the query."""

class _ArmSetParams(TypedDict):
    command: str
    """A command of the protocol."""

class ArmSetParams(_ArmSetParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    fields: Fields
    """Its fields."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class _ArmEnqueueParams(TypedDict):
    command: str
    """A command of the protocol that can be queued."""

class ArmEnqueueParams(_ArmEnqueueParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    fields: Fields
    """Its fields."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class ArmEnqueueResult(TypedDict):
    """Result of a method."""

    index: float

class _ArmMoveParams(TypedDict):
    to: list[float]
    """Target: x, y, z (mm), r (deg), or four joints (deg); then the rail (mm) if there is one."""

class ArmMoveParams(_ArmMoveParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    by: Literal["joint", "linear", "jump"]
    """Path; default joint."""
    frame: Literal["xyz", "joints"]
    """Coordinates of `to`; default xyz."""
    relative: bool
    """Interprets `to` relative to the current position."""
    wait: bool
    """Answers only after the motion; default true."""

class ArmMoveResultItem(TypedDict):
    """Part of a message."""

    index: float

class ArmHomeParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class ArmClearAlarmsParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class ArmToolParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """Mounted tool, or offset of its tip from the flange (mm)."""
    suction: bool
    """Switches the suction cup."""
    gripper: Literal["open", "closed", "off"]
    """State of the gripper."""
    laser: Laser
    """Laser: `on`, and `power` (percent), which must be 100 while the arm stands."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class ArmSpeedParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    percent: float
    """Speed ratio of moves and jogs; alternatively `row`."""
    row: str
    """Command of the protocol that sets speeds."""
    fields: Fields
    """Its fields."""

class ArmAlarmsParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class ArmAlarmsResultAlarmsItem(TypedDict):
    """Part of a message."""

    code: float
    name: str
    cause: str
    remedy: str
    cure: str
    holds_queue: bool

class ArmAlarmsResult(TypedDict):
    """Result of a method."""

    alarms: list[ArmAlarmsResultAlarmsItem]

class ArmStopParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class ArmStopResult(TypedDict):
    """Result of a method."""

    arms: list[Stood]

class ArmFenceParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    set: Union[FenceChange, None]
    """Members to change: `floor` (mm), `box` {x, y, z: [least, most]} (mm), `keep_out` (boxes), `speed` (mm/s), `power` (percent); null removes a bound, or all; needs the role teacher."""

class ArmFenceResult(TypedDict):
    """Result of a method."""

    fence: Union[Fence, None]

class ArmModelParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class ArmModelResultLinksItem(TypedDict):
    """Part of a message."""

    name: str
    parent: Union[str, None]
    joint: Union[str, None]
    axis: list[float]
    at: list[float]
    shape: str
    size: list[float]
    turn: list[float]
    color: str

class ArmModelResultLimits(TypedDict):
    """Part of a message."""

    j1: list[float]
    j2: list[float]
    j3: list[float]
    j4: list[float]
    j2_minus_j3: list[float]
    l: Union[list[float], None]

class ArmModelResultTool(TypedDict):
    """Part of a message."""

    name: Union[str, None]
    bias: list[float]

class ArmModelResult(TypedDict):
    """Result of a method."""

    frame: str
    links: list[ArmModelResultLinksItem]
    limits: ArmModelResultLimits
    tool: ArmModelResultTool

class _EventsSinceParams(TypedDict):
    seq: int
    """Sequence number of the last known event; 0 for all."""

class EventsSinceParams(_EventsSinceParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class EventsSinceResult(TypedDict):
    """Result of a method."""

    events: list[Event]
    seq: float

class LeaseAcquireParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    wait_s: float
    """Longest wait for the lease, s; default 0. Refused with -32002 when the time is over."""

class LeaseRenewParams(TypedDict):
    """Parameters of a method."""

    lease: str
    """Id of the lease."""

class LeaseReleaseParams(TypedDict):
    """Parameters of a method."""

    lease: str
    """Id of the lease."""

class LeaseAskParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    message: str
    """Message for the holder."""

class _LeaseAskResult(TypedDict):
    granted: bool

class LeaseAskResult(_LeaseAskResult, total=False):
    """Result of a method."""

    lease: str
    ttl_s: float

class _LeaseAnswerParams(TypedDict):
    session: str
    """Session that asked."""
    grant: bool
    """True to pass the lease on."""

class LeaseAnswerParams(_LeaseAnswerParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class LeaseTakeParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _JogStartParams(TypedDict):
    axis: Literal["x+", "x-", "y+", "y-", "z+", "z-", "r+", "r-", "j1+", "j1-", "j2+", "j2-", "j3+", "j3-", "j4+", "j4-", "l+", "l-"]
    """Axis, joint or rail, with direction."""

class JogStartParams(_JogStartParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    keep_ms: int
    """Hold time, ms: the jog stops if `jog.keep` does not renew it; default 250."""
    percent: float
    """Speed ratio of the jog."""

class JogStartResult(TypedDict):
    """Result of a method."""

    jog: str

class JogKeepParams(TypedDict):
    """Parameters of a method."""

    jog: str
    """The jog."""

class JogStopParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    jog: str
    """Id of the jog; default: the current jog of the arm."""

class JogStopResult(TypedDict):
    """Result of a method."""

    stood: bool
    pose: Pose

class _JogStepParams(TypedDict):
    axis: Literal["x", "y", "z", "r", "j1", "j2", "j3", "j4", "l"]
    """Axis, joint or rail."""
    by: float
    """Signed distance, mm or deg."""

class JogStepParams(_JogStepParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    frame: Literal["base", "tool"]
    """Frame of x and y: the base, or rotated by r; default base."""
    percent: float
    """Speed ratio of the move."""

class JobCheckParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    program: str
    """Name of a program in the library; alternatively `text` or `data`."""
    text: str
    """Content of the program as text; alternatively `data`."""
    data: str
    """Content of the program in base64; alternatively `text`."""
    format: str
    """Format, if its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid."""
    setup: Setup
    """Options of drawing and engraving: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset for all other options; without `setup` the program runs unchanged."""
    preview: bool
    """Adds `preview`, the expected result: `{strokes: [{points, height, part, power, reachable}], travels}`, at most 20,000 points each; `part` is a number of `parts`, or null; `power` of the laser in percent, 100 for ink."""

_JobStartParamsWords = TypedDict(
    "_JobStartParamsWords",
    {"from": "int", }, total=False,
)

class JobStartParams(_JobStartParamsWords, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    program: str
    """Name of a program in the library; alternatively `text` or `data`."""
    text: str
    """Content of the program as text; alternatively `data`."""
    data: str
    """Content of the program in base64; alternatively `text`."""
    format: str
    """Format, if its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid."""
    setup: Setup
    """Options of drawing and engraving: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset for all other options; without `setup` the program runs unchanged."""
    loops: int
    """Number of repetitions; 0 repeats until stopped; default 1."""
    keep: bool
    """Lets the commands in the arm's queue finish first."""
    require_homed: bool
    """Refuses an arm that has not been homed."""
    unhomed: bool
    """Accepts an arm not known to be homed: it may act in the wrong place."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""
    on_lost: Literal["pause", "stop", "continue"]
    """Action when the lease ends; default pause, or continue if the caller has no session."""
    queue: bool
    """Queues the job, without the lease, until the arm has no job and no turn of others; it is then checked again."""
    after_check: bool
    """Answers only after the check; default true."""
    key: str
    """Idempotency key chosen by the caller, such as a UUID. A second start with the same key starts nothing and returns the first answer, even after a restart of the station. Refused if program, `digest`, `setup`, `loops`, `from`, `keep`, `require_homed` or `unhomed` differ. Keys are per arm."""
    digest: str
    """`digest` of the check that the user saw: refused with -32009 if the program, or the preset named in `setup`, has changed since."""

class JobStartResult(TypedDict):
    """Result of a method."""

    job: str

class JobGetParams(TypedDict):
    """Parameters of a method."""

    job: str
    """Id of the job."""

class JobListParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class JobListResult(TypedDict):
    """Result of a method."""

    jobs: list[Job]

class JobPauseParams(TypedDict):
    """Parameters of a method."""

    job: str
    """Id of the job."""

class _JobResumeParams(TypedDict):
    job: str
    """Id of the job."""

class JobResumeParams(_JobResumeParams, total=False):
    """Parameters of a method."""

    approach: bool
    """Approaches the drawing safely, because the arm may have been moved; default true."""
    overlap: float
    """Length of a burnt line to burn again before the point of interruption, mm; default 0."""
    yes: bool
    """Confirms a dangerous command, or one that may burn."""

class JobStopParams(TypedDict):
    """Parameters of a method."""

    job: str
    """Id of the job."""

class JobHistoryParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    skip: int
    """Number of newest jobs to skip; default 0."""
    limit: int
    """Largest number of jobs to return; default 50."""

class JobHistoryResultTotals(TypedDict):
    """Part of a message."""

    jobs: float
    done: float
    stopped: float
    failed: float
    interrupted: float
    drawn_mm: float
    travel_mm: float
    seconds: float

class JobHistoryResult(TypedDict):
    """Result of a method."""

    jobs: list[Job]
    more: bool
    totals: JobHistoryResultTotals

class JobReorderParams(TypedDict):
    """Parameters of a method."""

    job: str
    """Id of the job."""
    position: int
    """New `place`, from 1; larger values mean the last place."""

class JobDeleteParams(TypedDict):
    """Parameters of a method."""

    job: str
    """Id of the job."""

class _ProgramPutParams(TypedDict):
    name: str
    """Name of the program."""

class ProgramPutParams(_ProgramPutParams, total=False):
    """Parameters of a method."""

    text: str
    """Content of the program as text; alternatively `data`."""
    data: str
    """Content of the program in base64; alternatively `text`."""
    replace: bool
    """Replaces a program of the same name; if false, a taken name is refused; default true."""

class ProgramPutResult(TypedDict):
    """Result of a method."""

    name: str
    bytes: float

class ProgramListParams(TypedDict):
    """Parameters of a method."""

class ProgramListResultProgramsItem(TypedDict):
    """Part of a message."""

    name: str
    bytes: float
    modified: float
    format: Union[str, None]

class ProgramListResult(TypedDict):
    """Result of a method."""

    programs: list[ProgramListResultProgramsItem]

class ProgramGetParams(TypedDict):
    """Parameters of a method."""

    name: str
    """Name of the program."""

class ProgramGetResult(TypedDict):
    """Result of a method."""

    name: str
    format: Union[str, None]
    data: str

class _ProgramConvertParams(TypedDict):
    name: str
    """Name of the program."""
    to: str
    """Name of the new program; its extension selects the format: .plan.json, .playback, .svg, .png, .csv."""

class ProgramConvertParams(_ProgramConvertParams, total=False):
    """Parameters of a method."""

    setup: Setup
    """Options of drawing and engraving: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset for all other options; without `setup` the program runs unchanged."""
    replace: bool
    """Replaces a program of the same name; if false, a taken name is refused; default true."""

class ProgramConvertResultNotesItem(TypedDict):
    """Part of a message."""

    code: str
    text: str
    template: str

_ProgramConvertResultWords = TypedDict(
    "_ProgramConvertResultWords",
    {"from": "str", },
)

class ProgramConvertResult(_ProgramConvertResultWords):
    """Result of a method."""

    to: str
    steps: float
    lost: list[str]
    notes: list[ProgramConvertResultNotesItem]

class _ProgramOptionsParams(TypedDict):
    format: str
    """Format, as in `program.list`."""

class ProgramOptionsParams(_ProgramOptionsParams, total=False):
    """Parameters of a method."""

    all: bool
    """Lists all applicable options, not only the usual ones."""

class ProgramOptionsResult(TypedDict):
    """Result of a method."""

    options: list[Option]

class ProgramDeleteParams(TypedDict):
    """Parameters of a method."""

    name: str
    """Name of the program."""

class _PresetSaveParams(TypedDict):
    name: str
    """Name of the preset: letters, digits, - and _."""

class PresetSaveParams(_PresetSaveParams, total=False):
    """Parameters of a method."""

    setup: Setup
    """Options of the preset, as for `job.check`; alternatively `text`."""
    note: str
    """Note for users of the preset; with `setup`."""
    text: str
    """Preset file, TOML; alternatively `setup`."""

class PresetListParams(TypedDict):
    """Parameters of a method."""

class PresetListResult(TypedDict):
    """Result of a method."""

    presets: list[Preset]

class PresetShowParams(TypedDict):
    """Parameters of a method."""

    name: str
    """Name of the preset: letters, digits, - and _."""

class PresetRemoveParams(TypedDict):
    """Parameters of a method."""

    name: str
    """Name of the preset: letters, digits, - and _."""

class SurfaceTouchParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    add: bool
    """Adds this touch to the earlier ones; from three touches on the surface is a tilted plane."""
    forget: bool
    """Forgets the measured surface and sheet instead of measuring."""
    unhomed: bool
    """Accepts an arm not known to be homed: it may act in the wrong place."""

class _SurfaceCornerParams(TypedDict):
    corner: Literal["lower-left", "lower-right", "upper-left"]
    """Corner of the sheet, as its reader sees it."""

class SurfaceCornerParams(_SurfaceCornerParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    unhomed: bool
    """Accepts an arm not known to be homed: it may act in the wrong place."""

class SurfaceGetParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class TeachCaptureParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    by: Literal["joint", "linear", "jump"]
    """Path to the step; default joint."""
    unhomed: bool
    """Accepts an arm not known to be homed: it may act in the wrong place."""

class TeachCaptureResult(TypedDict):
    """Result of a method."""

    step: PlanStep

class _TeachGuideParams(TypedDict):
    on: bool
    """True to begin; ends with the lease as well."""

class TeachGuideParams(_TeachGuideParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    unhomed: bool
    """Accepts an arm not known to be homed: it may act in the wrong place."""

class TeachRowsParams(TypedDict):
    """Parameters of a method."""

    plan: Plan
    """A plan, as in plan files."""

class TeachRowsResult(TypedDict):
    """Result of a method."""

    title: str
    tool: Union[str, list[float], None]
    surface: Union[Surface, None]
    rows: list[Row]

class TeachOutputParams(TypedDict):
    """Parameters of a method."""

    address: int
    """EIO address of the pin."""
    high: bool
    """True for high."""

class TeachOutputResult(TypedDict):
    """Result of a method."""

    step: PlanStep

class _TeachPlanParams(TypedDict):
    rows: list[GivenRow]
    """Rows, as from `teach.rows`."""

class TeachPlanParams(_TeachPlanParams, total=False):
    """Parameters of a method."""

    title: str
    """Title of the plan."""
    tool: Union[Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]], None]
    """Tool whose tip reaches the points."""
    surface: Union[Surface, None]
    """Work surface, as in plan files."""

class TeachPlanResult(TypedDict):
    """Result of a method."""

    plan: Plan
    first: list[float]

class WorldLookParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    mark: str
    """`mark` of an earlier answer: `drawing` and `strokes` are null while the drawing is unchanged."""

class WorldLookResultObjectsItem(TypedDict):
    """Part of a message."""

    name: str
    at: list[float]
    turn: float
    size: list[float]
    color: str
    held: bool

class WorldLookResultTable(TypedDict):
    """Part of a message."""

    height: float
    x: list[float]
    y: list[float]

class WorldLookResultBelt(TypedDict):
    """Part of a message."""

    start: list[float]
    direction: float
    length: float
    width: float
    height: float
    travel: float

class WorldLookResultStrokesItem(TypedDict):
    """Part of a message."""

    burnt: bool
    power: float
    points: list[list[float]]

class WorldLookResult(TypedDict):
    """Result of a method."""

    objects: list[WorldLookResultObjectsItem]
    title: Union[str, None]
    table: Union[WorldLookResultTable, None]
    draws: Union[str, None]
    belt: Union[WorldLookResultBelt, None]
    drawing: Union[str, None]
    strokes: Union[list[WorldLookResultStrokesItem], None]
    mark: str
    unlocked: bool
    plugged: bool

class WorldScenariosParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class WorldScenariosResultScenariosItem(TypedDict):
    """Part of a message."""

    name: str
    title: str
    text: str

class WorldScenariosResult(TypedDict):
    """Result of a method."""

    scenarios: list[WorldScenariosResultScenariosItem]

class WorldPressParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    long: bool
    """Holds the key, which homes the arm."""

class _WorldUnlockParams(TypedDict):
    held: bool
    """True to hold, false to release."""

class WorldUnlockParams(_WorldUnlockParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldUnplugParams(TypedDict):
    plugged: bool
    """True to plug in, false to unplug."""

class WorldUnplugParams(_WorldUnplugParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldGuideParams(TypedDict):
    joints: list[float]
    """Target joint angles, deg; clamped to the limits."""

class WorldGuideParams(_WorldGuideParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldScenarioParams(TypedDict):
    text: str
    """A scenario, TOML."""

class WorldScenarioParams(_WorldScenarioParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class WorldScenarioResult(TypedDict):
    """Result of a method."""

    objects: list[str]

class _WorldPlaceParams(TypedDict):
    name: str
    """Name of the object."""
    at: list[float]
    """X, y, z of the centre of its underside, mm; it falls onto the surface below."""

class WorldPlaceParams(_WorldPlaceParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class WorldPaperParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldInputParams(TypedDict):
    address: int
    """EIO address."""

class WorldInputParams(_WorldInputParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    level: bool
    """True for high; alternatively `value`."""
    value: int
    """Voltage in counts, 4095 at 3.3 V; alternatively `level`."""

class _WorldFaultParams(TypedDict):
    fault: Literal["alarm", "slip", "reset"]
    """Fault: an alarm, a slipping joint, or a reset of the controller."""

class WorldFaultParams(_WorldFaultParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    alarm: int
    """Code of the alarm."""
    joint: int
    """Slipping joint; default 1."""
    degrees: float
    """Angle of the slip, deg."""

class RecordStartParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    rate: int
    """Readings per second; default 20."""

class RecordStartResult(TypedDict):
    """Result of a method."""

    name: str

class RecordStopParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class RecordStopResult(TypedDict):
    """Result of a method."""

    name: str
    seconds: float
    bytes: float

class _RecordSaveLastParams(TypedDict):
    seconds: float
    """Length of the recording, s."""

class RecordSaveLastParams(_RecordSaveLastParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class RecordSaveLastResult(TypedDict):
    """Result of a method."""

    name: str

class _MotionForwardParams(TypedDict):
    joints: list[float]
    """Joint angles, deg."""

class MotionForwardParams(_MotionForwardParams, total=False):
    """Parameters of a method."""

    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """Tool whose tip the pose refers to, or offset of the tip from the flange (mm); default none."""

class MotionForwardResult(TypedDict):
    """Result of a method."""

    x: float
    y: float
    z: float
    r: float

class _MotionInverseParams(TypedDict):
    pose: list[float]
    """X, y, z (mm) and r (deg)."""

class MotionInverseParams(_MotionInverseParams, total=False):
    """Parameters of a method."""

    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """Tool whose tip the pose refers to, or offset of the tip from the flange (mm); default none."""

class MotionInverseResult(TypedDict):
    """Result of a method."""

    j1: float
    j2: float
    j3: float
    j4: float

class _MotionReachParams(TypedDict):
    z: float
    """Height of the tip, mm."""

class MotionReachParams(_MotionReachParams, total=False):
    """Parameters of a method."""

    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """Tool whose tip the pose refers to, or offset of the tip from the flange (mm); default none."""

class MotionReachResult(TypedDict):
    """Result of a method."""

    outlines: list[list[list[float]]]

class ClassSetParams(TypedDict, total=False):
    """Parameters of a method."""

    text: str
    """Class file, TOML; empty text ends the class; alternatively `names`."""
    names: list[str]
    """Pupils of a class without groups; all other rules are kept; alternatively `text`."""
    arms: list[str]
    """With `names`: arms available to the pupils; default all."""
    turn_s: int
    """With `names`: length of a turn, s; 0 for unlimited turns; default unchanged."""
    offset: str
    """With `names`: offset of local time from UTC, such as `+01:00`; default unchanged."""
    use_codes: bool
    """Replaces existing codes and PIN by those of the file."""
    elsewhere: bool
    """Accepts arms of other stations of the site; otherwise an unknown arm is an error."""

class ClassGetParams(TypedDict):
    """Parameters of a method."""

class ClassCodesParams(TypedDict, total=False):
    """Parameters of a method."""

    pupils: list[str]
    """Names of pupils; default all."""

class ClassFreezeParams(TypedDict, total=False):
    """Parameters of a method."""

    arms: list[str]
    """Names of arms; default all."""

class ClassFreezeResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class ClassFreeParams(TypedDict, total=False):
    """Parameters of a method."""

    arms: list[str]
    """Names of arms; default all."""

class ClassFreeResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class ClassSendParams(TypedDict, total=False):
    """Parameters of a method."""

    program: str
    """Name of a program in the library; alternatively `text` or `data`."""
    text: str
    """Content of the program as text; alternatively `data`."""
    data: str
    """Content of the program in base64; alternatively `text`."""
    format: str
    """Format, as in `job.start`."""
    setup: Setup
    """Options, as in `job.start`."""
    arms: list[str]
    """Names of arms; default all."""
    yes: bool
    """Confirms that it may burn."""

class ClassSendResultJobsItem(TypedDict):
    """Part of a message."""

    arm: str
    job: Union[str, None]
    state: Union[str, None]
    error: Union[str, None]

class ClassSendResult(TypedDict):
    """Result of a method."""

    jobs: list[ClassSendResultJobsItem]

class ClassResultsParams(TypedDict):
    """Parameters of a method."""

class ClassResultsResultResultsItem(TypedDict):
    """Part of a message."""

    job: str
    pupil: str
    group: Union[str, None]
    title: str
    arm: str
    time: str
    time_local: str
    drawn_mm: Union[float, None]
    svg: str

class ClassResultsResult(TypedDict):
    """Result of a method."""

    results: list[ClassResultsResultResultsItem]

class TurnJoinParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm; default: any arm of the group, or any arm."""
    group: str
    """Group whose arms are requested; default: the pupil's group."""

class TurnLeaveParams(TypedDict, total=False):
    """Parameters of a method."""

    person: str
    """Person, for teachers; default: the caller."""

class TurnEndParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm; alternatively `arms`."""
    arms: list[str]
    """Names of arms; default all."""

class TurnEndResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class TurnNextParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm; alternatively `arms`."""
    arms: list[str]
    """Names of arms; default all."""

class TurnNextResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class TurnListParams(TypedDict, total=False):
    """Parameters of a method."""

    group: str
    """As for `turn.join`: selects the arms in `you`."""

class _ScheduleSetParams(TypedDict):
    text: str
    """Schedule, TOML; empty text removes all limits."""

class ScheduleSetParams(_ScheduleSetParams, total=False):
    """Parameters of a method."""

    elsewhere: bool
    """Accepts arms of other stations of the site; otherwise an unknown arm is an error."""

_ScheduleSetResultSlotsItemWords = TypedDict(
    "_ScheduleSetResultSlotsItemWords",
    {"from": "float", },
)

class ScheduleSetResultSlotsItem(_ScheduleSetResultSlotsItemWords):
    """Part of a message."""

    arms: list[str]
    who: list[str]
    days: Union[list[str], None]
    until: float

class ScheduleSetResult(TypedDict):
    """Result of a method."""

    text: str
    slots: list[ScheduleSetResultSlotsItem]
    now: float
    error: Union[str, None]

class ScheduleGetParams(TypedDict):
    """Parameters of a method."""

_ScheduleGetResultSlotsItemWords = TypedDict(
    "_ScheduleGetResultSlotsItemWords",
    {"from": "float", },
)

class ScheduleGetResultSlotsItem(_ScheduleGetResultSlotsItemWords):
    """Part of a message."""

    arms: list[str]
    who: list[str]
    days: Union[list[str], None]
    until: float

class ScheduleGetResult(TypedDict):
    """Result of a method."""

    text: str
    slots: list[ScheduleGetResultSlotsItem]
    now: float
    error: Union[str, None]

class SiteRosterParams(TypedDict):
    """Parameters of a method."""

class SiteRosterResult(TypedDict):
    """Result of a method."""

    arms: list[ExpectedArm]

class SiteExpectParams(TypedDict):
    """Parameters of a method."""

    arms: list[ExpectedArm]
    """All expected arms, at most 10,000."""

class SiteExpectResult(TypedDict):
    """Result of a method."""

    arms: list[ExpectedArm]

class SessionChangedNotification(TypedDict):
    """Parameters of a notification."""

    sessions: list[Session]
    """All sessions."""

class LeaseChangedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    holder: Union[Holder, None]
    """Current holder; null: the arm is free."""

class LeaseAskedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    session: str
    """Session that asks, for `lease.answer`."""
    name: str
    """Name of the session."""
    message: Union[str, None]
    """Message of the session; null: no message."""

class LeaseQueueNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    place: int
    """Place in the queue, from 1."""

class JobChangedNotification(TypedDict):
    """Parameters of a notification."""

    job: Job
    """The whole job, as from `job.get`."""

class JogEndedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    jog: str
    """Id of the jog."""
    why: Literal["released", "not-kept", "stopped", "lease", "link", "replaced", "limit"]
    """Reason of the end: stopped by its session, or the session ended; hold time expired; the arm was stopped; the lease ended; the line broke; replaced by another jog of the session; a limit or the fence was reached."""

class SurfaceChangedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    surface: MeasuredSurface
    """Measured surface, as from `surface.get`."""

class ArmStateNotification(TypedDict):
    """Parameters of a notification."""

    subscription: int
    """Id of the subscription of this socket."""
    state: StateChange
    """Changes to merge into the last state."""

class ServerEndingNotification(TypedDict):
    """Parameters of a notification."""

    left_s: float
    """Time left, s."""

class TurnChangedNotificationArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """Id of the job."""
    title: Union[str, None]
    """Title; null: no title."""
    person: Union[str, None]
    """Owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """Reason for waiting: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is frozen; schedule: no slot of its owner is open; turn: another person's turn; busy: the arm moves, or its lease is taken; lost: the line to the arm is lost; null: only the jobs before it."""

class TurnChangedNotificationArmsItemSlot(TypedDict):
    """Open slot of the schedule; null: free for all, or no slot is open."""

    who: list[str]
    """Who may acquire the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """End, Unix time, s; null: unlimited."""

class TurnChangedNotificationArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Name of the arm."""
    person: Union[str, None]
    """Person whose turn it is; null: no turn."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: the person is away; suspended: a teacher has the arm; null: no turn."""
    left_s: Union[float, None]
    """Time left in the turn, s; null: unlimited, or no turn."""
    frozen: bool
    """True if a teacher has frozen the arm."""
    jobs: list[TurnChangedNotificationArmsItemJobsItem]
    """Jobs queued for the arm, in order."""
    slot: Union[TurnChangedNotificationArmsItemSlot, None]
    """Open slot of the schedule; null: free for all, or no slot is open."""
    free_at: Union[float, None]
    """Begin of the next slot, Unix time, s; null: available now, or no slot is known."""

_TurnChangedNotificationQueueItemWords = TypedDict(
    "_TurnChangedNotificationQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnChangedNotificationQueueItem(_TurnChangedNotificationQueueItemWords):
    """Part of a message."""

    place: int
    """Place, from 1."""
    person: str
    """Person that waits."""
    arms: list[str]
    """Acceptable arms."""
    missed: bool
    """True if a turn came while the person was away."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """Reason for waiting: no slot of the person is open, all acceptable arms are frozen, or the person is away; null: only the persons before it."""

class TurnChangedNotification(TypedDict):
    """Parameters of a notification."""

    turn_s: Union[float, None]
    """Length of a turn; 0 for unlimited turns, s; null: there are no turns."""
    arms: list[TurnChangedNotificationArmsItem]
    """Arms of the station."""
    queue: list[TurnChangedNotificationQueueItem]
    """Waiting persons, in order."""

class TurnEndingNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    person: str
    """Person whose turn it is."""
    left_s: float
    """Time left, s."""

class TurnGrantedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    lease: str
    """Id of the lease, for `lease.release`."""
    ttl_s: float
    """Lease timeout: the lease ends if the holder sends nothing for this long, s."""
    left_s: Union[float, None]
    """Time left in the turn, s; null: the turn is unlimited."""

Event = Union[AlarmRaisedEvent, AlarmClearedEvent, CommandFinishedEvent, UnaccountedEvent, LinkLostEvent, LinkFoundEvent, ResetEvent, MissedEvent, HandTriggerEvent, StopEvent, LeaseEvent, JobEvent, JogEvent, RecordingSavedEvent, RecordingLostEvent]
Fields = dict[str, Union[float, str, bool, list[Union[float, str, dict[str, float]]]]]
PlanOrigin = list[int]
PlanName = Union[str, int]
PlanStep = Union[PlanStepMove, PlanStepJoints, PlanStepShift, PlanStepArc, PlanStepPath, PlanStepBurn, PlanStepSuction, PlanStepGripper, PlanStepLaser, PlanStepPart, PlanStepPause, PlanStepWait, PlanStepHome, PlanStepCommand]
ArmStateResult = State
ArmUnsubscribeResult = None
ArmGetResult = Fields
ArmSetResult = None
ArmMoveResult = Union[State, ArmMoveResultItem]
ArmHomeResult = State
ArmClearAlarmsResult = State
ArmToolResult = State
ArmSpeedResult = None
LeaseAcquireResult = Lease
LeaseRenewResult = None
LeaseReleaseResult = None
LeaseAnswerResult = None
LeaseTakeResult = Lease
JogStepResult = State
JobCheckResult = Report
JobGetResult = Job
JobPauseResult = Job
JobResumeResult = Job
JobStopResult = Job
JobReorderResult = Job
JobDeleteResult = None
ProgramDeleteResult = None
PresetSaveResult = Preset
PresetShowResult = Preset
PresetRemoveResult = None
SurfaceTouchResult = MeasuredSurface
SurfaceCornerResult = MeasuredSurface
SurfaceGetResult = MeasuredSurface
TeachGuideResult = None
WorldPressResult = None
WorldUnlockResult = None
WorldUnplugResult = None
WorldGuideResult = State
WorldPlaceResult = None
WorldPaperResult = None
WorldInputResult = None
WorldFaultResult = None
ClassSetResult = Class
ClassGetResult = Class
ClassCodesResult = Class
TurnJoinResult = TurnList
TurnLeaveResult = None
TurnListResult = TurnList
ArmEventNotification = Event
