"""Ctrl-C ends the command within a second, and never in the middle of a file.

The engine checks for signals while it works, but some of its stages (building the ray hierarchy of millions of
patches) run to their end first. So a thread listens too: if the command has not ended by itself in time, the thread
ends the process.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from radiosity.cli.failure import ExitCode

PATIENCE = 0.7
"""Seconds that a command gets to end by itself; a second Ctrl-C cuts them short."""

_writing = threading.Lock()
_ending = threading.Event()
_unfinished: list[Path] = []
"""Files that are being built and can be gone on with."""


@contextmanager
def writing() -> Iterator[None]:
    """Keep the listening thread from ending the process while a file is written."""
    with _writing:
        yield


@contextmanager
def resumable(partial: Path | None) -> Iterator[None]:
    """Have an interruption say that the work can be gone on with, where it leaves this file."""
    _unfinished[:] = [] if partial is None else [partial]
    yield
    _unfinished.clear()


def sentence() -> str:
    """What to say of an interruption."""
    kept = [
        f"; what is done is in {path}: the same command goes on from there" for path in _unfinished if path.exists()
    ]
    return "interrupted" + "".join(kept)


def ending() -> None:
    """Say that the command is ending by itself and has said why."""
    _ending.set()


def watch() -> None:
    """Start listening; does nothing off the main thread or when Ctrl-C is ignored."""
    if threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return
    ears, mouth = socket.socketpair()
    mouth.setblocking(False)
    signal.set_wakeup_fd(mouth.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_listen, args=(ears, mouth), name="interrupt", daemon=True).start()


def _listen(ears: socket.socket, mouth: socket.socket) -> None:
    # `mouth` is a parameter so that it stays open as long as this thread lives.
    while ears.recv(1) != bytes([signal.SIGINT]):
        pass
    select.select([ears], [], [], PATIENCE)
    with _writing:
        if not _ending.is_set():
            sys.stderr.write(f"radiosity: {sentence()}\n")
            sys.stderr.flush()
        os._exit(ExitCode.INTERRUPTED)
