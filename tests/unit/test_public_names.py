# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the package load when they are first used."""

import pytest

import tilth


def test_every_public_name_is_there() -> None:
    pytest.importorskip("tilth._core")
    for name in tilth.__all__:
        assert getattr(tilth, name).__name__ == name
    assert set(tilth.__all__) == set(tilth._HOME)
    assert set(tilth.__all__) <= set(dir(tilth))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Modle'"):
        _ = tilth.Modle
