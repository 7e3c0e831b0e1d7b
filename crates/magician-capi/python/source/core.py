# --- Errors ----------------------------------------------------------------------------------------------------------


class DobotError(RuntimeError):
    """A function that did not do what it was asked to.

    `function` is its name, `code` what the library returned (a member of DobotCommunicate, or None if it was this
    module that gave up waiting), `reason` a sentence.
    """

    def __init__(self, function, code, reason):
        # Do not repeat the name: the library's sentence may begin with it.
        reason = reason[len(function) + 2 :] if reason.startswith(f"{function}: ") else reason
        self.function, self.code, self.reason = function, code, reason
        said = [function] if code is None else [function, _CODES.get(code, f"code {code}")]
        super().__init__(": ".join([*said, reason]))

    def __reduce__(self):
        return DobotError, (self.function, self.code, self.reason)


_CODES = {1: "buffer full (1)", 2: "timeout (2)", 3: "invalid parameters (3)", 4: "invalid device (4)"}

# --- The library -----------------------------------------------------------------------------------------------------

_FILES = {
    "Windows": ("DobotDll.dll", f"dobotdll_{_FAMILY}.dll"),
    "Darwin": ("libDobotDll.dylib", "libDobotDll.1.0.0.dylib", f"libdobotdll_{_FAMILY}.dylib"),
}.get(platform.system(), ("libDobotDll.so", "libDobotDll.so.1", f"libdobotdll_{_FAMILY}.so"))


def load():
    """The library, as a handle for all the other functions.

    It is looked for beside this file, then at MAGICIAN_DOBOTDLL (a file, or a folder with it), then where the system
    looks for libraries.
    """
    tried = []
    for place in _places():
        try:
            handle = CDLL(place)
        except OSError as error:
            tried.append(f"{place}: {error}")
            continue
        _check_family(handle, place)
        return handle
    python = f"This is Python for {platform.machine()}, {platform.architecture()[0]}."
    advice = f"Put {_FILES[0]} beside {os.path.abspath(__file__)}, or name it, or its folder, in MAGICIAN_DOBOTDLL. "
    tries = "".join(f"\n  {t}" for t in tried)
    raise OSError("there is no DobotDll library that can be loaded. " + advice + python + tries)


def _places():
    """Where the library can be: files that exist, then bare names for the system to look up."""
    folders = [os.path.dirname(os.path.abspath(__file__))]
    named = os.environ.get("MAGICIAN_DOBOTDLL")
    places = []
    if named and os.path.isdir(named):
        folders.append(os.path.abspath(named))
    elif named:
        places.append(os.path.abspath(named))
    inside = [os.path.join(folder, file) for folder in folders for file in _FILES]
    return [place for place in inside if os.path.exists(place)] + places + list(_FILES)


def _check_family(handle, place):
    """Refuse the library of another family: its functions have the same names and other arguments."""
    if hasattr(handle, "GetDeviceID"):
        family = "v3"
    elif hasattr(handle, "SendPluse"):
        family = "v1"
    elif hasattr(handle, "MagicianLastError"):
        family = "v2"
    else:
        return
    if family != _FAMILY:
        raise OSError(f"{place} is a library of family {family}, and this DobotDllType.py is for {_FAMILY}")


class _Library:
    """How the functions of a shared library are called: the only part of this module that knows.

    An `api` that has a method `dobot_call(name, arguments)` answers the calls itself: it gets the ctypes values in
    their C order and returns the code; `dobot_last_error()`, if it has one, says why the code is not 0.
    """

    def __init__(self, handle):
        self.handle, self.functions = handle, {}

    def dobot_call(self, name, arguments):
        function = self.functions.get(name)
        if function is None:
            function = self.functions[name] = self.declared(name)
        return function(*[byref(value) if isinstance(value, _BY_REFERENCE) else value for value in arguments])

    def declared(self, name):
        # handle[name] creates a new function object, so these declarations do not affect programs that call
        # `api.Name(...)` and rely on the default conversions of ctypes.
        try:
            function = self.handle[name]
        except AttributeError:
            raise DobotError(name, None, "this library has no such function") from None
        function.argtypes, function.restype = _PROTOTYPES[name], c_int
        return function

    def dobot_last_error(self):
        if not hasattr(self.handle, "MagicianLastError"):
            return ""
        text = create_string_buffer(max(self.dobot_call("MagicianLastError", (None, 0)), 0) + 1)
        self.dobot_call("MagicianLastError", (text, len(text)))
        return _string(text)


