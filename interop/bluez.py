"""Mock of BlueZ's D-Bus interface: bluez.py ARM-TCP-PORT, with DBUS_SYSTEM_BUS_ADDRESS leading to a
private bus

Provides an adapter and devices, one of which has the service of a Magician, whose characteristics
carry bytes to and from a virtual arm. Paths, interfaces, properties, errors and the order of
signals are those of BlueZ's own documentation (doc/org.bluez.Adapter.rst, .Device.rst,
.GattCharacteristic.rst). There is no radio.

Each line of stdin is a JSON object {"do": NAME, ...}, answered with one line on stdout.
"""

import json
import socket
import sys

import dbus
import dbus.mainloop.glib
import dbus.service
from gi.repository import GLib

PROPERTIES = "org.freedesktop.DBus.Properties"
ADAPTER, DEVICE = "org.bluez.Adapter1", "org.bluez.Device1"
SERVICE, CHARACTERISTIC = "org.bluez.GattService1", "org.bluez.GattCharacteristic1"
ROOM = "/org/bluez/hci0"
UUID = "0003cdd{}-0000-1000-8000-00805f9b0131"


class Failed(dbus.DBusException):
    """Error with a name of BlueZ's."""

    def __init__(self, kind, message):
        super().__init__(message, name=f"org.bluez.Error.{kind}")


def to_dbus(name, value):
    """Converts a value to the D-Bus type of its BlueZ property."""
    if name in ("Flags", "UUIDs"):
        return dbus.Array(value, signature="s")
    if name == "Value":
        return dbus.Array(value, signature="y")
    if name in ("Device", "Adapter", "Service"):
        return dbus.ObjectPath(value)
    if name == "RSSI":
        return dbus.Int16(value)
    if name == "MTU":
        return dbus.UInt16(value)
    return value


class Object(dbus.service.Object):
    """Object on the bus with the properties of one interface."""

    def __init__(self, world, path, interface, properties):
        self.world, self.path, self.interface, self.properties = world, path, interface, properties
        super().__init__(world.bus, path)
        world.objects[path] = self
        world.root.InterfacesAdded(path, self.interfaces())

    def typed(self):
        return {name: to_dbus(name, value) for name, value in self.properties.items()}

    def interfaces(self):
        return {self.interface: dbus.Dictionary(self.typed(), signature="sv")}

    def change(self, **properties):
        self.properties.update(properties)
        changed = {name: to_dbus(name, value) for name, value in properties.items()}
        self.PropertiesChanged(self.interface, dbus.Dictionary(changed, signature="sv"), dbus.Array([], signature="s"))

    def drop(self, name):
        if self.properties.pop(name, None) is not None:
            nothing = dbus.Dictionary({}, signature="sv")
            self.PropertiesChanged(self.interface, nothing, dbus.Array([name], signature="s"))

    def remove(self):
        del self.world.objects[self.path]
        self.world.root.InterfacesRemoved(self.path, [self.interface])
        self.remove_from_connection()

    @dbus.service.method(PROPERTIES, in_signature="ss", out_signature="v")
    def Get(self, interface, name):
        if interface != self.interface or name not in self.properties:
            raise dbus.DBusException(f"no {name}", name="org.freedesktop.DBus.Error.InvalidArgs")
        return self.typed()[name]

    @dbus.service.method(PROPERTIES, in_signature="s", out_signature="a{sv}")
    def GetAll(self, interface):
        return self.typed() if interface == self.interface else {}

    @dbus.service.method(PROPERTIES, in_signature="ssv")
    def Set(self, interface, name, value):
        self.world.asked.append(f"set {name}={int(value)}")
        self.change(**{name: bool(value)})

    @dbus.service.signal(PROPERTIES, signature="sa{sv}as")
    def PropertiesChanged(self, interface, changed, invalidated):
        pass


class Root(dbus.service.Object):
    def __init__(self, world):
        self.world = world
        super().__init__(world.bus, "/")

    @dbus.service.method("org.freedesktop.DBus.ObjectManager", out_signature="a{oa{sa{sv}}}")
    def GetManagedObjects(self):
        return {dbus.ObjectPath(path): one.interfaces() for path, one in self.world.objects.items()}

    @dbus.service.signal("org.freedesktop.DBus.ObjectManager", signature="oa{sa{sv}}")
    def InterfacesAdded(self, path, interfaces):
        pass

    @dbus.service.signal("org.freedesktop.DBus.ObjectManager", signature="oas")
    def InterfacesRemoved(self, path, interfaces):
        pass


