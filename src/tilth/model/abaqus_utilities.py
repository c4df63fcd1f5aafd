# SPDX-License-Identifier: BSD-3-Clause
"""Libraries of UMATs, with those of Abaqus' utility routines that tilth provides.

The routines are in a library of their own (cpp/tilth/abaqus/utilities.cpp), which is loaded only
before a library that calls one of them.
"""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

from tilth import _core
from tilth.errors import BadInput
from tilth.input_files import absolute, require_file

PROVIDED = ("XIT", "SINV", "SPRINC", "SPRIND", "ROTSIG", "STDB_ABQERR")
"""Routines that tilth provides."""

NOT_PROVIDED = (
    "GETVRM", "GETVRMAVGATNODE", "GETVRN", "GETNODETOELEMCONN", "GETELEMNUMBERUSER",
    "GETPARTINFO", "GETINTERNAL", "GETJOBNAME", "GETOUTDIR", "GETENVVAR", "GETNUMCPUS",
    "GETRANK", "GETCOMMUNICATOR", "GETNUMTHREADS", "GET_THREAD_ID", "IGETSENSORID",
    "GETSENSORVALUE", "DBFILE", "DBFILW", "POSFIL", "XPLB_EXIT", "XPLB_ABQERR",
    "VGETJOBNAME", "VGETOUTDIR", "VGETNUMCPUS", "VGETRANK", "VSPRINC", "VSPRIND",
    "MUTEXINIT", "MUTEXLOCK", "MUTEXUNLOCK", "SETTABLECOLLECTION", "QUERYTABLECOLLECTION",
    "GETPARAMETERTABLE", "GETPROPERTYTABLE",
)  # fmt: skip
"""Others of Abaqus, besides those of arrays in memory, whose names begin with SMA."""

LIBRARY = Path(__file__).parents[1] / "_abaqus.so"

_UNDEFINED = re.compile(r"undefined symbol: (\w+)|symbol not found[^']*'_?(\w+)'")


def load_umat(file: Path, key: str, value: str) -> ctypes.CDLL:
    """Returns the library of a UMAT.

    Args:
        file: the library.
        key: of its material in the case file, for messages.
        value: the library as declared.

    Raises:
        BadInput: it cannot be loaded, or calls a routine that is not there.
    """
    try:
        require_file(file)
        return _loaded(file, key)
    except OSError as error:
        if _missing(error) not in PROVIDED:
            raise _not_loaded(error, key, value) from None
    try:
        utilities = ctypes.CDLL(str(LIBRARY), mode=ctypes.RTLD_GLOBAL)
    except OSError as error:
        what = f"calls Abaqus' utility routines, and tilth's library of them is not there: {error}"
        remedy = "install tilth again, or copy _abaqus.so of its build beside the compiled core"
        raise BadInput(what, remedy, key=f"{key}.library", value=value) from None
    try:
        library = _loaded(file, key)
    except OSError as error:
        raise _not_loaded(error, key, value) from None
    utilities.tilth_name_material(str(absolute(file)).encode(), key.encode())
    return library


def _loaded(file: Path, key: str) -> ctypes.CDLL:
    with _core.UserCode(f"the library `{file.name}` ({key})"):
        return ctypes.CDLL(str(absolute(file)))


def _symbol(error: OSError) -> str:
    found = _UNDEFINED.search(str(error))
    return "" if found is None else found[1] or found[2]


def _missing(error: OSError) -> str:
    """Returns the name of the routine that a library lacks, in capital letters; "" for no such."""
    return _symbol(error).rstrip("_").upper()


def _not_loaded(error: OSError, key: str, value: str) -> BadInput:
    name, symbol = _missing(error), _symbol(error)
    what = f"cannot be loaded: {error}"
    remedy = (
        "compile it as a shared library: gfortran -O2 -shared -fPIC -o libumat.so umat.f, "
        "or the same with gcc; gfortran is in the package of this name"
    )
    if name in NOT_PROVIDED or name.startswith("SMA"):
        what = f"calls {name} (`{symbol}`), a utility routine of Abaqus that tilth does not provide"
        remedy = (
            "take the call out, or add a routine of this name to the library; tilth provides "
            f"{', '.join(PROVIDED)}"
        )
    elif symbol:
        what = f"calls `{symbol}`, which is in no library"
        remedy = "compile the file that has it into this library, too, or link it with -l"
    return BadInput(what, remedy, key=f"{key}.library", value=value)