class _Arms:
    """What is known of an `api`: how it is called, the last queued command, and which of them may take long."""

    known = weakref.WeakKeyDictionary()

    def __init__(self, api):
        self.door = api if hasattr(api, "dobot_call") else _Library(api)
        self.slow, self.last = {}, {}
        # Per thread: the wait of a program that does nothing but poll the index.
        self.waits = threading.local()

    @classmethod
    def of(cls, api):
        found = cls.known.get(api)
        if found is None:
            found = cls.known.setdefault(api, cls(api))
        return found


def _call(api, name, *arguments):
    """One function, once; while the arm's queue is full, again. Anything but success is a DobotError."""
    arms = _Arms.of(api)
    code = arms.door.dobot_call(name, arguments)
    if code == DobotCommunicate.DobotCommunicate_BufferFull:
        watch = _Watch(arms, arguments[:_IDS], name, "there is no room in the arm's queue")
        while code == DobotCommunicate.DobotCommunicate_BufferFull:
            watch.look()
            time.sleep(ROOM_INTERVAL)
            code = arms.door.dobot_call(name, arguments)
    if code != DobotCommunicate.DobotCommunicate_NoError:
        raise DobotError(name, code, _reason(arms.door))
    if name != "GetQueuedCmdCurrentIndex":
        arms.waits.watch = None
        if name == "SetQueuedCmdClear":
            arms.last.pop(_key(arguments), None)
        elif arguments and isinstance(arguments[-1], c_uint64) and arguments[-1].value:
            arms.last[_key(arguments[:_IDS])] = arguments[-1].value


def _reason(door):
    said = getattr(door, "dobot_last_error", str)()
    return said or "the library does not say why"


# --- Waiting ---------------------------------------------------------------------------------------------------------

# Poll intervals, s: for room in a full queue, and for the end of a command.
ROOM_INTERVAL = 0.02
FINISH_INTERVAL = 0.005
# Seconds without progress of queue and arm after which a wait gives up, if the reason is unknown.
QUEUE_STALL = 20.0
# The same while an alarm blocks the queue.
ALARM_STALL = 1.5
# Extra seconds during homing, when the arm may seem to stand still.
HOMING = 60.0
FOR_EVER = float("inf")


def _expect(api, arm, index, seconds):
    """Remember that a queued command may leave the arm standing so long (a WAIT), or for ever (a trigger)."""
    if index:
        slow = _Arms.of(api).slow.setdefault(_key(arm), {})
        slow[index] = seconds
        if len(slow) > 4096:
            del slow[min(slow)]


def _finish(api, arm, name, index):
    """Wait until the queued command with this index is finished. Index 0: it was not queued."""
    if not index:
        return
    watch = _Watch(_Arms.of(api), arm, name, f"command {index} of the queue is not finished")
    while watch.look() < index:
        time.sleep(FINISH_INTERVAL)


def _waited(api, arm, index):
    """The program has asked for the index. If that is all it does, it waits: not for ever under an alarm."""
    arms = _Arms.of(api)
    watch = getattr(arms.waits, "watch", None)
    last = arms.last.get(_key(arm), 0)
    if index >= last:
        arms.waits.watch = None
        return
    if watch is None or _key(watch.arm) != _key(arm):
        what = f"command {last} of the queue is not finished"
        watch = arms.waits.watch = _Watch(arms, arm, "GetQueuedCmdCurrentIndex", what, stall=FOR_EVER)
    try:
        watch.saw(index)
    except DobotError:
        arms.waits.watch = None
        raise


def _key(arm):
    return tuple(getattr(number, "value", number) for number in arm)


