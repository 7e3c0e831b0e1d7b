"""Python interpreters of Debian, for another processor or newer than the installed ones, unpacked
into a folder by apt-get with its own package lists. Nothing is installed."""

import os
import pathlib
import shutil
import subprocess

KEYS = pathlib.Path("/usr/share/keyrings/debian-archive-keyring.gpg")
# Minor version of each release's Python, and the names of some libraries there. The next release
# has two Pythons.
SUITES = {
    "bookworm": (11, ("libssl3", "libffi8")),
    "trixie": (13, ("libssl3t64", "libffi8")),
    "forky": (14, ("libssl3t64", "libffi8", "libzstd1")),
}
LIBRARIES = ("libc6", "libgcc-s1", "libexpat1", "zlib1g", "libbz2-1.0", "liblzma5", "libuuid1")
QEMU = {"arm64": "qemu-aarch64-static", "armhf": "qemu-arm-static"}

CONFIGURATION = """\
APT::Architecture "{arch}";
APT::Architectures {{ "{arch}"; }};
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "5";
Debug::NoLocking "true";
Dir::Cache "{work}";
Dir::State::Lists "{work}/lists";
Dir::State::status "{work}/status";
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "{work}/sources";
"""
SOURCES = "Types: deb\nURIs: http://deb.debian.org/debian\nSuites: {suite}\nComponents: main\nSigned-By: {keys}\n"


class Debian:
    """Python of a Debian release for a processor, in a folder. For ARM it is emulated, for x86-64
    it runs with the release's own loader and libraries."""

    def __init__(self, arch, suite, home, minor=None):
        self.arch, self.suite = arch, suite
        self.minor, self._own = SUITES[suite]
        self.minor = minor or self.minor
        self.home = home / f"debian-{suite}-{arch}-3.{self.minor}"
        program = self.home / "usr" / "bin" / f"python3.{self.minor}"
        self.python = [QEMU[arch], "-L", self.home, program] if arch in QEMU else [program]

    def missing(self):
        """Returns the missing requirements; empty if all are present."""
        lacking = [name for name in (QEMU.get(self.arch, "patchelf"), "apt-get", "dpkg-deb") if not shutil.which(name)]
        if not KEYS.exists():
            lacking.append(str(KEYS))
        return f"this computer has no {', '.join(lacking)}" if lacking else ""

    def unpack(self):
        """Downloads and unpacks the interpreter, once."""
        if self.home.exists():
            return
        work = self.home.with_name(self.home.name + "-fetched")
        shutil.rmtree(work, ignore_errors=True)
        for folder in ("lists/partial", "archives/partial", "sources", "root"):
            (work / folder).mkdir(parents=True)
        (work / "status").touch()
        (work / "apt.conf").write_text(CONFIGURATION.format(arch=self.arch, work=work))
        (work / "sources" / "debian.sources").write_text(SOURCES.format(suite=self.suite, keys=KEYS))
        python = f"python3.{self.minor}"
        names = [f"{python}-minimal", f"lib{python}-minimal", f"lib{python}-stdlib", *LIBRARIES, *self._own]
        for words in (["update"], ["download", *names]):
            done = subprocess.run(["apt-get", "-qq", *words], cwd=work / "archives", text=True, stdin=subprocess.DEVNULL,
                                  env={**os.environ, "APT_CONFIG": str(work / "apt.conf")}, timeout=300,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            if done.returncode:
                raise RuntimeError(f"apt-get {words[0]}: {done.stdout}")
        for package in sorted((work / "archives").glob("*.deb")):
            subprocess.run(["dpkg-deb", "-x", package, work / "root"], check=True)
        for folder in ("lib", "lib64"):
            if not (work / "root" / folder).exists():
                (work / "root" / folder).symlink_to(f"usr/{folder}")
        if self.arch not in QEMU:
            own = ["--set-interpreter", self.home / "lib64/ld-linux-x86-64.so.2", "--force-rpath", "--set-rpath",
                   self.home / "usr/lib/x86_64-linux-gnu"]
            subprocess.run(["patchelf", *own, work / "root" / "usr" / "bin" / python], check=True)
        (work / "root").rename(self.home)
        shutil.rmtree(work)
