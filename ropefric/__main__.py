"""The door of the program (`ropefric`, `python -m ropefric`): what concerns the process, before all else."""

import os
import signal
import sys
from types import FrameType

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


def main() -> int:
    """Run the command line of this process and return its exit code."""
    _listen(_leave)
    _open_closed_streams()
    from ropefric.cli.app import main as run  # noqa: PLC0415  (an interrupt may come from the first line on)

    for stream in (sys.stdout, sys.stderr):  # a terminal that cannot show φ must not end the work
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        return run(sys.argv[1:], on_start=_begin)
    finally:
        _listen(signal.SIG_DFL)


def _begin() -> None:
    """Prepare for a command's work, which has something to clean up, and libraries that log."""
    import logging  # noqa: PLC0415  (quick start-up)

    # What they log is for no reader of ours; without a handler it would go to stderr.
    logging.getLogger().addHandler(logging.NullHandler())
    _listen(_interrupt)


def _listen(handler: object) -> None:
    for number in _SIGNALS:
        if (
            signal.getsignal(number) != signal.SIG_IGN
        ):  # as nohup, or a shell for its background jobs, wants it
            signal.signal(number, handler)  # type: ignore[arg-type]


def _leave(number: int, _: FrameType | None) -> None:
    """End at once: no work has begun, and a module being loaded may turn an exception into another."""
    os.write(2, b"error RF001  interrupted\n")
    os._exit(128 + number)


def _interrupt(number: int, _: FrameType | None) -> None:
    """End in order: every signal as Ctrl-C does, its number with it. Worker processes, forked, just end."""
    if os.getpid() != _PROCESS:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    raise KeyboardInterrupt(*(() if number == signal.SIGINT else (number,)))


_PROCESS = os.getpid()


def _open_closed_streams() -> None:
    """Let streams that were closed (`2>&-`) lead to nothing; else the next file opened would take their place."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
            setattr(sys, name, open(number, "r" if number == 0 else "w", encoding="utf-8"))  # noqa: PTH123, SIM115


if __name__ == "__main__":
    sys.exit(main())
