# SPDX-License-Identifier: BSD-3-Clause
"""After a power cut a run resumes to the same bits, or says that there is nothing to resume."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from power_cuts import WAYS, record, restore, states
from resumed_runs import assert_same_results, checkpoint_of
from unlucky_runs import command, demanding, hidden_files, moments, write_case

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An undisturbed run whose disk is recorded in the folder `journal` beside it."""
    place = tmp_path_factory.mktemp("recorded")
    case, folder = write_case(demanding(6), place / "block.toml"), place / "whole"
    arguments: list[str | Path] = ["run", case, "--out", folder, "--quiet"]
    code, text = command(arguments, place / "screen", record, folder, place / "journal")
    assert (code, text) == (0, "")
    return folder


@pytest.mark.parametrize("moment", moments(4, seed=5).tolist())
@pytest.mark.parametrize("way", WAYS)
def test_power_cut(way: str, moment: float, whole: Path, tmp_path: Path) -> None:
    cut_and_resume(way, moment, whole, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("moment", moments(40, seed=6).tolist())
@pytest.mark.parametrize("way", WAYS)
def test_power_cut_often(way: str, moment: float, whole: Path, tmp_path: Path) -> None:
    cut_and_resume(way, moment, whole, tmp_path)


def cut_and_resume(way: str, moment: float, whole: Path, place: Path) -> None:
    journal, folder = whole.with_name("journal"), place / "out"
    recorded = states(journal)
    number = int(moment * len(recorded))
    restore(journal, recorded[number], way, np.random.default_rng(number), folder)
    code, text = command(["resume", folder, "--quiet"], place / "screen")
    if checkpoint_of(folder).exists():
        assert (code, text) == (0, "")
        assert_same_results(whole, folder)
        assert hidden_files(folder) == []
    else:
        assert code == 2, text


def test_the_recorded_disk_forgets_what_was_not_synchronised(whole: Path) -> None:
    """So the comparison can fail: rows of the history are lost at some moments."""
    durable, names, synchronised, present = states(whole.with_name("journal"))[-1]
    assert set(names) <= set(durable)
    log = str(names["log.txt"])
    assert synchronised.get(log) != present[log]
    for name in ("history.csv", "results.vtkhdf", "checkpoint.npz", "model.json"):
        assert synchronised[str(names[name])] == present[str(names[name])]
