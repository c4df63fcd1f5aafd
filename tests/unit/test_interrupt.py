# SPDX-License-Identifier: BSD-3-Clause
"""Signals: what they do within a run, and that the handlers from before are restored."""

from __future__ import annotations

import os
import signal
import threading
import time
import weakref
from collections.abc import Iterator
from typing import Any

import pytest

from tilth.interrupt import SIGNALS, DeferredStop, StopSignals


@pytest.fixture(autouse=True)
def handlers() -> Iterator[dict[int, Any]]:
    """The default handlers, which each test must find again at its end."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    defaults = {number: signal.getsignal(number) for number in SIGNALS}
    yield defaults
    left = {number: signal.getsignal(number) for number in SIGNALS}
    for number, handler in before.items():
        signal.signal(number, handler)
    assert left == defaults


def send(number: int) -> None:
    os.kill(os.getpid(), number)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_request_to_stop_is_a_keyboard_interrupt(number: int) -> None:
    with pytest.raises(KeyboardInterrupt) as error, StopSignals():
        send(number)
    assert str(error.value) == ("" if number == signal.SIGINT else signal.Signals(number).name)


def test_a_function_can_be_decorated() -> None:
    @StopSignals()
    def stopped() -> None:
        send(signal.SIGTERM)

    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            stopped()


@pytest.mark.parametrize("number", SIGNALS)
def test_a_deferred_stop_waits_for_the_check(number: int) -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), StopSignals(), DeferredStop() as stop:
        stop.check()
        send(number)
        done.append("a file is written")
        try:
            stop.check()
        finally:
            for again in SIGNALS:  # the files are closed in order all the same
                send(again)
            done.append("the files are closed")
    assert done == ["a file is written", "the files are closed"]


def test_only_a_second_interrupt_key_acts_at_once() -> None:
    with pytest.raises(KeyboardInterrupt), DeferredStop():
        for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGHUP):
            send(number)
        send(signal.SIGINT)
        pytest.fail("the key was ignored")


def test_handlers_of_the_program_and_ignored_signals_stay() -> None:
    """As a program that saves its own state at SIGTERM, started by `nohup`."""
    received = []
    signal.signal(signal.SIGTERM, lambda number, frame: received.append(number))
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with StopSignals(), DeferredStop() as stop:
        send(signal.SIGTERM)
        send(signal.SIGHUP)
        stop.check()
    assert received == [signal.SIGTERM]
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def test_other_threads_change_no_handler(handlers: dict[int, Any]) -> None:
    seen = {}

    def look() -> None:
        with StopSignals(), DeferredStop() as stop:
            seen.update({number: signal.getsignal(number) for number in SIGNALS})
            stop.check()

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert seen == handlers


@pytest.mark.parametrize("inner", [StopSignals, DeferredStop])
def test_a_request_is_known_where_a_library_hides_it(inner: type[StopSignals]) -> None:
    """As pydantic does: the KeyboardInterrupt becomes an error of its own."""
    with StopSignals() as stop:
        with pytest.raises(RuntimeError), inner() as within:
            try:
                send(signal.SIGTERM)
                if isinstance(within, DeferredStop):
                    within.check()
            except KeyboardInterrupt as interrupt:
                raise RuntimeError("in a library") from interrupt
        assert stop.requested
    assert not StopSignals().requested


@pytest.mark.parametrize("number", SIGNALS)
def test_a_request_in_a_callback_of_a_library_is_not_lost(number: int) -> None:
    """Python ignores what is raised in callbacks of weak references, as matplotlib has them."""
    with pytest.raises(KeyboardInterrupt) as error, StopSignals():
        watched = threading.Event()
        keep = weakref.ref(watched, lambda _: send(number))
        del watched
        assert keep() is None
        for _ in range(1000):
            time.sleep(0.01)
    assert str(error.value) == ("" if number == signal.SIGINT else signal.Signals(number).name)
