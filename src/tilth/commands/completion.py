# SPDX-License-Identifier: BSD-3-Clause
"""`tilth completion`: lets the shell complete commands, options, names and files."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")
"""The shells that can complete."""


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    r"""Print the script that completes tilth's commands, options, names and files in a SHELL.

    \b
    Add one line to the file that the shell reads at its start:
      bash  ~/.bashrc                   eval "$(tilth completion bash)"
      zsh   ~/.zshrc                    eval "$(tilth completion zsh)"
      fish  ~/.config/fish/config.fish  tilth completion fish | source
    """
    made = get_completion_class(shell)
    assert made is not None
    click.echo(made(context.find_root().command, {}, "tilth", "_TILTH_COMPLETE").source())
