"""What can go wrong, told to people: what is wrong, where, and what to do about it."""

from __future__ import annotations

import math
from collections.abc import Sequence


def one_line(text: str) -> str:
    """Return the text with line breaks and other unprintable characters written as escapes."""
    return text if text.isprintable() else "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def rounded_down(x: float) -> str:
    """Return a number ≥ 0 cut to four digits, for texts that say what is allowed at most."""
    unit = 10.0 ** (math.floor(math.log10(x)) - 3) if x > 0 else 1.0
    return f"{math.floor(x / unit) * unit:g}"


class TautError(Exception):
    """Base of every error that taut raises on purpose; its text is one line fit to be shown to a user.

    ``exit_code`` is what the command line ends with: 2 for bad input, 1 for "no plan or path".
    """

    exit_code = 2

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class SceneError(TautError):
    """A scene that cannot be used; the text names the robot or obstacle and the mend.

    Parameters
    ----------
    message : what is wrong and what to do, without the place.
    file : the file it was read from, if any.
    line : 1-based line of that file, if known.
    """

    def __init__(self, message: str, file: str | None = None, line: int | None = None) -> None:
        self.message = one_line(message)
        self.file = file
        self.line = line
        place = "" if file is None else f"{file}: " if line is None else f"{file}:{line}: "
        super().__init__(place + message)

    def at(self, file: str, line: int | None = None) -> SceneError:
        """Return the same error with the place in the file filled in (a known line is kept)."""
        error = type(self).__new__(type(self))
        error.__dict__.update(self.__dict__)
        SceneError.__init__(error, self.message, file, self.line if line is None else line)
        return error


class StartBlocked(SceneError):
    """A robot's start is not in its free space."""


class GoalBlocked(SceneError):
    """A robot's goal is not in its free space."""


class PlanError(SceneError):
    """A plan file or a Plan value that cannot be read as a plan."""


class OutputError(TautError):
    """A result that cannot be written: unwritable path, unknown picture format, missing encoder."""


class NoPath(TautError):
    """There is no path for one robot; ``reason`` says why in words."""

    exit_code = 1

    def __init__(self, robot: str, reason: str) -> None:
        self.robot = robot
        self.reason = reason
        super().__init__(f"{robot}: {reason}" if robot else reason)


class NoPlanFound(TautError):
    """No plan for the team was found within the rounds or seconds given.

    Parameters
    ----------
    reason : what was tried and why it stopped, in words.
    robots : the robot that failed first, then the robots in its way.
    time : seconds at which it got no further, if known.
    place : (x, y) in metres of that point, if known.
    diagnosis : why, and what may help, in sentences for people; see `taut.team.diagnosis`.
    """

    exit_code = 1

    def __init__(
        self,
        reason: str,
        robots: Sequence[str] = (),
        time: float | None = None,
        place: tuple[float, float] | None = None,
        diagnosis: Sequence[str] = (),
    ) -> None:
        self.reason = reason
        self.robots = tuple(robots)
        self.time = time
        self.place = place
        self.diagnosis = tuple(one_line(sentence) for sentence in diagnosis)
        super().__init__(reason)


class NoPlanExists(TautError):
    """It is proved that no plan for the team exists, whatever the roadmap, the speeds and the time given.

    Parameters
    ----------
    reason : why, in words.
    robots : the two that cannot both reach their goals.
    place : (x, y) in metres where they are in each other's way, if known.
    diagnosis : more on why, and what would help, in sentences for people; see `taut.team.impossibility`.
    """

    exit_code = 1

    def __init__(
        self,
        reason: str,
        robots: Sequence[str] = (),
        place: tuple[float, float] | None = None,
        diagnosis: Sequence[str] = (),
    ) -> None:
        self.reason = reason
        self.robots = tuple(robots)
        self.place = place
        self.diagnosis = tuple(one_line(sentence) for sentence in diagnosis)
        super().__init__(reason)
