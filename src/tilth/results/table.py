# SPDX-License-Identifier: BSD-3-Clause
"""The history of a run as a table of columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.plot.extras import require_extra
from tilth.plot.names import column_of

T = TypeVar("T")


class UnknownColumn(BadInput, KeyError):
    """There is no such column; also a ``KeyError``, as of any other mapping."""


class ByHeading(Mapping[str, T]):
    """What belongs to the columns of ``history.csv``, by heading (``name [unit]``).

    A column is also found by its name without the unit. Any other name raises ``BadInput`` with
    those near it.
    """

    def __init__(self, columns: Mapping[str, T]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> T:
        try:
            return self._columns[column_of(list(self._columns), name)]
        except BadInput as error:
            raise UnknownColumn.of(error.problems) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return repr(self._columns)


class History(ByHeading[Floats]):
    """Columns of ``history.csv``, each of shape (rows,), see `ByHeading`."""

    @property
    def rows(self) -> int:
        """Number of rows: the initial state and one for each step."""
        return len(self["step"])

    def to_pandas(self) -> Any:
        """Returns a ``pandas.DataFrame`` with the columns, one row per step.

        Raises ``BadInput`` if pandas is not installed.
        """
        return require_extra("pandas").DataFrame(self._columns)

    def __repr__(self) -> str:
        return f"<History: {self.rows} rows, columns {', '.join(self)}>"
