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
    """The state of an arm, as it was read last."""

    t: float
    """When the pose was read, by the station's clock, Unix seconds."""
    arm: str
    """Name of the arm."""
    x: float
    """The tip of the tool, mm."""
    y: float
    """The tip of the tool, mm."""
    z: float
    """The tip of the tool, mm."""
    r: float
    """The turn of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""
    rail: Union[float, None]
    """Where the arm stands on its rail, mm; null: it has no rail."""
    current_index: int
    """The command of the arm's queue that was finished last."""
    left_space: int
    """Places in the arm's queue that are free; 0: it is full, and the station waits. A queue that is empty has as many as the firmware has places, 32 in the virtual arm, commands."""
    alarms: list[int]
    """Codes of the alarms that stand; `arm.alarms` explains them."""
    link: Literal["up", "lost"]
    """The line to the arm."""
    moving: bool
    """Whether it moves, or may."""
    homed: Union[bool, None]
    """Whether it was homed since it was switched on; false: it says that it was reset, and was not homed since; null: not known: it says nothing of a reset, and this computer saw no homing."""
    tool: Tool
    """What its tools do."""
    speed: Union[float, None]
    """Share of the set speed of moves, percent; null: not known: it was neither read nor set since the line was found."""
    pins: list[Pin]
    """The pins that some subscriber of the arm has asked for; none otherwise."""
    job: Union[str, None]
    """The job that it is at; null: none: none was started, or the last one is over."""
    jog: Union[str, None]
    """The jog that it is at; null: none."""
    holder: Union[Holder, None]
    """Who has the lease, and may move it; null: nobody has it."""

class Tool(TypedDict):
    """What the tools of an arm do, by the commands that went to it; null is not known."""

    name: Union[Literal["none", "suction", "gripper", "pen", "laser"], None]
    """The tool that is mounted; null: not known, or its tip is that of no tool with a name."""
    bias: Union[list[float], None]
    """Its tip from the flange, x, y, z, mm; null: not known."""
    suction: Union[bool, None]
    """Whether the suction cup is on; null: not known."""
    gripper: Union[Literal["open", "closed", "off"], None]
    """The gripper; off: its pump is off; null: not known."""
    laser: Union[bool, None]
    """Whether the laser may burn: the last command that is known lets it; null: not known."""

class Pin(TypedDict):
    """The level of a pin that is watched."""

    kind: Literal["input", "output", "analog"]
    """How it is read."""
    address: int
    """Its EIO address, 1 to 20."""
    value: int
    """0 or 1; of an analog input counts, 4095 at 3.3 V."""

class Holder(TypedDict):
    """A session that has the lease of an arm."""

    session: str
    """Its id."""
    name: str
    """What it calls itself."""

class Pose(TypedDict):
    """Where an arm is."""

    x: float
    """The tip of the tool, mm."""
    y: float
    """The tip of the tool, mm."""
    z: float
    """The tip of the tool, mm."""
    r: float
    """The turn of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""

class LibraryUse(TypedDict):
    """Room in the library of programs."""

    programs: int
    """Number of programs."""
    bytes: int
    """Their bytes, bytes."""

class Stood(TypedDict):
    """An arm that stands after a stop."""

    arm: str
    """Its name."""
    stood: bool
    """True: two readings were equal."""
    pose: Pose
    """Where it stands."""

class Lease(TypedDict):
    """A lease that was given."""

    arm: str
    """Name of the arm."""
    lease: str
    """Its id, for `lease.renew` and `lease.release`."""
    ttl_s: float
    """It ends when its holder says nothing for so long, s."""

class Session(TypedDict):
    """A session of the station."""

    session: str
    """Its id."""
    name: str
    """What it calls itself."""
    role: Literal["viewer", "student", "teacher"]
    """What it may do."""
    leases: list[str]
    """The arms whose lease it has."""
    since: float
    """When it said hello, Unix seconds."""

class Job(TypedDict):
    """A job, also one that is over."""

    job: str
    """Its id, never used twice."""
    arm: str
    """Name of the arm."""
    title: Union[str, None]
    """What its program is called; null: it is not read yet, or has no title."""
    state: Literal["queued", "checking", "running", "pausing", "paused", "stopping", "done", "stopped", "failed", "interrupted"]
    """What it does; from `done` on it is over."""
    step: int
    """Steps of loop `loop` that the arm has finished; the pair never goes back."""
    steps: Union[int, None]
    """Steps of one loop; null: it is not read yet."""
    first_step: Union[int, None]
    """The step that it began with, from 1; null: it is not read yet."""
    loops: int
    """How often it is done; 0 until it is stopped."""
    loop: int
    """The loop under way, from 1."""
    seconds_left: Union[float, None]
    """How long the rest takes, s; null: not known, or without end."""
    drawn_mm: Union[float, None]
    """Length of what it drew or burnt, mm; null: it is not done."""
    travel_mm: Union[float, None]
    """Length of the moves between, mm; null: it is not done."""
    started: Union[float, None]
    """When it began, Unix seconds; null: it waits in the queue."""
    ended: Union[float, None]
    """When it was over, Unix seconds; null: it is not over."""
    holder: Union[Holder, None]
    """Whose it is; null: not known."""
    part: Union[int, None]
    """The part that comes next, from 1; null: it does not wait between parts."""
    reason: Union[Literal["person", "part", "program", "stopped", "yes", "restart", "unkept"], None]
    """Of a `paused` job: `person`: somebody asked for it, or the lease ended; `part`: a part is done; `program`: the program says so. Of a `queued` job that does not begin by itself: `stopped`: the arm was stopped, `job.resume` lets it go on; `yes`: it may burn or is dangerous, and waits for `job.resume` with `yes` by who may; `restart`: the station was started anew, and `unkept`: the disk did not take its start, `job.resume` lets both go on; null: neither."""
    text: Union[str, None]
    """What the person at the arm is to do before it goes on; null: nothing is said."""
    place: Union[int, None]
    """Its place in the queue of its arm, from 1; null: it does not wait."""
    error: Union[JobError, None]
    """Why it failed or was interrupted; null: it has not failed."""
    notes: Union[list[Note], None]
    """What it has left switched on, and grips of a virtual arm that took nothing; null: nothing."""

class _JobError(TypedDict):
    message: str
    """What is wrong, in a sentence."""

_JobErrorWords = TypedDict(
    "_JobErrorWords",
    {"from": "int", }, total=False,
)

class JobError(_JobErrorWords, _JobError, total=False):
    """Why a job failed: `data` of the error, and its message."""

    kind: str
    """A kind of the table of errors."""
    code: str
    """Which error it is: programs decide by it, never by the message."""
    param: str
    """The parameter that is wrong."""
    row: int
    """The row of `teach.plan` that is wrong, from 1."""
    method: str
    """The method that helps, or that is meant."""
    command: str
    """The command of the protocol."""
    danger: Literal["laser", "arm"]
    """What `yes` is needed for."""
    step: int
    """The step of a program, from 1."""
    value: float
    """What was asked for."""
    limit: float
    """What is possible, or how many there may be."""
    unit: str
    """The unit of both."""
    fence: str
    """The part of the fence that it would break."""
    to: int
    """The last index or step in doubt."""
    remedies: list[Remedy]
    """What to do about it."""
    template: str
    """The sentence with the names of its values in braces: its identity in other languages."""
    values: list[SentenceValue]
    """The values in the sentence."""
    report: Report
    """What the check of a program found."""
    expected: Pose
    """Where the arm should stand."""
    pose: Pose
    """Where it stands."""
    arm: str
    """The arm that is frozen, or that the schedule keeps."""
    until: Union[float, None]
    """Until when the schedule keeps it, Unix time, s; null: it is not known."""
    arms: list[Stood]
    """The arms that stand all the same."""
    role: Literal["viewer", "student", "teacher"]
    """The role of the session."""
    needs: Literal["viewer", "student", "teacher"]
    """The role that is needed."""
    may: list[Literal["owner", "holder", "teacher"]]
    """Who may change a job that waits: its owner, the holder of the lease, a teacher."""
    wait_s: float
    """How long wrong codes have to wait, s."""
    quota: LibraryUse
    """The quota of the library that is used up."""
    used: LibraryUse
    """What is used of it."""
    holder: Union[Holder, None]
    """Who has the lease; null: nobody has it."""
    free_in_s: float
    """When the lease of a holder without a socket ends, s."""
    reason: Literal["unkept"]
    """The disk did not take it."""
    by: Union[str, None]
    """Whose stop it was; null: not a session's."""
    job: str
    """The job that has the arm."""
    jog: str
    """The jog that has the arm."""
    recording: str
    """The recording that is under way."""

