"""The command line as a whole: its global options, and how every failure becomes one line and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from typing import Annotated, Any, TextIO, cast

import typer

from taut.cli import (
    INTERRUPTED,
    compare_command,
    graph_command,
    plan_commands,
    replan_command,
    scene_commands,
    simulate_command,
    steer_command,
    studio_command,
    travel_command,
)
from taut.cli.output import printable, say_error
from taut.errors import NoPlanExists, NoPlanFound, OutputError, TautError

INTERNAL_ERROR = 70
BROKEN_PIPE = 141

app = typer.Typer(
    name="taut",
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Certified motion plans for robot teams on 2D maps. SCENE is a file or the name of a ready scene.",
    epilog="Exit codes: 0 done, 1 no plan or it does not hold, 2 bad input, 130 interrupted.",
)
app.command("plan")(plan_commands.plan)
app.command("replan")(replan_command.replan)
app.command("travel")(travel_command.travel)
app.command("simulate")(simulate_command.simulate)
app.command("steer")(steer_command.steer)
app.command("studio")(studio_command.studio)
app.command("verify")(plan_commands.verify)
app.command("check")(scene_commands.check)
app.command("show")(plan_commands.show)
app.command("graph")(graph_command.graph)
app.command("compare")(compare_command.compare)
app.command("random")(scene_commands.random)
app.command("random-warehouse")(scene_commands.random_warehouse)
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


def run(argv: Sequence[str]) -> int:
    """Run one command line and return its exit code, see `taut.cli.main`."""
    for stream in (sys.stdout, sys.stderr):
        # A Windows console of an old code page cannot print every name: print "?" rather than fail.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    debug = "--debug" in argv
    stdout = sys.stdout
    try:
        with warnings.catch_warnings(), redirect_stdout(cast("TextIO", _Stdout(stdout))):
            # What libraries remark about odd numbers is not for the people who run the command.
            warnings.simplefilter("default" if debug else "ignore")
            code = _run([word for word in argv if word != "--debug"], debug)
            sys.stdout.flush()
    except BrokenPipeError:
        sys.stdout = _silenced(stdout)
        return BROKEN_PIPE
    except _StdoutFull as error:
        code = _fail(str(error), error.exit_code, debug)
        sys.stdout = _silenced(stdout)
    return code


class _StdoutFull(OutputError):
    """What was to be printed could not be."""


class _Stdout:
    """Stdout whose errors say that it was stdout; a pipe that nobody reads stays a `BrokenPipeError`."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        with _naming_stdout():
            return self._stream.write(text)

    def flush(self) -> None:
        with _naming_stdout():
            self._stream.flush()


@contextmanager
def _naming_stdout() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _StdoutFull(f"cannot write to stdout: {error.strerror or error}") from error


def _run(words: list[str], debug: bool) -> int:
    try:
        # Not the stand-alone call: that one prints usage in boxes of several lines and turns Ctrl-C into exit code 1.
        command = typer.main.get_command(app)
        with command.make_context("taut", words, obj={"debug": debug}) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except (BrokenPipeError, _StdoutFull):
        raise
    except (Exception, KeyboardInterrupt) as error:
        return _explained(error, debug)
    return 0


def _explained(error: BaseException, debug: bool) -> int:
    """Say in one line why a command ended, and return its exit code."""
    if isinstance(error, typer.Abort) or _was_interrupted(error):
        return _fail("interrupted", INTERRUPTED, debug)
    if isinstance(error, NoPlanExists | NoPlanFound):
        # under the line that says it, why and what may help
        return _fail(str(error), error.exit_code, debug, error.diagnosis)
    if isinstance(error, TautError):
        return _fail(str(error), error.exit_code, debug)
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        return _fail(f"{place}{error.strerror or error}", 2, debug)
    if isinstance(error, MemoryError):
        return _fail("out of memory", INTERNAL_ERROR, debug)
    if hasattr(error, "format_message"):  # a wrong command line; typer does not export the class of all of them
        return _fail(f"{error.format_message()} (see: {_help_words(error)})", 2, debug)
    what = f"{type(error).__name__}: {error}"
    hint = "" if debug else "; --debug shows where"
    return _fail(f"internal error, please report it{hint}: {what}", INTERNAL_ERROR, debug)


def _was_interrupted(error: BaseException) -> bool:
    """Whether Ctrl-C began it: compiled code and failing clean-up put other errors on top of the interrupt."""
    known: BaseException | None = error
    for _ in range(20):
        if known is None or isinstance(known, KeyboardInterrupt):
            break
        known = known.__cause__ or known.__context__
    return isinstance(known, KeyboardInterrupt)


def _help_words(error: BaseException) -> str:
    context = getattr(error, "ctx", None)
    return f"{context.command_path} --help" if context is not None else "taut --help"


def _fail(message: str, code: int, debug: bool, more: Sequence[str] = ()) -> int:
    if debug:
        traceback.print_exc()
    try:
        say_error(message)
        for line in more:
            print(f"  {printable(line)}", file=sys.stderr)
    except OSError:
        sys.stderr = _silenced(sys.stderr)
    return code


def _silenced(stream: TextIO) -> TextIO:
    """Return a stream that takes anything; Python flushes the old one once more at exit and must not fail there."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    except (OSError, ValueError):
        return open(os.devnull, "w", encoding="utf-8")  # lives until the process ends
    return stream
