# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of results for papers: fields, lines, histories."""
