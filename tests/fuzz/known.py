# SPDX-License-Identifier: BSD-3-Clause
"""Faults that are known and not yet mended: beginnings of their causes, as the fuzzer names them.

Whoever mends a fault deletes its line. A new fault fails the test.
"""

KNOWN: tuple[str, ...] = (
    # deep nesting, extreme numbers, lists of a thousand wrong entries
    "bug: RecursionError in case.py",
    "exit code 70 in errors.py:shown",
    "bug: OverflowError in bodies/request.py",
    "bug: OverflowError in model/placement.py",
    "message longer than 20,000 characters",
    "too slow in geometry/quadrature.py:make_quadrature",
    "too slow in model/schedule.py",
    "library's warning: report/surface_lines.py: RuntimeWarning: overflow",
    "library's warning: geometry/flat.py: RuntimeWarning: invalid value",
    "library's warning: terms/ghost.py: RuntimeWarning: divide by zero",
    "too slow in surface/tracked.py:_mark",
    # hostile texts
    "unprintable characters on the terminal",
    # a file that cannot be written further
    "crash by SIGSEGV in cli.py:run_command",
    # memory
    "bug: numpy._core._exceptions._ArrayMemoryError",
    "bug: MemoryError",
    # the summary and the picture of large models
    "too slow in report/",
    # damaged run folders
    "damaged checkpoint.npz: ",
    "damaged history.csv: ",
    "damaged results.vtkhdf: ",
    "damaged log.txt: ",
    "damaged model.json: ",
)