_ErrorDataWords = TypedDict(
    "_ErrorDataWords",
    {"from": "int", }, total=False,
)

class ErrorData(_ErrorDataWords, total=False):
    """`data` of an error. Which members there are depends on its kind: see the table of errors."""

    kind: str
    """A kind of the table of errors."""
    code: str
    """Which error it is: programs decide by it, never by the message."""
    param: str
    """The parameter that is wrong."""
    row: int
    """The row of `teach.plan` that is wrong, from 1."""
    method: str
    """The method that helps, or that is meant."""
    command: str
    """The command of the protocol."""
    danger: Literal["laser", "arm"]
    """What `yes` is needed for."""
    step: int
    """The step of a program, from 1."""
    value: float
    """What was asked for."""
    limit: float
    """What is possible, or how many there may be."""
    unit: str
    """The unit of both."""
    fence: str
    """The part of the fence that it would break."""
    to: int
    """The last index or step in doubt."""
    remedies: list[Remedy]
    """What to do about it."""
    template: str
    """The sentence with the names of its values in braces: its identity in other languages."""
    values: list[SentenceValue]
    """The values in the sentence."""
    report: Report
    """What the check of a program found."""
    expected: Pose
    """Where the arm should stand."""
    pose: Pose
    """Where it stands."""
    arm: str
    """The arm that is frozen, or that the schedule keeps."""
    until: Union[float, None]
    """Until when the schedule keeps it, Unix time, s; null: it is not known."""
    arms: list[Stood]
    """The arms that stand all the same."""
    role: Literal["viewer", "student", "teacher"]
    """The role of the session."""
    needs: Literal["viewer", "student", "teacher"]
    """The role that is needed."""
    may: list[Literal["owner", "holder", "teacher"]]
    """Who may change a job that waits: its owner, the holder of the lease, a teacher."""
    wait_s: float
    """How long wrong codes have to wait, s."""
    quota: LibraryUse
    """The quota of the library that is used up."""
    used: LibraryUse
    """What is used of it."""
    holder: Union[Holder, None]
    """Who has the lease; null: nobody has it."""
    free_in_s: float
    """When the lease of a holder without a socket ends, s."""
    reason: Literal["unkept"]
    """The disk did not take it."""
    by: Union[str, None]
    """Whose stop it was; null: not a session's."""
    job: str
    """The job that has the arm."""
    jog: str
    """The jog that has the arm."""
    recording: str
    """The recording that is under way."""

class Remedy(TypedDict, total=False):
    """Something that can be done about an error, one of `action`, `option`, `without` and `system`."""

    action: str
    """What to do, such as `home`, `clear-alarms`."""
    option: str
    """An option to give."""
    value: Union[float, bool, str, list[float]]
    """Its value; the person chooses it where there is none."""
    without: str
    """An option to leave out."""
    system: str
    """A command for a shell of the station's machine."""
    effect: str
    """What comes of it."""

class _SentenceValue(TypedDict):
    name: str
    """Its name in the template."""

