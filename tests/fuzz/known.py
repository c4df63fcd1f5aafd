# SPDX-License-Identifier: BSD-3-Clause
"""Faults that are known and not yet mended: beginnings of their causes, as the fuzzer names them.

Whoever mends a fault deletes its line. A new fault fails the test.
"""

KNOWN: tuple[str, ...] = ()
