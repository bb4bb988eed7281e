"""A progress bar for what takes longer than a second, on a terminal."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

DELAY = 1.0
"""Seconds before the bar appears."""


class Bar:
    """A context and a callback ``(done, total)``; silent when ``quiet`` or when stderr is no terminal."""

    def __init__(self, label: str, *, quiet: bool = False) -> None:
        self._label = label
        self._wanted = not quiet and sys.stderr.isatty()
        self._start = time.monotonic()
        self._shown: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._shown is not None:
            self._shown[0].stop()

    def __call__(self, done: int, total: int) -> None:
        """Show how far the work is."""
        if self._shown is None and self._wanted and time.monotonic() - self._start > DELAY:
            self._shown = self._open()
        if self._shown is not None:
            progress, task = self._shown
            progress.update(task, completed=done, total=total or None)

    def _open(self) -> tuple[Progress, TaskID]:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
        progress = Progress(*columns, console=Console(stderr=True), transient=True)
        progress.start()
        task = progress.add_task(self._label, total=None)
        progress.tasks[0].start_time = progress.get_time() - (time.monotonic() - self._start)
        return progress, task
