"""What machine a benchmark ran on, in one line."""

from __future__ import annotations

import os
import platform
from datetime import date
from pathlib import Path


def describe() -> str:
    """Processor, cores, memory, system, date and load average."""
    load = ", ".join(f"{x:.2f}" for x in os.getloadavg())
    return (
        f"{processor()}, {os.cpu_count()} cores, {memory_gib():.0f} GiB, {platform.system()} "
        f"{platform.release()}, Python {platform.python_version()}, {date.today()}, load {load}"
    )


def processor() -> str:
    """The processor's name where the system tells it."""
    information = Path("/proc/cpuinfo")
    lines = information.read_text().splitlines() if information.exists() else []
    names = {key.strip(): value.strip() for key, _, value in (s.partition(":") for s in lines)}
    model = [f"family {names['cpu family']} model {names['model']}"] if "model" in names else []
    return " ".join([names.get("model name") or platform.machine(), *model])


def memory_gib() -> float:
    """Physical memory."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
