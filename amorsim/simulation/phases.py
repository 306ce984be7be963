"""The phases of a step, for all rows, and the schedule of the calls that make them."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import AmorsimError
from amorsim.simulation.contact.contact_ends import still_near
from amorsim.simulation.contact.resolve import WALL, Contact
from amorsim.simulation.emissions import bind_emitters
from amorsim.simulation.error_context import is_finite
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.fleet.obstacles import ObstacleGroup
from amorsim.simulation.schedule import Call, walk

NO_PAIRS: frozenset[tuple[int, int]] = frozenset()

__all__ = ["calls_of", "first_look", "step"]


def step(fleet: Fleet) -> None:
    """Make one step."""
    walk(calls_of(fleet))


def calls_of(fleet: Fleet) -> Sequence[Call]:
    """The calls of a step, in order; prepared again for groups whose parameters or states were replaced."""
    unbound = [group for group in fleet.groups if not group.is_bound]
    if unbound or not fleet.calls:
        for group in unbound:
            group.bind()
        fleet.calls = tuple(_calls(fleet))
    return fleet.calls


def _calls(fleet: Fleet) -> Iterator[Call]:
    groups = fleet.groups
    for group in groups:
        yield from group.control_calls()
        if group.driver.can_report:
            yield Call("control", f"{group.label} / reports", functools.partial(_log_reports, fleet, group))
    for group in groups:
        yield from group.actuate_calls()
    for obstacles in fleet.obstacles:
        if obstacles.motion is not None:
            label = f"{obstacles.label} / motion: {type(obstacles.motion).__name__}"
            yield Call("actuate", label, obstacles.actuate)
    yield from fleet.movement.path_calls()
    yield Call("move", "contact", functools.partial(_meet, fleet))
    yield from fleet.movement.arrival_calls()
    yield Call("move", "clocks", fleet.advance)
    for group in groups:
        yield from group.place_calls()
    if fleet.has_emitters:
        yield Call("sense", "emitters", bind_emitters(groups, fleet.world))
    for group in groups:
        yield from group.sense_calls()
    for group in groups:
        yield from group.estimate_calls()
        if group.estimators.can_fail:
            yield Call("estimate", f"{group.label} / failures", functools.partial(_log_failures, fleet, group))
    for each in fleet.everything:
        yield Call("record", f"{each.label} / fingerprint", each.record)


def _touch(fleet: Fleet, touching: frozenset[tuple[int, int]], before: Array) -> None:
    """Record the pairs that touched in the step that moved all bodies from `before` to their present poses."""
    fleet.touching = touching
    if touching or fleet.contacts:
        fleet.contacts = touching | still_near(fleet.world, fleet.contacts - touching, before)


def first_look(fleet: Fleet) -> None:
    """Sense and estimate at the start of an episode, so that a controller never sees an empty reading."""
    fleet.tell_time()
    walk(call for call in calls_of(fleet) if call.phase in ("sense", "estimate", "record"))


def _log_reports(fleet: Fleet, group: Group) -> None:
    for row, word, value in group.driver.reports():
        fleet.log(group, row, "report", path=word, value=value)


def _meet(fleet: Fleet) -> None:
    """Move all bodies along their paths, and log what touched."""
    contacts, poses = fleet.movement.meet(), fleet.movement.end
    if not is_finite(poses):
        raise _not_finite(fleet, poses)
    for contact in contacts:
        # A contact that continues is not a new collision.
        if (contact.body, contact.other) not in fleet.contacts:
            _log_contact(fleet, contact)
    before = fleet.world.poses.copy() if contacts or fleet.contacts else poses
    fleet.world.poses = poses
    _touch(fleet, frozenset((contact.body, contact.other) for contact in contacts) if contacts else NO_PAIRS, before)


def _not_finite(fleet: Fleet, poses: Array) -> AmorsimError:
    """The error for a pose that is nan or inf: of a robot, a part of one or an obstacle."""
    world = fleet.world
    body = int(np.flatnonzero(~np.isfinite(poses).all(axis=1))[0])
    group, row = fleet.row_of(int(world.owner[body]))
    what, component = ("drive", group.drive) if isinstance(group, Group) else ("motion", group.motion)
    _, part = world.whose(body)
    rows = np.zeros((len(group.bodies), 3))
    rows[row] = poses[body]
    return group.whose.not_finite(what, component, f"the pose of {part!r}" if part else "the pose", rows)


def _log_failures(fleet: Fleet, group: Group) -> None:
    """Log an event for each estimator whose numbers exploded, and one for a controller that ends by it."""
    for name, row, ends in group.estimators.failures():
        if ends and not group.driver.is_driving(row):
            continue
        fleet.log(group, row, "estimator_failed", path=f"estimators.{name}")
        if ends:
            fleet.end_controller(group, row)


def _speed(fleet: Fleet, group: Group | ObstacleGroup, row: int, body: int, contact: Contact) -> float:
    """Speed [m/s] of a body at contact: of its base point, or of a part's point of contact."""
    if isinstance(group, Group) and group.parts is not None and body not in group.bodies:
        return group.parts.speed_at(body, contact.point, contact.fraction)
    mover = group.locomotion if isinstance(group, Group) else group
    return float(mover.travel()[row, 0] / fleet.dt)


def _log_contact(fleet: Fleet, contact: Contact) -> None:
    """Log an event for each body in the contact, and one for each controller that ends by it."""
    world = fleet.world
    for body, other in ((contact.body, contact.other), (contact.other, contact.body)):
        if body == WALL:
            continue
        _, part = world.whose(body)
        other_name, other_part = ("wall", "") if other == WALL else world.whose(other)
        group, row = fleet.row_of(int(world.owner[body]))
        met = {"other": other_name, "part": part, "other_part": other_part, "point": contact.point}
        speed = _speed(fleet, group, row, body, contact)
        fleet.log(group, row, "collision", contact.fraction, **met, speed=speed)
        if isinstance(group, Group) and group.ends_on_collision and group.driver.is_driving(row):
            fleet.end_controller(group, row, contact.fraction)
