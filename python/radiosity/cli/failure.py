"""Exit codes, and which exception means which."""

from __future__ import annotations

import enum
import errno

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.ENOMEM}


class ExitCode(enum.IntEnum):
    """What the shell gets to see."""

    DONE = 0
    FAULT = 1
    """A defect of the program itself, or nobody reads its output."""
    ARGUMENTS = 2
    INPUT = 3
    ACCURACY = 4
    """The accuracy asked for was not reached within the limits given, or targets of a design were missed; results are
    saved all the same."""
    RESOURCES = 5
    """Memory or disk."""
    INTERRUPTED = 130


class Stop(Exception):  # noqa: N818 - not always an error
    """Ends the command with an exit code and one sentence."""

    def __init__(self, code: ExitCode, sentence: str) -> None:
        super().__init__(sentence)
        self.code = code


def bad_argument(sentence: str) -> Stop:
    """What to raise about an argument."""
    return Stop(ExitCode.ARGUMENTS, sentence)


def diagnose(error: BaseException) -> tuple[ExitCode, str]:
    """Exit code and sentence for an exception that ended a command; an empty sentence if all is said."""
    from radiosity import ResourceError, SceneError

    if isinstance(error, Stop):
        return error.code, str(error)
    if isinstance(error, OSError):
        return _diagnose_system(error)
    codes: list[tuple[type[BaseException], ExitCode]] = [
        (SceneError, ExitCode.INPUT),
        (ResourceError, ExitCode.RESOURCES),
        (ValueError, ExitCode.ARGUMENTS),
    ]
    for kind, code in codes:
        if isinstance(error, kind):
            return code, str(error)
    if isinstance(error, MemoryError):
        return ExitCode.RESOURCES, "out of memory: use fewer patches, or lower --memory"
    if isinstance(error, KeyboardInterrupt):
        from radiosity.cli import interrupt

        return ExitCode.INTERRUPTED, interrupt.sentence()
    return _diagnose_usage(error)


def _diagnose_system(error: OSError) -> tuple[ExitCode, str]:
    where = f"{error.filename}: " if error.filename else ""
    if error.errno in _FULL:
        return ExitCode.RESOURCES, f"{where}{error.strerror}: free some space or write elsewhere"
    return ExitCode.ARGUMENTS, f"{where}{error.strerror or error}"


def _diagnose_usage(error: BaseException) -> tuple[ExitCode, str]:
    import typer

    # typer exports this one class of its hierarchy; its base is what unknown options and commands raise.
    usage = typer.BadParameter.__mro__[1]
    if isinstance(error, typer.Abort):
        return ExitCode.INTERRUPTED, "interrupted"
    if not isinstance(error, usage):
        kind = type(error).__name__
        return ExitCode.FAULT, f"internal error, {kind}: {error}; please report it with what RADIOSITY_DEBUG=1 shows"
    message = error.format_message()  # type: ignore[attr-defined]
    command = getattr(getattr(error, "ctx", None), "command_path", "radiosity")
    # Without any arguments the help is shown and there is no more to say.
    return ExitCode.ARGUMENTS, f"{message} (see {command} --help)" if message else ""