class Adapter(Object):
    def __init__(self, world, powered):
        names = {"Name": "desk", "Alias": "desk", "Modalias": "usb:v1D6Bp0246d0542"}
        address = {"Address": "00:11:22:33:44:55", "AddressType": "public"}
        super().__init__(world, ROOM, ADAPTER, names | address | {"Powered": powered, "Discovering": False})
        self.client = None

    @dbus.service.method(ADAPTER, in_signature="a{sv}")
    def SetDiscoveryFilter(self, _):
        pass

    @dbus.service.method(ADAPTER, sender_keyword="sender")
    def StartDiscovery(self, sender):
        if self.world.forbidden:
            raise dbus.DBusException("Rejected send message", name="org.freedesktop.DBus.Error.AccessDenied")
        self.world.asked.append("scan")
        if not self.properties["Powered"]:
            raise Failed("NotReady", "Resource Not Ready")
        if self.client:
            raise Failed("InProgress", "Operation already in progress")
        self.client = sender
        self.change(Discovering=True)
        GLib.timeout_add(150, self.hear)

    @dbus.service.method(ADAPTER, sender_keyword="sender")
    def StopDiscovery(self, sender):
        if self.client != sender:
            raise Failed("Failed", "No discovery started")
        self.still()

    def hear(self):
        """Reports the devices in range to the scanning client."""
        if self.client:
            for who in self.world.around:
                path = f"{ROOM}/dev_{who['address'].replace(':', '_')}"
                if path in self.world.objects:
                    self.world.objects[path].change(RSSI=-60)
                else:
                    Device(self.world, path, who)
        return bool(self.client)

    def still(self):
        self.client = None
        for one in list(self.world.objects.values()):
            one.drop("RSSI")
        self.change(Discovering=False)


class Device(Object):
    def __init__(self, world, path, who):
        self.who = who
        named = {"Name": who["name"], "Alias": who["name"]} if who.get("name") else {}
        named.setdefault("Alias", who["address"].replace(":", "-"))
        state = {name: False for name in ("Paired", "Connected", "Trusted", "Blocked", "LegacyPairing", "ServicesResolved")}
        uuids = [UUID.format(0)] if who.get("advertises") else []
        fixed = {"Address": who["address"], "AddressType": "random", "Adapter": ROOM, "UUIDs": uuids, "RSSI": -60}
        super().__init__(world, path, DEVICE, fixed | state | named)
        self.gatt = []
        self.line = None

    @dbus.service.method(DEVICE, async_callbacks=("done", "fail"))
    def Connect(self, done, fail):
        self.world.asked.append("connect")
        GLib.timeout_add(50, self.connected, done, fail)

    def connected(self, done, fail):
        if self.who not in self.world.around or self.world.refuse > 0:
            self.world.refuse -= 1
            fail(Failed("Failed", "le-connection-abort-by-local"))
        elif self.properties["Connected"]:
            done()
        else:
            self.change(Connected=True)
            done()
            GLib.timeout_add(30, self.resolved)
        return False

    def resolved(self):
        if not self.properties["Connected"]:
            return False
        if self.who.get("arm"):
            self.line = Line(self)
            path = f"{self.path}/service0010"
            self.gatt.append(Object(self.world, path, SERVICE, {"UUID": UUID.format(0), "Primary": True, "Device": self.path}))
            # Such modules have a further characteristic, for their own settings.
            for number, flags in [*self.world.flags.items(), ("3", ["read", "write", "notify"])]:
                char = f"{path}/char001{number}"
                self.gatt.append(Characteristic(self, char, UUID.format(number), flags))
        self.change(ServicesResolved=True)
        return False

    @dbus.service.method(DEVICE)
    def Disconnect(self):
        self.world.asked.append("disconnect")
        if not self.properties["Connected"]:
            raise Failed("NotConnected", "Not Connected")
        self.part()

    def part(self):
        """Ends the connection, on behalf of either side."""
        if self.line:
            self.line.close()
            self.line = None
        for one in reversed(self.gatt):
            one.remove()
        self.gatt = []
        self.change(ServicesResolved=False)
        self.change(Connected=False)


class Characteristic(Object):
    def __init__(self, device, path, uuid, flags):
        self.device, self.flags = device, flags
        service = path.rsplit("/", 1)[0]
        mtu = {"MTU": device.world.mtu} if device.world.mtu else {}
        properties = {"UUID": uuid, "Service": service, "Flags": flags, "Value": [], "Notifying": False}
        super().__init__(device.world, path, CHARACTERISTIC, properties | mtu)
        self.busy = False

    @dbus.service.method(CHARACTERISTIC, in_signature="aya{sv}", async_callbacks=("done", "fail"))
    def WriteValue(self, value, options, done, fail):
        world, kind = self.device.world, str(options.get("type", "request"))
        needs = {"command": "write-without-response", "request": "write"}.get(kind)
        data = bytes(value)
        if needs not in self.flags:
            return fail(Failed("NotSupported", "Operation is not supported"))
        if len(data) > (world.mtu or 23) - 3:
            return fail(Failed("Failed", "Failed to initiate write"))
        if self.busy:
            return fail(Failed("InProgress", "Operation already in progress"))
        if world.writes_left == 0:
            # The device is out of range, and the computer is about to notice.
            return GLib.timeout_add(20, world.vanish)
        world.writes_left -= 1
        world.written.append((self.properties["UUID"][7], kind, len(data)))
        if kind == "command":
            done()
            self.device.line.send(data)
        else:
            # A write request and its response take one connection interval.
            self.busy = True
            GLib.timeout_add(world.interval, self.answer, data, done)

    def answer(self, data, done):
        self.busy = False
        done()
        if self.device.line:
            self.device.line.send(data)
        return False

    @dbus.service.method(CHARACTERISTIC)
    def StartNotify(self):
        if not {"notify", "indicate"} & set(self.flags):
            raise Failed("NotSupported", "Operation is not supported")
        self.change(Notifying=True)

    @dbus.service.method(CHARACTERISTIC)
    def StopNotify(self):
        if not self.properties["Notifying"]:
            raise Failed("Failed", "No notify session started")
        self.change(Notifying=False)