class SentenceValue(_SentenceValue, total=False):
    """A value in a sentence, one of `text`, `option` and `template`."""

    text: str
    """A number or a quotation, as it is printed."""
    option: str
    """An option by its name, which a client calls as it likes."""
    template: str
    """Words that are a sentence of their own."""
    values: list[SentenceValue]
    """The values in those."""

class TurnsArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """The job."""
    title: Union[str, None]
    """Its title; null: it has none."""
    person: Union[str, None]
    """Its owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """What keeps it: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is; schedule: no slot of its owner is open; turn: somebody else's; busy: something moves the arm or has its lease; lost: the arm is; null: the jobs in front of it alone."""

class TurnsArmsItemSlot(TypedDict):
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""

    who: list[str]
    """Who may have the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """When it ends, Unix time, s; null: it has no end."""

class TurnsArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Its name."""
    person: Union[str, None]
    """Whose turn it is; null: nobody's."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: for somebody who is not there; suspended: a teacher has the arm; null: nobody's turn."""
    left_s: Union[float, None]
    """What is left of the turn, s; null: it has no end, or is nobody's."""
    frozen: bool
    """Whether a teacher has frozen the arm."""
    jobs: list[TurnsArmsItemJobsItem]
    """The jobs that wait for the arm, in order."""
    slot: Union[TurnsArmsItemSlot, None]
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""
    free_at: Union[float, None]
    """When the next slot begins, Unix time, s; null: the arm may be had now, or no slot is known."""

