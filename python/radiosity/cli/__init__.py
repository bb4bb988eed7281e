"""The command line: one file per command, nothing heavy imported before a command runs.

Whatever goes wrong becomes one sentence on stderr and an exit code (see :mod:`radiosity.cli.failure`); a traceback is
shown only with ``RADIOSITY_DEBUG=1``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; ``arguments`` are those of the process by default."""
    try:
        from radiosity.cli import interrupt

        interrupt.watch()
        code = _run(arguments)
        sys.stdout.flush()
    except (Exception, KeyboardInterrupt) as error:
        if os.environ.get("RADIOSITY_DEBUG") == "1":
            raise
        return _report(error)
    return code


def _run(arguments: Sequence[str] | None) -> int:
    from radiosity.cli.app import app
    from radiosity.cli.failure import ExitCode

    # Without standalone mode, errors of usage arrive as exceptions and typer.Exit as a return value.
    code: int | None = app(args=arguments, prog_name="radiosity", standalone_mode=False)
    if code == ExitCode.INTERRUPTED:
        raise KeyboardInterrupt
    return code or ExitCode.DONE


def _report(error: BaseException) -> int:
    """Say what went wrong on stderr and return the exit code."""
    from radiosity.cli import interrupt
    from radiosity.cli.failure import ExitCode, diagnose

    interrupt.ending()
    if isinstance(error, BrokenPipeError):
        # Whoever read our output has had enough; nothing may complain about that at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ExitCode.FAULT
    code, sentence = diagnose(error)
    if sentence:
        print("radiosity: " + " ".join(sentence.split()), file=sys.stderr)
    return code