class _Watch:
    """Checks whether a queue moves, so that no call waits for ever."""

    def __init__(self, arms, arm, name, what, stall=None):
        self.arms, self.arm, self.name, self.what, self.stall = arms, arm, name, what, stall
        self.index = self.pose = None
        self.since = self.looked = time.monotonic()

    def look(self):
        """The index that ended last; a DobotError if queue and arm have stood for too long."""
        index = c_uint64(0)
        self.read("GetQueuedCmdCurrentIndex", index)
        return self.saw(index.value)

    def saw(self, index):
        """The index was read."""
        now = time.monotonic()
        if index != self.index:
            self.index, self.pose, self.since = index, None, now
        elif now - self.since > 0.5 and now - self.looked > 0.2:
            self.looked = now
            self.look_closer(now)
        return self.index

    def look_closer(self, now):
        pose = Pose()
        self.read("GetPose", pose)
        values = [getattr(pose, name) for name, _ in Pose._fields_]
        if self.pose is None or any(abs(a - b) > 0.01 for a, b in zip(values, self.pose)):
            self.pose, self.since = values, now if self.pose is not None else self.since
            return
        stood = now - self.since
        slow = self.arms.slow.get(_key(self.arm), {})
        # The first index that an arm gives is 1 or 2 (model section 14).
        under_way = (self.index + 1, 2) if self.index == 0 else (self.index + 1,)
        more = max(slow.get(index, 0) for index in under_way)
        alarms = self.alarms()
        # Homing continues despite an alarm.
        if alarms and more != HOMING:
            if stood > ALARM_STALL:
                self.give_up_under(alarms)
            return
        if stood > (QUEUE_STALL if self.stall is None else self.stall) + more:
            self.give_up(
                f"for {stood:.0f} s neither the queue nor the arm has moved: was the queue started"
                " (SetQueuedCmdStartExec)? A limit that was touched also stops it, until ClearAllAlarmsState"
            )

    def give_up_under(self, alarms):
        names = [f"0x{alarm:02X}" for alarm in alarms]
        said = _reason(self.arms.door)
        # The library knows the names of the alarms, and has reported them for the call that read the index.
        if said.startswith("GetQueuedCmdCurrentIndex: ") and all(name in said for name in names):
            raise DobotError(self.name, None, said.partition(": ")[2])
        names = ", ".join(names)
        self.give_up(f"alarm {names} keeps the queue from running (ClearAllAlarmsState, once the cause is gone)")

    def alarms(self):
        """Alarms that keep a queue from running: all but the first byte."""
        bits, length = create_string_buffer(32), c_uint32(0)
        self.read("GetAlarmsState", bits, length, 32)
        return [8 * n + bit for n in range(1, 32) for bit in range(8) if bits.raw[n] >> bit & 1]

    def read(self, name, *arguments):
        code = self.arms.door.dobot_call(name, (*self.arm, *arguments))
        if code != DobotCommunicate.DobotCommunicate_NoError:
            raise DobotError(self.name, code, f"{self.what}, and {name} failed: {_reason(self.arms.door)}")

    def give_up(self, why):
        raise DobotError(self.name, None, f"{self.what}; index {self.index} was the last to end, and {why}")


# --- Values ----------------------------------------------------------------------------------------------------------

_BY_REFERENCE = (Structure, c_uint8, c_uint16, c_uint32, c_uint64, c_int32, c_float)


def _byte(value):
    return int(value) & 0xFF


def _text(value):
    return value.encode("utf-8") if isinstance(value, str) else bytes(value)


def _decimal(value):
    return _text(str(int(value)))


def _string(buffer):
    return buffer.value.decode("utf-8", "replace")


def _filled(structure, value):
    """A structure, from one or from its values."""
    return value if isinstance(value, structure) else structure(*value)


def _outputs(given):
    """The outputs that a motion switches on its way, as a C array."""
    made = [_filled(ParallelOutputCmd, value) for value in given]
    return (ParallelOutputCmd * max(len(made), 1))(*made), len(made)


def _try(api, name, *arguments):
    """One function, whatever it returns: the code is the caller's business."""
    if name == "ConnectDobot":
        _Arms.of(api).last.clear()
    return _Arms.of(api).door.dobot_call(name, arguments)


# --- Session ---------------------------------------------------------------------------------------------------------


def dSleep(ms):
    time.sleep(ms / 1000)


def MagicianLastError(api):
    """Why the last call of this thread failed, in a sentence; empty if none has."""
    return _Arms.of(api).door.dobot_last_error()


def MagicianAllow(api, names):
    """Allow functions that can brick, unlearn or unlock something: their names with commas, or "all"."""
    _call(api, "MagicianAllow", _text(names))


def output(str):
    """Does nothing, as ever."""


def SearchDobot(api, maxLen=1000):
    """Where arms could be, as a list of names for ConnectDobot."""
    found = create_string_buffer(max(maxLen, 1))
    if not _try(api, "SearchDobot", found, maxLen):
        return []
    # A name may end with words in parentheses.
    return re.findall(r"(?:[^\s(]|\([^)]*\))+(?: \([^)]*\))?", _string(found))
