# SPDX-License-Identifier: BSD-3-Clause
"""The commands of `tilth`, each in a module of its name that is loaded when it is called."""
