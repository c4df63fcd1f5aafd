# SPDX-License-Identifier: BSD-3-Clause
"""Requests to stop: Ctrl-C, SIGTERM (a queue, a shutdown), SIGHUP (a terminal that is closed).

All three raise KeyboardInterrupt, in the main thread only, since Python has signals only there.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from contextlib import ContextDecorator
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self

SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)

REPEAT_AFTER = 0.01  # [s]


class StopSignals(ContextDecorator):
    """Within this context (or the decorated function) a request to stop raises KeyboardInterrupt.

    The handlers from before are restored at the end. A signal that is ignored (as by ``nohup``), or
    for which the calling program has a handler of its own, keeps that. Outside the main thread
    nothing is changed. The text of the KeyboardInterrupt is the name of the signal, empty for
    Ctrl-C.

    Attributes:
        requested: whether there was a request to stop, also one that an inner context received: a
            library may turn the KeyboardInterrupt into an error of its own.
    """

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}
        self._hook_before: Callable[[sys.UnraisableHookArgs], Any] | None = None

    def _recreate_cm(self) -> Self:
        return type(self)()

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                before = signal.getsignal(number)
                if _can_be_replaced(before):
                    self._before[number] = before
                    signal.signal(number, self._receive)
            self._hook_before, sys.unraisablehook = sys.unraisablehook, self._repeat
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._hook_before is not None:
            sys.unraisablehook = self._hook_before
        for number, before in self._before.items():
            signal.signal(number, before)
            outer = getattr(before, "__self__", None)
            if isinstance(outer, StopSignals):
                outer.requested |= self.requested

    def pause(self) -> None:
        """Gives the handlers from before back until `go_on`, while code of the caller runs."""
        self.__exit__(None, None, None)

    def go_on(self) -> None:
        """Takes the signals again after `pause`; the caller may have other handlers by now."""
        self._before.clear()
        self._hook_before = None
        self.__enter__()

    def _receive(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        raise _interrupt(number)

    def _repeat(self, ignored: sys.UnraisableHookArgs) -> None:
        """Repeats a request whose KeyboardInterrupt came where Python ignores exceptions.

        Such places are finalizers and callbacks of weak references, which libraries have.
        """
        if isinstance(ignored.exc_value, KeyboardInterrupt):
            name = str(ignored.exc_value) or "SIGINT"
            number = signal.Signals[name]
            threading.Timer(REPEAT_AFTER, _thread.interrupt_main, (number,)).start()
        elif self._hook_before is not None:
            self._hook_before(ignored)


class DeferredStop(StopSignals):
    """As `StopSignals`, but a request is only noted; `check` raises the KeyboardInterrupt.

    So a run stops between two Newton iterations and never while a file is written. A second Ctrl-C
    acts at once. What comes after the KeyboardInterrupt is ignored, so that the files are closed
    in order.
    """

    def __init__(self) -> None:
        super().__init__()
        self._noted: int | None = None
        self._raised = False

    def _receive(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if self._noted is None:
            self._noted = number
        elif number == signal.SIGINT:
            self.check()

    def check_all(self, greatest: Callable[[float], float]) -> None:
        """As `check` of a run of several processes: in all of them if one has a request.

        greatest: returns the largest of the numbers that the processes give it.
        """
        noted = int(greatest(float(self._noted or 0)))
        if noted:
            self._noted = noted
            self.check()

    def check(self) -> None:
        """Raises KeyboardInterrupt, once, if a request to stop has come."""
        if self._noted is not None and not self._raised:
            self._raised = True
            raise _interrupt(self._noted)


def ignore_stop_signals() -> None:
    """Ignores further requests to stop, for the last moments of a process."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _interrupt(number: int) -> KeyboardInterrupt:
    if number == signal.SIGINT:
        return KeyboardInterrupt()
    return KeyboardInterrupt(signal.Signals(number).name)


def _can_be_replaced(handler: Any) -> bool:
    """Whether a handler is one of Python's own, or of an outer `StopSignals`."""
    if handler in (signal.SIG_DFL, signal.default_int_handler):
        return True
    return isinstance(getattr(handler, "__self__", None), StopSignals)
