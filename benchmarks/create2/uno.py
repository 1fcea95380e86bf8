"""Sketches compiled with Debian's Arduino core and run in simavr, in the simulated time of the Uno's own clock."""

from __future__ import annotations

import atexit
import shutil
import struct
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import IO, NamedTuple

CORE = Path("/usr/share/arduino/hardware/arduino/avr")
TOOLS = ("avr-gcc", "avr-g++", "gcc")
CORE_FILES = (
    "HardwareSerial.cpp", "HardwareSerial0.cpp", "main.cpp", "Print.cpp", "Stream.cpp", "abi.cpp", "new.cpp",
    "hooks.c", "wiring.c", "wiring_digital.c",
)  # fmt: skip
CHIP = (
    "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10807", "-DARDUINO_AVR_UNO", "-DARDUINO_ARCH_AVR", "-Os",
    "-ffunction-sections", "-fdata-sections", f"-I{CORE}/cores/arduino", f"-I{CORE}/variants/standard",
)  # fmt: skip
CPP = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")


class Sent(NamedTuple):
    """A byte that the Uno sent, and when: microseconds since the beginning of the time it ran for."""

    at_us: int
    byte: int


def missing_tools() -> list[str]:
    """What is not installed of gcc-avr, avr-libc, arduino-core-avr, libsimavr-dev and gcc."""
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    needed = (CORE / "cores/arduino/Arduino.h", Path("/usr/include/simavr/sim_avr.h"))
    return missing + [str(file) for file in needed if not file.exists()]


@cache
def built_folder() -> Path:
    """Where this process keeps what it builds for all sketches; it goes with the process."""
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    return Path(folder.name)


@cache
def arduino_core() -> tuple[Path, ...]:
    """The object files of the Arduino core for an Uno, built once."""
    folder, objects = built_folder(), []
    for name in CORE_FILES:
        cpp = name.endswith(".cpp")
        out = folder / f"{name}.o"
        options = CPP if cpp else ("-std=gnu11",)
        source = str(CORE / "cores/arduino" / name)
        _run("avr-g++" if cpp else "avr-gcc", *CHIP, *options, "-w", "-c", source, "-o", str(out))
        objects.append(out)
    return tuple(objects)


def build_sketch(sketch: Path) -> Path:
    """The firmware of a sketch, beside it; no warning is allowed."""
    firmware = sketch.with_suffix(".elf")
    warnings = ("-Wall", "-Wextra", "-Werror")
    _run(
        "avr-g++", *CHIP, *CPP, *warnings, "-x", "c++", str(sketch), "-x", "none", *map(str, arduino_core()),
        "-Wl,--gc-sections", "-lm", "-o", str(firmware),
    )  # fmt: skip
    return firmware


def flash_bytes(firmware: Path) -> int:
    """How much of an Uno's flash memory the firmware takes."""
    done = subprocess.run(["avr-size", str(firmware)], capture_output=True, text=True, check=True)
    text, data = done.stdout.splitlines()[1].split()[:2]
    return int(text) + int(data)


@cache
def simulator() -> Path:
    """The program that runs firmware, see ``uno.c``, built once."""
    program = built_folder() / "uno"
    _run("gcc", "-O2", "-Wall", "-o", str(program), str(Path(__file__).with_name("uno.c")), "-lsimavr")
    return program


def _run(*command: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")


class Uno:
    """An Arduino Uno with its firmware; ``run`` lets it run for a while. To be closed after use. rate: of its clock."""

    def __init__(self, simulator: Path, firmware: Path, rate: float = 1.0) -> None:
        self._process = subprocess.Popen(
            [simulator, firmware, str(rate)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def run(self, duration_us: int, received: bytes = b"", *, signal: bool = False) -> list[Sent]:
        """Run for so long; it receives up to 60 bytes from the beginning on. Returns what it sent.

        signal: pin 3 is drawn to ground.
        """
        to, back = self._pipes()
        to.write(struct.pack("=IBB", duration_us, signal, len(received)) + received)
        to.flush()
        (count,) = struct.unpack("=H", _read(back, 2))
        return [Sent(*item) for item in struct.iter_unpack("=IB", _read(back, 5 * count))] if count else []

    def close(self) -> None:
        """End the simulation."""
        to, back = self._pipes()
        to.close()
        back.close()
        self._process.wait()

    def _pipes(self) -> tuple[IO[bytes], IO[bytes]]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        return self._process.stdin, self._process.stdout


def _read(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) != size:
        raise RuntimeError("the simulated Uno stopped")
    return data