class Line:
    """Connection from the module to the arm. Written bytes are forwarded and received bytes are
    notified, both at every connection interval."""

    def __init__(self, device):
        self.device, self.world = device, device.world
        self.socket = socket.create_connection(("127.0.0.1", self.world.port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.out = self.back = b""
        self.watch = GLib.io_add_watch(self.socket.fileno(), GLib.IO_IN | GLib.IO_HUP, self.come)
        self.tick = GLib.timeout_add(self.world.interval, self.beat) if self.world.interval else None

    def send(self, data):
        self.out += data
        self.tick or self.beat()

    def come(self, *_):
        self.back += self.socket.recv(4096)
        self.tick or self.beat()
        return True

    def beat(self):
        self.socket.sendall(self.out)
        self.out = b""
        size = (self.world.mtu or 23) - 3
        while self.back:
            part, self.back = self.back[:size], self.back[size:]
            for one in self.device.gatt:
                if one.properties.get("Notifying"):
                    self.world.notified.append(len(part))
                    one.change(Value=list(part))
        return True

    def close(self):
        GLib.source_remove(self.watch)
        if self.tick:
            GLib.source_remove(self.tick)
        # Bytes written before the end of the connection were already transmitted.
        self.socket.sendall(self.out)
        self.socket.close()


class World:
    """State of the mock, with the operations available to the session."""

    def __init__(self, bus, port, loop):
        self.bus, self.port, self.loop = bus, port, loop
        self.objects, self.root = {}, None
        self.root = Root(self)
        self.set()
        bus.add_signal_receiver(self.owner_changed, "NameOwnerChanged", "org.freedesktop.DBus")

    def owner_changed(self, name, _, new):
        adapter = self.objects.get(ROOM)
        if not new and adapter and adapter.client == name:
            self.asked.append("left scanning")
            adapter.still()

    def set(self, adapter=True, powered=True, flags=None, mtu=None, interval=0, around=(), refuse=0, forbidden=False):
        """Resets the mock to another configuration. Known devices are forgotten."""
        for one in reversed(list(self.objects.values())):
            if isinstance(one, Device) and one.properties["Connected"]:
                one.part()
        for one in reversed(list(self.objects.values())):
            one.remove()
        self.asked, self.written, self.notified = [], [], []
        self.flags = flags or {"1": ["read", "notify"], "2": ["write", "write-without-response"]}
        self.mtu, self.interval, self.refuse = mtu, interval, refuse
        self.forbidden, self.writes_left = forbidden, -1
        self.around = self.near = list(around)
        if adapter:
            Adapter(self, powered)

    def vanish(self):
        """Simulates the arm being switched off or out of range."""
        self.writes_left = -1
        self.around = [who for who in self.near if not who.get("arm")]
        for one in list(self.objects.values()):
            if isinstance(one, Device) and one.who not in self.around:
                one.drop("RSSI")
                if one.properties["Connected"]:
                    one.part()
        return False

    def vanish_after(self, writes):
        self.writes_left = writes

    def come_back(self):
        self.around = list(self.near)

    def power(self, on):
        if not on:
            for one in list(self.objects.values()):
                if isinstance(one, Device) and one.properties["Connected"]:
                    one.part()
        self.objects[ROOM].change(Powered=on)

    def seen(self):
        """Returns the recorded events."""
        devices = [one for one in self.objects.values() if isinstance(one, Device)]
        connected = [one.who["address"] for one in devices if one.properties["Connected"]]
        adapter = self.objects.get(ROOM)
        scanning = bool(adapter and adapter.client)
        return {
            "asked": self.asked,
            "written": self.written,
            "notified": self.notified,
            "connected": connected,
            "scanning": scanning,
        }

    def command(self, *_):
        line = sys.stdin.readline()
        if not line:
            self.loop.quit()
            return False
        order = json.loads(line)
        answer = getattr(self, order.pop("do"))(**order)
        print(json.dumps(answer), flush=True)
        return True


def main():
    dbus.mainloop.glib.DBusGMainLoop(set_as_default=True)
    bus, loop = dbus.SystemBus(), GLib.MainLoop()
    world = World(bus, int(sys.argv[1]), loop)
    # The name is claimed last, so that clients find a complete service.
    name = dbus.service.BusName("org.bluez", bus)
    GLib.io_add_watch(sys.stdin.fileno(), GLib.IO_IN | GLib.IO_HUP, world.command)
    print("ready", flush=True)
    loop.run()
    del name


if __name__ == "__main__":
    main()