_TurnsQueueItemWords = TypedDict(
    "_TurnsQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnsQueueItem(_TurnsQueueItemWords):
    """Part of a message."""

    place: int
    """From 1."""
    person: str
    """Who waits."""
    arms: list[str]
    """The arms that will do."""
    missed: bool
    """Whether a turn came while the person was not there."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """What keeps it: no slot of the person is open, all its arms are frozen, or the person is not there; null: those in front of it alone."""

class Turns(TypedDict):
    """Whose turn it is in a class, and who waits."""

    turn_s: Union[float, None]
    """How long a turn is; 0 without end, s; null: there are no turns."""
    arms: list[TurnsArmsItem]
    """The arms of the station."""
    queue: list[TurnsQueueItem]
    """Who waits, in order."""

class TurnListArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """The job."""
    title: Union[str, None]
    """Its title; null: it has none."""
    person: Union[str, None]
    """Its owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """What keeps it: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is; schedule: no slot of its owner is open; turn: somebody else's; busy: something moves the arm or has its lease; lost: the arm is; null: the jobs in front of it alone."""

class TurnListArmsItemSlot(TypedDict):
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""

    who: list[str]
    """Who may have the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """When it ends, Unix time, s; null: it has no end."""

class TurnListArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Its name."""
    person: Union[str, None]
    """Whose turn it is; null: nobody's."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: for somebody who is not there; suspended: a teacher has the arm; null: nobody's turn."""
    left_s: Union[float, None]
    """What is left of the turn, s; null: it has no end, or is nobody's."""
    frozen: bool
    """Whether a teacher has frozen the arm."""
    jobs: list[TurnListArmsItemJobsItem]
    """The jobs that wait for the arm, in order."""
    slot: Union[TurnListArmsItemSlot, None]
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""
    free_at: Union[float, None]
    """When the next slot begins, Unix time, s; null: the arm may be had now, or no slot is known."""

_TurnListQueueItemWords = TypedDict(
    "_TurnListQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnListQueueItem(_TurnListQueueItemWords):
    """Part of a message."""

    place: int
    """From 1."""
    person: str
    """Who waits."""
    arms: list[str]
    """The arms that will do."""
    missed: bool
    """Whether a turn came while the person was not there."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """What keeps it: no slot of the person is open, all its arms are frozen, or the person is not there; null: those in front of it alone."""

class TurnListYou(TypedDict):
    """Who asks."""

    person: Union[str, None]
    """The name under which the asker takes turns; null: none."""
    arms: list[str]
    """The arms that `turn.join` without `arm` means."""

class _TurnList(TypedDict):
    turn_s: Union[float, None]
    """How long a turn is; 0 without end, s; null: there are no turns."""
    arms: list[TurnListArmsItem]
    """The arms of the station."""
    queue: list[TurnListQueueItem]
    """Who waits, in order."""

class TurnList(_TurnList, total=False):
    """Turns, and what they are for the asker."""

    you: TurnListYou
    """Who asks."""

class _ClientName(TypedDict):
    name: str
    """What it is called, 1 to 80 characters."""

class ClientName(_ClientName, total=False):
    """The program that says hello."""

    version: str
    """Its version, up to 80 characters."""

class Pupil(TypedDict):
    """A pupil of the class who signs in."""

    name: str
    """The name."""
    code: str
    """The pupil's code."""

class _ExpectedArm(TypedDict):
    arm: str
    """Its name."""

class ExpectedArm(_ExpectedArm, total=False):
    """An arm that is expected on a site."""

    machine: str
    """The machine of its station."""

class PinAddress(TypedDict):
    """A pin to watch."""

    kind: Literal["input", "output", "analog"]
    """How it is read."""
    address: int
    """Its EIO address, 1 to 20."""

class _Laser(TypedDict):
    on: bool
    """Whether it burns."""

class Laser(_Laser, total=False):
    """What the laser is to do."""

    power: float
    """0 to 100; a laser that stands burns at 100 or not at all: less is `unsupported`, percent."""

class Box(TypedDict):
    """A box with sides along the axes."""

    x: list[float]
    """Least and most, mm."""
    y: list[float]
    """Least and most, mm."""
    z: list[float]
    """Least and most, mm."""

class Fence(TypedDict):
    """Where an arm may be, how fast, and how strong its laser."""

    floor: Union[float, None]
    """The least z of the tip, mm; null: no bound."""
    box: Union[Box, None]
    """Where the tip has to be; null: no bound."""
    keep_out: list[Box]
    """Where it must not be."""
    speed: Union[float, None]
    """The highest speed, mm/s; null: no bound."""
    power: Union[float, None]
    """The highest power of the laser, percent; null: no bound."""

class FenceChange(TypedDict, total=False):
    """The members of a fence that become something else; null takes the bound away."""

    floor: Union[float, None]
    """The least z of the tip, mm; null: no bound."""
    box: Union[Box, None]
    """Where the tip has to be; null: no bound."""
    keep_out: Union[list[Box], None]
    """Where it must not be; null: nowhere."""
    speed: Union[float, None]
    """The highest speed, mm/s; null: no bound."""
    power: Union[float, None]
    """The highest power of the laser, percent; null: no bound."""

class _Surface(TypedDict):
    height: float
    """The z that the arm reports where the tool touches it, at x = y = 0, mm."""

class Surface(_Surface, total=False):
    """The surface that a plan works on."""

    slope: list[float]
    """How much higher it is for each mm in x and in y; level without it."""

class MeasuredSurface(TypedDict):
    """What is known of the work surface under an arm."""

    touches: int
    """How many touches it comes from; 0 while nothing is known."""
    plane: Union[Plane, None]
    """The surface; null: nothing is known."""
    residual: Union[float, None]
    """The largest distance of a touch from it, mm; null: nothing is known."""
    corners: list[Literal["lower-left", "lower-right", "upper-left"]]
    """Corners that were taken of a sheet that is not complete."""
    sheet: Union[MeasuredSheet, None]
    """The sheet of paper; null: none was measured."""

class Plane(TypedDict):
    """A plane, by a place of it."""

    at: list[float]
    """X and y of the place, mm."""
    z: float
    """The z that the arm reports where the tool touches it there, mm."""
    slope_x: float
    """How much higher it is for each mm in x."""
    slope_y: float
    """How much higher it is for each mm in y."""

class MeasuredSheet(TypedDict):
    """A sheet of paper as it lies before the arm."""

    corner: list[float]
    """X and y of its lower left corner, for its reader, mm."""
    rotation: float
    """From the arm's X to its lower edge, deg."""
    size: Union[list[float], None]
    """Width and height, mm; null: not known."""
    outline: list[list[float]]
    """Its four corners, from the lower left one against the clock, mm."""

class Row(TypedDict):
    """A row of the table of a plan: where the arm goes, what its tool does there, how long it stays."""

    name: str
    """What the row is called."""
    motion: Union[PlanStep, None]
    """A step as in plan files; null: it stays where it is."""
    gripper: Union[Literal["off", "open", "close"], None]
    """What the gripper does; null: nothing."""
    suction: Union[bool, None]
    """The suction cup; null: nothing."""
    wait: Union[float, None]
    """How long it stays, s; null: not at all."""

class GivenRow(TypedDict, total=False):
    """A row for `teach.plan`: as Row, and a member that is null may be missing."""

    name: str
    """What the row is called."""
    motion: Union[PlanStep, None]
    """A step as in plan files; null: it stays where it is."""
    gripper: Union[Literal["off", "open", "close"], None]
    """What the gripper does; null: nothing."""
    suction: Union[bool, None]
    """The suction cup; null: nothing."""
    wait: Union[float, None]
    """How long it stays, s; null: not at all."""

class _StateChange(TypedDict):
    t: float
    """When the pose was read, by the station's clock, Unix seconds."""

class StateChange(_StateChange, total=False):
    """A State, or what of it is other than in the last one: each member that is there takes the place of the one before, whole."""

    arm: str
    """Name of the arm."""
    x: float
    """The tip of the tool, mm."""
    y: float
    """The tip of the tool, mm."""
    z: float
    """The tip of the tool, mm."""
    r: float
    """The turn of the tool, deg."""
    j1: float
    """Joint 1, the base, deg."""
    j2: float
    """Joint 2, the rear arm, deg."""
    j3: float
    """Joint 3, the forearm, deg."""
    j4: float
    """Joint 4, the tool, deg."""
    rail: Union[float, None]
    """Where the arm stands on its rail, mm; null: it has no rail."""
    current_index: int
    """The command of the arm's queue that was finished last."""
    left_space: int
    """Places in the arm's queue that are free; 0: it is full, and the station waits. A queue that is empty has as many as the firmware has places, 32 in the virtual arm, commands."""
    alarms: list[int]
    """Codes of the alarms that stand; `arm.alarms` explains them."""
    link: Literal["up", "lost"]
    """The line to the arm."""
    moving: bool
    """Whether it moves, or may."""
    homed: Union[bool, None]
    """Whether it was homed since it was switched on; false: it says that it was reset, and was not homed since; null: not known: it says nothing of a reset, and this computer saw no homing."""
    tool: Tool
    """What its tools do."""
    speed: Union[float, None]
    """Share of the set speed of moves, percent; null: not known: it was neither read nor set since the line was found."""
    pins: list[Pin]
    """The pins that some subscriber of the arm has asked for; none otherwise."""
    job: Union[str, None]
    """The job that it is at; null: none: none was started, or the last one is over."""
    jog: Union[str, None]
    """The jog that it is at; null: none."""
    holder: Union[Holder, None]
    """Who has the lease, and may move it; null: nobody has it."""

class AlarmRaisedEvent(TypedDict):
    """An alarm stands."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["alarm-raised"]
    code: int
    """Of the alarm; `arm.alarms` explains those that stand."""

class AlarmClearedEvent(TypedDict):
    """An alarm does not stand any more."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["alarm-cleared"]
    code: int
    """Of the alarm; `arm.alarms` explains those that stand."""

class CommandFinishedEvent(TypedDict):
    """The arm has finished commands of its queue."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["command-finished"]
    index: int
    """The last one."""

class UnaccountedEvent(TypedDict):
    """The arm's queue went on by commands that this station did not send."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["unaccounted"]
    index: int
    """The last one."""

class LinkLostEvent(TypedDict):
    """The line to the arm broke."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["link-lost"]

class LinkFoundEvent(TypedDict):
    """The arm answers again."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["link-found"]

class ResetEvent(TypedDict):
    """The arm was reset or switched on: its queue is empty, and its settings are those of power-up."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["reset"]

class MissedEvent(TypedDict):
    """The station could not follow: so many events were dropped."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["missed"]
    count: int
    """How many."""

class HandTriggerEvent(TypedDict):
    """The unlock key was released while `teach.guide` is on."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["hand-trigger"]
    step: PlanStep
    """A step that leads to where the arm was put."""

class StopEvent(TypedDict):
    """The arm was stopped. Stops within 50 ms of one that was told are not."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["stop"]
    by: Union[str, None]
    """Whose stop; null: the end of a lease."""

class LeaseEvent(TypedDict):
    """The lease has another holder."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["lease"]
    holder: Union[Holder, None]
    """Who has it now; null: nobody has it."""

class JobEvent(TypedDict):
    """A job has another state."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["job"]
    job: str
    """Which one."""
    state: Literal["queued", "checking", "running", "pausing", "paused", "stopping", "done", "stopped", "failed", "interrupted"]
    """Its state."""

class _JogEvent(TypedDict):
    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["jog"]
    jog: str
    """Which one."""

class JogEvent(_JogEvent, total=False):
    """A jog began (`axis`) or is over (`why`)."""

    axis: Literal["x+", "x-", "y+", "y-", "z+", "z-", "r+", "r-", "j1+", "j1-", "j2+", "j2-", "j3+", "j3-", "j4+", "j4-", "l+", "l-"]
    """Where it goes, at its beginning."""
    why: Literal["released", "not-kept", "stopped", "lease", "link", "replaced", "limit"]
    """Why it ended: its session stopped it or went away; it was not kept up; a stop of the arm came; the lease ended; the line broke; the same session began another one; the arm came to a limit or to its fence."""

class RecordingSavedEvent(TypedDict):
    """An alarm had the last minutes written into a file."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["recording-saved"]
    name: str
    """The file, for GET /api/v1/recordings/{name}."""
    bytes: int
    """Its length."""

class RecordingLostEvent(TypedDict):
    """A recording ended because its file could not be written."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number at this arm, from 1, for `events.since`."""
    t: float
    """When it happened, by the station's clock, Unix seconds."""
    event: Literal["recording-lost"]
    name: str
    """The file, for GET /api/v1/recordings/{name}."""
    message: str
    """Why."""

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
    """The program: `name`, and `version` if it has one."""

class SessionHelloParams(_SessionHelloParams, total=False):
    """Parameters of a method."""

    token: str
    """A token of the station."""
    pupil: Pupil
    """A pupil of the class signs in: `name` and `code`; instead of a token."""
    pin: str
    """The teacher's PIN of the class, on this machine; instead of a token."""
    resume: str
    """The secret of a session whose socket has ended."""
    role: Literal["viewer", "student", "teacher"]
    """The most that the session may do, where the token allows more."""

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
    """States a second."""

class ArmSubscribeParams(_ArmSubscribeParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    frame: Literal["json", "binary"]
    """The form of the states; json unless given."""
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
    """What the reading is asked for, by field."""

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
    """That it is meant: for what is dangerous or may burn."""

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
    """That it is meant: for what is dangerous or may burn."""

class ArmEnqueueResult(TypedDict):
    """Result of a method."""

    index: float

class _ArmMoveParams(TypedDict):
    to: list[float]
    """X, y, z (mm), r (deg), or four joints (deg); then the rail (mm) if there is one."""

class ArmMoveParams(_ArmMoveParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    by: Literal["joint", "linear", "jump"]
    """The path; joint unless given."""
    frame: Literal["xyz", "joints"]
    """What `to` counts in; xyz unless given."""
    relative: bool
    """Whether `to` counts from where the arm stands."""
    wait: bool
    """Whether the answer comes when the arm is there; yes unless given."""

class ArmMoveResultItem(TypedDict):
    """Part of a message."""

    index: float

class ArmHomeParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    yes: bool
    """That it is meant: for what is dangerous or may burn."""

class ArmClearAlarmsParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    yes: bool
    """That it is meant: for what is dangerous or may burn."""

class ArmToolParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """The tool that is mounted, or its tip from the flange (mm)."""
    suction: bool
    """The suction cup."""
    gripper: Literal["open", "closed", "off"]
    """The gripper."""
    laser: Laser
    """The laser: `on`, and `power` (percent), which is 100 where it stands."""
    yes: bool
    """That it is meant: for what is dangerous or may burn."""

class ArmSpeedParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    percent: float
    """Share of the set speeds of moves and jogs; or `row`."""
    row: str
    """A command of the protocol that holds speeds."""
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
    """The members to change: `floor` (mm), `box` {x, y, z: [least, most]} (mm), `keep_out` (boxes), `speed` (mm/s), `power` (percent), each or all null for no bound; for teachers."""

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
    """The last event that is known; 0 for all."""

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
    """How long to wait for it, s; 0 unless given: then, and when the time is over, it is refused with -32002."""

class LeaseRenewParams(TypedDict):
    """Parameters of a method."""

    lease: str
    """The lease."""

class LeaseReleaseParams(TypedDict):
    """Parameters of a method."""

    lease: str
    """The lease."""

class LeaseAskParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    message: str
    """A sentence for the holder."""

class _LeaseAskResult(TypedDict):
    granted: bool

class LeaseAskResult(_LeaseAskResult, total=False):
    """Result of a method."""

    lease: str
    ttl_s: float

class _LeaseAnswerParams(TypedDict):
    session: str
    """The session that asks."""
    grant: bool
    """Whether it gets the lease."""

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
    """Axis, joint or rail, and the direction."""

class JogStartParams(_JogStartParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    keep_ms: int
    """How long it goes on without being kept up, ms; 250 unless given."""
    percent: float
    """Share of the set jog speed."""

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
    """The jog; that of the arm unless given."""

class JogStopResult(TypedDict):
    """Result of a method."""

    stood: bool
    pose: Pose

class _JogStepParams(TypedDict):
    axis: Literal["x", "y", "z", "r", "j1", "j2", "j3", "j4", "l"]
    """Axis, joint or rail."""
    by: float
    """How far, with its sign: mm or deg."""

class JogStepParams(_JogStepParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    frame: Literal["base", "tool"]
    """The frame of x and y: base, or turned by r; base unless given."""
    percent: float
    """Share of the set speeds of moves."""

class JobCheckParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    program: str
    """A program of the library; or `text`, or `data`."""
    text: str
    """The program as text; or `data`."""
    data: str
    """The program's bytes in base64; or `text`."""
    format: str
    """Its type, where its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid."""
    setup: Setup
    """How it is drawn or engraved: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset that says the rest; without it the program is run as it is."""
    preview: bool
    """Whether `preview` has what it leaves: `{strokes: [{points, height, part, power, reachable}], travels}`, of no more than 20,000 points each; `part` is the number of one of `parts`, or null; `power` of the laser in percent, 100 of ink."""

_JobStartParamsWords = TypedDict(
    "_JobStartParamsWords",
    {"from": "int", }, total=False,
)

class JobStartParams(_JobStartParamsWords, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    program: str
    """A program of the library; or `text`, or `data`."""
    text: str
    """The program as text; or `data`."""
    data: str
    """The program's bytes in base64; or `text`."""
    format: str
    """Its type, where its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid."""
    setup: Setup
    """How it is drawn or engraved: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset that says the rest; without it the program is run as it is."""
    loops: int
    """How often; 0 until it is stopped, 1 unless given."""
    keep: bool
    """Whether what is in the queue is done first."""
    require_homed: bool
    """Whether an arm that was not homed is refused."""
    unhomed: bool
    """Takes an arm that is not known to be homed: perhaps in the wrong place."""
    yes: bool
    """That it is meant: for what is dangerous or may burn."""
    on_lost: Literal["pause", "stop", "continue"]
    """What becomes of it when the lease ends; pause unless given, continue without a session."""
    queue: bool
    """Whether it waits, without the lease, until the arm is free of jobs and of others' turns; then it is checked again."""
    after_check: bool
    """Whether the answer comes when the check is over; yes unless given."""
    key: str
    """A name of the caller's choice, such as a UUID: a second start with the same key starts nothing and answers as the first, also by a later server; with another program, `setup`, `loops`, `from`, `keep`, `require_homed` or `unhomed` it is refused. Each arm has its keys."""

class JobStartResult(TypedDict):
    """Result of a method."""

    job: str

class JobGetParams(TypedDict):
    """Parameters of a method."""

    job: str
    """The job."""

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
    """The job."""

class _JobResumeParams(TypedDict):
    job: str
    """The job."""

class JobResumeParams(_JobResumeParams, total=False):
    """Parameters of a method."""

    approach: bool
    """Whether the arm may have been moved since; yes unless given."""
    overlap: float
    """How far before the place where the light of a burn went out it begins, along its line, mm; 0 unless given."""
    yes: bool
    """That it is meant: for what is dangerous or may burn."""

class JobStopParams(TypedDict):
    """Parameters of a method."""

    job: str
    """The job."""

class JobHistoryParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    skip: int
    """So many of the newest are left out; 0 unless given."""
    limit: int
    """So many at most; 50 unless given."""

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
    """The job."""
    position: int
    """Its new `place`, from 1; more than there are is the last."""

class JobDeleteParams(TypedDict):
    """Parameters of a method."""

    job: str
    """The job."""

class _ProgramPutParams(TypedDict):
    name: str
    """The program."""

class ProgramPutParams(_ProgramPutParams, total=False):
    """Parameters of a method."""

    text: str
    """The program as text; or `data`."""
    data: str
    """The program's bytes in base64; or `text`."""

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
    """The program."""

class ProgramGetResult(TypedDict):
    """Result of a method."""

    name: str
    format: Union[str, None]
    data: str

class _ProgramConvertParams(TypedDict):
    name: str
    """The program."""
    to: str
    """The name of the new program, whose ending says what it becomes: .plan.json, .playback, .svg, .png, .csv."""

class ProgramConvertParams(_ProgramConvertParams, total=False):
    """Parameters of a method."""

    setup: Setup
    """How it is drawn or engraved: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset that says the rest; without it the program is run as it is."""

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
    """A format, as `program.list` has it."""

class ProgramOptionsParams(_ProgramOptionsParams, total=False):
    """Parameters of a method."""

    all: bool
    """Whether all options come that count for it, not only the usual ones."""

class ProgramOptionsResult(TypedDict):
    """Result of a method."""

    options: list[Option]

class ProgramDeleteParams(TypedDict):
    """Parameters of a method."""

    name: str
    """The program."""

class _PresetSaveParams(TypedDict):
    name: str
    """The preset: letters, digits, - and _."""

class PresetSaveParams(_PresetSaveParams, total=False):
    """Parameters of a method."""

    setup: Setup
    """What it says, as `job.check` takes it; or `text`."""
    note: str
    """What is told to people who use it; beside `setup`."""
    text: str
    """A file of a preset, TOML; or `setup`."""

class PresetListParams(TypedDict):
    """Parameters of a method."""

class PresetListResult(TypedDict):
    """Result of a method."""

    presets: list[Preset]

class PresetShowParams(TypedDict):
    """Parameters of a method."""

    name: str
    """The preset: letters, digits, - and _."""

class PresetRemoveParams(TypedDict):
    """Parameters of a method."""

    name: str
    """The preset: letters, digits, - and _."""

class SurfaceTouchParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    add: bool
    """Adds the touch to those before: from three on the plane through them is tilted as the table is."""
    forget: bool
    """Forgets what was measured, a sheet as well, instead of taking it."""
    unhomed: bool
    """Takes an arm that is not known to be homed: perhaps in the wrong place."""

class _SurfaceCornerParams(TypedDict):
    corner: Literal["lower-left", "lower-right", "upper-left"]
    """Which one it is, for the reader of the paper."""

class SurfaceCornerParams(_SurfaceCornerParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    unhomed: bool
    """Takes an arm that is not known to be homed: perhaps in the wrong place."""

class SurfaceGetParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class TeachCaptureParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    by: Literal["joint", "linear", "jump"]
    """How the step is reached; joint unless given."""
    unhomed: bool
    """Takes an arm that is not known to be homed: perhaps in the wrong place."""

class TeachCaptureResult(TypedDict):
    """Result of a method."""

    step: PlanStep

class _TeachGuideParams(TypedDict):
    on: bool
    """Whether it tells; it ends with the lease as well."""

class TeachGuideParams(_TeachGuideParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    unhomed: bool
    """Takes an arm that is not known to be homed: perhaps in the wrong place."""

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
    """The pin."""
    high: bool
    """Its level."""

class TeachOutputResult(TypedDict):
    """Result of a method."""

    step: PlanStep

class _TeachPlanParams(TypedDict):
    rows: list[GivenRow]
    """As `teach.rows` has them."""

class TeachPlanParams(_TeachPlanParams, total=False):
    """Parameters of a method."""

    title: str
    """What the plan is called."""
    tool: Union[Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]], None]
    """The tool whose tip is at the points."""
    surface: Union[Surface, None]
    """The surface that it works on, as in plan files."""

class TeachPlanResult(TypedDict):
    """Result of a method."""

    plan: Plan
    first: list[float]

class WorldLookParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    mark: str
    """The `mark` of an earlier look: while the drawing is the same, `drawing` and `strokes` are null."""

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
    """Whether the key is held: it homes the arm."""

class _WorldUnlockParams(TypedDict):
    held: bool
    """Whether it is held."""

class WorldUnlockParams(_WorldUnlockParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldUnplugParams(TypedDict):
    plugged: bool
    """Whether the cable is in."""

class WorldUnplugParams(_WorldUnplugParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class _WorldGuideParams(TypedDict):
    joints: list[float]
    """Where the joints are bent to, deg, as far as they go."""

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
    """The object."""
    at: list[float]
    """X, y, z of the middle of its underside, mm; it falls onto what is below."""

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
    """Whether it is high; or `value`."""
    value: int
    """Its voltage in counts, 4095 at 3.3 V."""

class _WorldFaultParams(TypedDict):
    fault: Literal["alarm", "slip", "reset"]
    """An alarm, a joint that slips, or a reset of the controller."""

class WorldFaultParams(_WorldFaultParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    alarm: int
    """Code of the alarm."""
    joint: int
    """The joint that slips; 1 unless given."""
    degrees: float
    """By how much, deg."""

class RecordStartParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""
    rate: int
    """Readings a second; 20 unless given."""

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
    """How far back, s."""

class RecordSaveLastParams(_RecordSaveLastParams, total=False):
    """Parameters of a method."""

    arm: str
    """Name of the arm."""

class RecordSaveLastResult(TypedDict):
    """Result of a method."""

    name: str

class _MotionForwardParams(TypedDict):
    joints: list[float]
    """The joints, deg."""

class MotionForwardParams(_MotionForwardParams, total=False):
    """Parameters of a method."""

    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """The tool whose tip is meant, or its tip from the flange (mm); none unless given."""

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
    """The tool whose tip is meant, or its tip from the flange (mm); none unless given."""

class MotionInverseResult(TypedDict):
    """Result of a method."""

    j1: float
    j2: float
    j3: float
    j4: float

class _MotionReachParams(TypedDict):
    z: float
    """The height of the tip, mm."""

class MotionReachParams(_MotionReachParams, total=False):
    """Parameters of a method."""

    tool: Union[Literal["none", "suction", "gripper", "pen", "laser"], list[float]]
    """The tool whose tip is meant, or its tip from the flange (mm); none unless given."""

class MotionReachResult(TypedDict):
    """Result of a method."""

    outlines: list[list[list[float]]]

class ClassSetParams(TypedDict, total=False):
    """Parameters of a method."""

    text: str
    """A class file, TOML; empty text ends the class; or `names`."""
    names: list[str]
    """The pupils of a class without groups, whose other rules are those of the class before; or `text`."""
    arms: list[str]
    """With `names`: the arms that they may have; all unless given."""
    turn_s: int
    """With `names`: how long a turn is, s, 0 for turns without end; as before unless given."""
    offset: str
    """With `names`: how far the clock on the wall is from UTC, such as `+01:00`; as before unless given."""
    use_codes: bool
    """That the codes and the PIN of the file count where the class before has others."""
    elsewhere: bool
    """That arms which this station has not are other stations' of its site, not mistakes."""

class ClassGetParams(TypedDict):
    """Parameters of a method."""

class ClassCodesParams(TypedDict, total=False):
    """Parameters of a method."""

    pupils: list[str]
    """Whose; of all unless given."""

class ClassFreezeParams(TypedDict, total=False):
    """Parameters of a method."""

    arms: list[str]
    """Names of arms; all unless given."""

class ClassFreezeResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class ClassFreeParams(TypedDict, total=False):
    """Parameters of a method."""

    arms: list[str]
    """Names of arms; all unless given."""

class ClassFreeResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class ClassSendParams(TypedDict, total=False):
    """Parameters of a method."""

    program: str
    """A program of the library; or `text`, or `data`."""
    text: str
    """The program as text; or `data`."""
    data: str
    """The program's bytes in base64; or `text`."""
    format: str
    """Its type, as in `job.start`."""
    setup: Setup
    """How it is drawn or engraved, as in `job.start`."""
    arms: list[str]
    """Names of arms; all unless given."""
    yes: bool
    """That it may burn."""

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
    """The arm; without it any of the group's, or any at all."""
    group: str
    """The group whose arms are meant; the pupil's own unless given."""

class TurnLeaveParams(TypedDict, total=False):
    """Parameters of a method."""

    person: str
    """Whose, for a teacher; the asker's own unless given."""

class TurnEndParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """The arm; or `arms`."""
    arms: list[str]
    """Names of arms; all unless given."""

class TurnEndResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class TurnNextParams(TypedDict, total=False):
    """Parameters of a method."""

    arm: str
    """The arm; or `arms`."""
    arms: list[str]
    """Names of arms; all unless given."""

class TurnNextResult(TypedDict):
    """Result of a method."""

    arms: list[str]

class TurnListParams(TypedDict, total=False):
    """Parameters of a method."""

    group: str
    """As for `turn.join`: whose arms are told in `you`."""

class _ScheduleSetParams(TypedDict):
    text: str
    """A schedule, TOML; empty text lets everybody in at any time."""

class ScheduleSetParams(_ScheduleSetParams, total=False):
    """Parameters of a method."""

    elsewhere: bool
    """That arms which this station has not are other stations' of its site, not mistakes."""

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
    """All arms that are expected from now on, 10,000 at most."""

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
    """Who has it now; null: nobody has it."""

class LeaseAskedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    session: str
    """Who asks, for `lease.answer`."""
    name: str
    """What it calls itself."""
    message: Union[str, None]
    """Its sentence; null: it says nothing."""

class LeaseQueueNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    place: int
    """Its place, from 1."""

class JobChangedNotification(TypedDict):
    """Parameters of a notification."""

    job: Job
    """All of it, as `job.get` answers it."""

class JogEndedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    jog: str
    """Which one."""
    why: Literal["released", "not-kept", "stopped", "lease", "link", "replaced", "limit"]
    """Why it ended: its session stopped it or went away; it was not kept up; a stop of the arm came; the lease ended; the line broke; the same session began another one; the arm came to a limit or to its fence."""

class ArmStateNotification(TypedDict):
    """Parameters of a notification."""

    subscription: int
    """Of which subscription of this socket."""
    state: StateChange
    """What is to be merged into the last state."""

class ServerEndingNotification(TypedDict):
    """Parameters of a notification."""

    left_s: float
    """How long it is until then, s."""

class TurnChangedNotificationArmsItemJobsItem(TypedDict):
    """Part of a message."""

    job: str
    """The job."""
    title: Union[str, None]
    """Its title; null: it has none."""
    person: Union[str, None]
    """Its owner; null: a teacher."""
    reason: Union[Literal["yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost"], None]
    """What keeps it: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is; schedule: no slot of its owner is open; turn: somebody else's; busy: something moves the arm or has its lease; lost: the arm is; null: the jobs in front of it alone."""

class TurnChangedNotificationArmsItemSlot(TypedDict):
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""

    who: list[str]
    """Who may have the arm: pupils, groups, tokens, or teacher."""
    until: Union[float, None]
    """When it ends, Unix time, s; null: it has no end."""

class TurnChangedNotificationArmsItem(TypedDict):
    """Part of a message."""

    arm: str
    """Its name."""
    person: Union[str, None]
    """Whose turn it is; null: nobody's."""
    state: Union[Literal["running", "kept", "suspended"], None]
    """Kept: for somebody who is not there; suspended: a teacher has the arm; null: nobody's turn."""
    left_s: Union[float, None]
    """What is left of the turn, s; null: it has no end, or is nobody's."""
    frozen: bool
    """Whether a teacher has frozen the arm."""
    jobs: list[TurnChangedNotificationArmsItemJobsItem]
    """The jobs that wait for the arm, in order."""
    slot: Union[TurnChangedNotificationArmsItemSlot, None]
    """The slot of the schedule that is open; null: anybody may have the arm, or none is open."""
    free_at: Union[float, None]
    """When the next slot begins, Unix time, s; null: the arm may be had now, or no slot is known."""

_TurnChangedNotificationQueueItemWords = TypedDict(
    "_TurnChangedNotificationQueueItemWords",
    {"from": "Union[float, None]", },
)

class TurnChangedNotificationQueueItem(_TurnChangedNotificationQueueItemWords):
    """Part of a message."""

    place: int
    """From 1."""
    person: str
    """Who waits."""
    arms: list[str]
    """The arms that will do."""
    missed: bool
    """Whether a turn came while the person was not there."""
    reason: Union[Literal["schedule", "frozen", "away"], None]
    """What keeps it: no slot of the person is open, all its arms are frozen, or the person is not there; null: those in front of it alone."""

class TurnChangedNotification(TypedDict):
    """Parameters of a notification."""

    turn_s: Union[float, None]
    """How long a turn is; 0 without end, s; null: there are no turns."""
    arms: list[TurnChangedNotificationArmsItem]
    """The arms of the station."""
    queue: list[TurnChangedNotificationQueueItem]
    """Who waits, in order."""

class TurnEndingNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    person: str
    """Whose turn it is."""
    left_s: float
    """How long it is until then, s."""

class TurnGrantedNotification(TypedDict):
    """Parameters of a notification."""

    arm: str
    """Name of the arm."""
    lease: str
    """The lease, for `lease.release`."""
    ttl_s: float
    """It ends when its holder says nothing for so long, s."""
    left_s: Union[float, None]
    """What is left of the turn, s; null: it has no end."""

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
