"""What the commands that drive vehicles share: options for vehicles and what they meet, and how robots are told of."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from taut.cli.options import named_numbers

if TYPE_CHECKING:
    from taut.simulation import Disturbances

FEW_ROBOTS = 10  # of more only the worst are told without being asked for
MISSING = "–"


class VehicleKind(StrEnum):
    """What the robots drive."""

    differential = "differential"
    unicycle = "unicycle"
    ackermann = "ackermann"
    integrator = "integrator"


def disturbances(
    speed_error: float,
    stops: float,
    stop_seconds: float,
    slow: Sequence[str] | None,
    dies: Sequence[str] | None,
    position_noise: float,
    heading_noise: float,
    slip: float,
) -> Disturbances:
    """Return what the options say that the vehicles meet.

    Raises
    ------
    typer.BadParameter
        A robot is not given as NAME@NUMBER.
    SceneError
        A number that makes no sense.
    """
    from taut.simulation import Disturbances

    return Disturbances(
        speed_error=speed_error,
        stops=stops,
        stop_seconds=stop_seconds,
        slow=named_numbers(slow, "--slow"),
        dies=named_numbers(dies, "--dies"),
        position_noise=position_noise,
        heading_noise=heading_noise,
        slip=slip,
    )


VehicleOption: TypeAlias = Annotated[VehicleKind, typer.Option(help="What the robots drive.")]
StepOption: TypeAlias = Annotated[float, typer.Option(metavar="S", help="Seconds of a step.")]
SpeedErrorOption: TypeAlias = Annotated[
    float, typer.Option(metavar="E", help="Each robot's speed is wrong by up to so much of it, like 0.2.")
]
StopsOption: TypeAlias = Annotated[float, typer.Option(metavar="RATE", help="Random stops of each robot a second.")]
StopSecondsOption: TypeAlias = Annotated[float, typer.Option(metavar="S", help="Mean length of a random stop.")]
SlowOption: TypeAlias = Annotated[
    list[str] | None, typer.Option(metavar="NAME@F", help="A robot that reaches only F of its top speed, like 0.5.")
]
DiesOption: TypeAlias = Annotated[
    list[str] | None, typer.Option(metavar="NAME@T", help="A robot that stops for good at T seconds.")
]
PositionNoiseOption: TypeAlias = Annotated[
    float, typer.Option(metavar="M", help="Robots know their place up to so much (σ, metres).")
]
HeadingNoiseOption: TypeAlias = Annotated[
    float, typer.Option(metavar="RAD", help="Robots know their heading up to so much (σ, radians).")
]
SlipOption: TypeAlias = Annotated[float, typer.Option(metavar="S", help="Wheels slip by so much of their speed (σ).")]
RobotsOption: TypeAlias = Annotated[
    bool, typer.Option("--robots", help=f"Tell of every robot, also of more than {FEW_ROBOTS}.")
]
