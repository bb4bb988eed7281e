"""The commands under one roof."""

from __future__ import annotations

from typing import Annotated

import typer

from radiosity.cli import check, comparison, demo, design, factors, render, scenes, solve, view

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 done, 2 bad arguments, 3 bad input file, 4 accuracy not reached within the limits "
    "or targets missed, 5 out of memory or disk, 130 interrupted.",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from radiosity import __version__

        print(f"radiosity {__version__}")
        raise typer.Exit


@app.callback()
def _radiosity(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """The equilibrium of diffuse light and heat, to the accuracy you ask for."""


app.command("solve")(solve.solve)
app.command("design")(design.design)
app.command("render")(render.render)
app.command("view")(view.view)
app.command("factors")(factors.factors)
app.command("check")(check.check)
app.command("compare")(comparison.compare)
app.command("demo")(demo.demo)
app.command("scenes")(scenes.scenes)
