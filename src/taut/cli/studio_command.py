"""The command studio."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from taut.cli.output import say


def studio(
    context: typer.Context,
    scene: Annotated[
        str | None,
        typer.Argument(metavar="SCENE", help="A scene file, also one to be made, a plan, or a ready scene's name."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="Port of this machine; if not given, the same one each time for a scene."),
    ] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
) -> None:
    """Open the studio in the browser: draw a map, drag robots, watch the team plan itself."""
    from taut.studio.scene_file import Named, named
    from taut.studio.serving import serve

    source = scene or ""
    first = named(source) if source else Named("")

    def tell(address: str) -> None:
        say(f"studio: {address}")
        if first.file is not None:
            new = "" if first.value is not None else " (new: made when you save)"
            say(f"file:   {first.file.path}{new}")
        say("Ctrl-C ends it; what you draw is kept in the browser")
        sys.stdout.flush()

    serve(source, first, port, not no_browser, bool(context.obj and context.obj.get("debug")), tell)
    say("studio: ended")
