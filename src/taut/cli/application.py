"""The command line as a whole: its global options, and how every failure becomes one line and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer

from taut.cli import plan_commands, scene_commands
from taut.cli.output import printable
from taut.errors import TautError

INTERNAL_ERROR = 70
INTERRUPTED = 130
BROKEN_PIPE = 141

app = typer.Typer(
    name="taut",
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Certified motion plans for robot teams on 2D maps. SCENE is a file or the name of a ready scene.",
    epilog="Exit codes: 0 done, 1 no plan or it does not hold, 2 bad input, 130 interrupted.",
)
app.command("plan")(plan_commands.plan)
app.command("verify")(plan_commands.verify)
app.command("check")(scene_commands.check)
app.command("show")(plan_commands.show)
app.command("graph")(scene_commands.graph)
app.command("random")(scene_commands.random)
app.command("scenes")(scene_commands.scenes)
app.command("warmup")(scene_commands.warmup)


def _print_version(wanted: bool) -> None:
    if wanted:
        import taut

        typer.echo(f"taut {taut.__version__}")
        raise typer.Exit()


@app.callback(invoke_without_command=True)
def _global_options(
    context: typer.Context,
    debug: Annotated[
        bool, typer.Option("--debug", help="Show the traceback of an error (anywhere on the line).")
    ] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(2)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line.

    Parameters
    ----------
    argv : the words after ``taut``; None takes those of the process.

    Returns
    -------
    The exit code: 0 done, 1 no plan exists, none was found or one does not hold, 2 bad input, 70 an error inside taut,
    130 interrupted, 141 nobody reads the output any more.
    """
    for stream in (sys.stdout, sys.stderr):
        # A Windows console of an old code page cannot print every name: print "?" rather than fail.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    words = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    try:
        code = _run(words, debug)
        sys.stdout.flush()
    except BrokenPipeError:
        _silence_stdout()
        return BROKEN_PIPE
    return code


def _run(words: list[str], debug: bool) -> int:
    try:
        # Not the stand-alone call: that one prints usage in boxes of several lines and turns Ctrl-C into exit code 1.
        command = typer.main.get_command(app)
        with command.make_context("taut", words) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except TautError as error:
        return _fail(str(error), error.exit_code, debug)
    except (KeyboardInterrupt, typer.Abort):
        return _fail("interrupted", INTERRUPTED, debug)
    except BrokenPipeError:
        raise
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _fail(f"{place}{error.strerror or error}", 2, debug)
    except MemoryError:
        return _fail("out of memory", INTERNAL_ERROR, debug)
    except Exception as error:
        if hasattr(error, "format_message"):  # a wrong command line; typer does not export the class of all of them
            return _fail(f"{error.format_message()} (see: {_help_words(error)})", 2, debug)
        what = f"{type(error).__name__}: {error}"
        hint = "" if debug else "; --debug shows where"
        return _fail(f"internal error, please report it{hint}: {what}", INTERNAL_ERROR, debug)
    return 0


def _help_words(error: Exception) -> str:
    context = getattr(error, "ctx", None)
    return f"{context.command_path} --help" if context is not None else "taut --help"


def _fail(message: str, code: int, debug: bool) -> int:
    if debug:
        traceback.print_exc()
    print(f"taut: error: {printable(message)}", file=sys.stderr)
    return code


def _silence_stdout() -> None:
    # Python flushes stdout once more at exit and would complain about the closed pipe there.
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # lives until the process ends
