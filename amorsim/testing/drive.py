"""Trials of drives: their joints under commands, and whether their paths are as the engine assumes."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import Drive, Part, State
from amorsim.core.poses import compose, wrap_angle
from amorsim.core.rows import stack
from amorsim.estimators.wheels import bind_differences
from amorsim.plugins.checks import check_name
from amorsim.testing.failure import Who
from amorsim.testing.rig import DT, ROWS, STEPS, Rig, Session
from amorsim.testing.trial import Given, Outputs, Trial

__all__ = ["DriveTrial"]


_PARTS = 16  # of a step, into which a path is cut
_EXACT = 1e-12  # [m, rad] for a step of about a metre
_SETTLING = 100  # steps until a drive follows its command


class DriveTrial(Trial[Drive]):
    """Advances the joints under the rig's commands, and computes the body's motion."""

    def __init__(self, who: Who, rig: Rig, component: Drive, kin: list[Drive]) -> None:
        super().__init__(who, rig)
        self.joints, self.channels = len(component.joints), len(component.channels)
        self.rolling = sum(joint.rolls for joint in component.joints)
        names = [joint.name for joint in component.joints]
        for what, given in (("joints", names), ("channels", list(component.channels))):
            who.require(len(set(given)) == len(given) > 0, "joints", what, "names that differ, one at least", given)
        self.widths = (self.joints, self.channels, 3)
        given_parts = component.parts
        fits = isinstance(given_parts, tuple) and all(isinstance(part, Part) for part in given_parts)
        who.require(fits, "parts", "parts", "a tuple of Part", repr(given_parts))
        given = [part.name for part in given_parts]
        fits = len(set(given)) == len(given) and not any(check_name(name) for name in given)
        who.require(fits, "parts", "the names of parts", "names that differ, of letters, digits, - and _", given)
        same = all(one.parts == given_parts for one in kin)
        who.require(
            same, "parts", "parts with other numbers", "the same, as only static parameters may change them", "others"
        )
        self.parts = len(given_parts)
        random = np.random.default_rng(3)
        self.commands = random.uniform(-6.0, 6.0, (STEPS, ROWS, self.channels))
        self.twists = random.uniform(-1.0, 1.0, (ROWS, 3))
        self.fractions = random.uniform(0.0, 1.0, (STEPS, ROWS, 1))

    def begin(self, component: Drive, session: Session) -> Outputs:
        """Joints at rest, all at 0."""
        shape = (len(session.rows), self.joints)
        return {"joints": np.zeros(shape), "rates": np.zeros(shape)}

    def step(self, component: Drive, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One step of the joints, and the results of the drive's methods for it."""
        rows, index, call = len(session.rows), session.index, self.who.calling
        before, rates = carried["joints"], carried["rates"]
        command = self.commands[session.t][index]
        fraction, one = self.fractions[session.t][index], np.ones((rows, 1))
        wanted = self.twists[index]
        for name, array in (("joints", before), ("rates", rates), ("command", command), ("fraction", fraction)):
            given.add(name, array)
        given.add("twist", wanted)
        with call("advance"):
            found = component.advance(before, rates, command, DT, state, session.draws)
        pair = isinstance(found, tuple) and len(found) == 2
        self.who.require(pair, "shapes", "advance()", "joints and their rates", type(found).__name__)
        after = self.array(found[0], (rows, self.joints), "the joints of advance()")
        new_rates = self.array(found[1], (rows, self.joints), "the rates of advance()")
        given.add("joints after", after)
        finite = np.isfinite(after).all() and np.isfinite(new_rates).all()
        self.who.require(finite, "finite", "advance()", "finite numbers", "nan or inf")
        outputs: Outputs = {"joints": after, "rates": new_rates}
        with call("displacement"):
            whole = component.displacement(before, after, one)
            part = component.displacement(before, after, fraction)
        outputs["whole"] = self.array(whole, (rows, 3), "displacement()")
        outputs["part"] = self.array(part, (rows, 3), "displacement()")
        with call("twist"):
            outputs["twist"] = self.array(component.twist(before, after), (rows, 3), "twist()")
        with call("travel"):
            outputs["travel"] = self.array(component.travel(before, after), (rows, 2), "travel()")
        with call("between"):
            between = component.between(before, after, fraction)
        outputs["between"] = self.array(between, (rows, self.joints), "between()")
        with call("command_for"):
            asked = component.command_for(wanted, after)
        outputs["command_for"] = self.array(asked, (rows, self.channels), "command_for()")
        with call("rolling_radius"):
            radius = component.rolling_radius()
        outputs["radius"] = self.array(radius, (rows, self.rolling), "rolling_radius()")
        positive = (radius > 0).all() and np.isfinite(radius).all()
        self.who.require(positive, "joints", "rolling_radius()", "lengths > 0", radius[0])
        outputs |= self._facts(component, before, after)
        with call("follow"):
            followed = component.follow(after, whole)
        outputs["follow"] = self.array(followed, (rows, self.joints), "follow()")
        if self.parts:
            with call("part_poses"):
                poses = component.part_poses(outputs["follow"])
            outputs["parts"] = self.array(poses, (rows, self.parts, 3), "part_poses()")
            self.who.require(np.isfinite(poses).all(), "finite", "part_poses()", "finite numbers", "nan or inf")
            with call("part_travel"):
                ways = component.part_travel(before, after)
            outputs["part travel"] = self.array(ways, (rows, self.parts, 2), "part_travel()")
        carried["joints"], carried["rates"] = followed.copy(), new_rates.copy()
        return outputs

    def _facts(self, component: Drive, before: Array, after: Array) -> Outputs:
        """Its wheels and limits, which zones, estimators and controllers need."""
        rows, require, call = len(after), self.who.require, self.who.calling
        with call("contacts"):
            found: Any = component.contacts(after)
        outputs: Outputs = {"contacts": self.array(found, (rows, self.rolling, 2), "contacts()")}
        require(np.isfinite(found).all(), "finite", "contacts()", "finite numbers", "nan or inf")
        with call("heading_offset"):
            found = component.heading_offset(after)
        if found is not None:
            outputs["heading offset"] = self.array(found, (rows, 1), "heading_offset()")
            require(np.isfinite(found).all(), "finite", "heading_offset()", "finite angles", "nan or inf")
        with call("curvature_max"):
            found = component.curvature_max()
        if found is not None:
            outputs["curvature"] = self.array(found, (rows, 1), "curvature_max()")
            require((found > 0.0).all(), "limits", "curvature_max()", "numbers > 0 [1/m]", found.min())
        with call("top_speeds"):
            found = component.top_speeds()
        if found is not None:
            outputs["top speeds"] = self.array(found, (rows, 4), "top_speeds()")
            require((found >= 0.0).all(), "limits", "top_speeds()", "numbers >= 0, inf for no limit", found.min())
        offered: Any = getattr(component, "jacobian", None)
        if offered is not None:
            with call("jacobian"):
                found = offered(before, after)
            outputs["jacobian"] = self.array(found, (rows, 3, self.rolling), "jacobian()")
            require(np.isfinite(found).all(), "finite", "jacobian()", "finite numbers", "nan or inf")
        return outputs

    def check_paths(self, components: list[Drive]) -> None:
        """Whether displacements start at zero, agree with stops, and stay within the drive's `travel`."""
        drive, session = stack(components), Session(self.rig, np.arange(ROWS, dtype=np.int64))
        state = dict(drive.start(session.context()))
        carried = self.begin(drive, session)
        given = Given(self.who, "inputs", "")
        for t in range(STEPS):
            session.go_to(t)
            before = carried["joints"].copy()
            after = self.step(drive, session, state, carried, given)["joints"]
            nothing = drive.displacement(before, after, np.zeros((ROWS, 1)))
            worst = float(np.abs(nothing).max())
            self.who.require(worst == 0.0, "standstill", "displacement() at fraction 0", "none", f"{worst:g}")
            self._check_stops(drive, before, after, self.fractions[t])
            self._check_stops(drive, before, after, np.ones((ROWS, 1)))
            self._check_travel(drive, before, after)
            self._check_bound(drive, before, after)
            if self.parts:
                self._check_part_travel(drive, before, after)

    def _check_bound(self, drive: Drive, before: Array, after: Array) -> None:
        """Check that what binds the drive's motion gives the bits of the simple form and does not change the joints."""
        one = np.ones((ROWS, 1))
        for name, expected in (
            ("twist", drive.twist(before, after)),
            ("displacement", drive.displacement(before, after, one)),
            ("travel", drive.travel(before, after)),
        ):
            given, out = (before.copy(), after.copy()), np.full(expected.shape, np.nan)
            with self.who.calling(f"bind_{name}"):
                getattr(drive, f"bind_{name}")(*given, out)()
            same = out.tobytes() == expected.tobytes()
            self.who.require(same, "bind", f"what bind_{name}() writes", f"the bits of {name}()", "others")
            kept = given[0].tobytes() + given[1].tobytes() == before.tobytes() + after.tobytes()
            self.who.require(kept, "bind", f"the joints that bind_{name}() gets", "left as they are", "others")

    def _check_part_travel(self, drive: Drive, before: Array, after: Array) -> None:
        """Whether parts start at the poses of the joints, and stay within the drive's `part_travel`."""
        bound = (drive.part_travel(before, after) / _PARTS).reshape(-1, 2)
        last = drive.part_poses(before).reshape(-1, 3)
        for part in range(_PARTS + 1):
            fraction = np.full((ROWS, 1), part / _PARTS)
            moved = drive.displacement(before, after, fraction)
            joints = after if part == _PARTS else drive.between(before, after, fraction)
            inside = drive.part_poses(drive.follow(joints, moved)).reshape(-1, 3)
            now = compose(np.repeat(moved, self.parts, axis=0), inside)
            off = np.abs(_difference(last, now))
            last = now
            if part == 0:
                self.who.require(
                    off.max() <= _EXACT,
                    "parts",
                    "part_poses() after follow() at fraction 0",
                    "what it was before the step",
                    f"{off.max():g} beside it",
                )
                continue
            way = np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2)
            for name, found, most in (("way [m]", way, bound[:, 0]), ("turn [rad]", off[:, 2], bound[:, 1])):
                row = int(np.argmax(found - most))
                what = drive.parts[row % self.parts].name
                self.who.require(
                    found[row] <= most[row] * (1.0 + 1e-9) + _EXACT,
                    "parts",
                    f"the {name} of {what!r} in part {part} of {_PARTS} equal parts of a step",
                    f"no more than that part of part_travel(), {float(most[row]):g}",
                    f"{float(found[row]):g}",
                )

    def _check_stops(self, drive: Drive, before: Array, after: Array, fraction: Array) -> None:
        path = drive.displacement(before, after, fraction)
        stop = drive.between(before, after, fraction)
        stopped = drive.displacement(before, stop, np.ones((ROWS, 1)))
        off = np.abs(_difference(path, stopped)).max(axis=1)
        size = 1.0 + np.abs(path).max(axis=1)
        row = int(np.argmax(off / size))
        self.who.require(
            off[row] <= _EXACT * size[row],
            "between",
            f"displacement() to the joints that between() tells at fraction {float(fraction[row, 0]):.3g}",
            f"{path[row].tolist()}, as at that fraction of the whole step",
            stopped[row].tolist(),
        )

    def _check_travel(self, drive: Drive, before: Array, after: Array) -> None:
        bound = drive.travel(before, after) / _PARTS
        last = np.zeros((ROWS, 3))
        for part in range(1, _PARTS + 1):
            now = drive.displacement(before, after, np.full((ROWS, 1), part / _PARTS))
            moved = np.abs(_difference(last, now))
            last = now
            way = np.sqrt(moved[:, 0] ** 2 + moved[:, 1] ** 2)
            for name, found, most in (("way [m]", way, bound[:, 0]), ("turn [rad]", moved[:, 2], bound[:, 1])):
                row = int(np.argmax(found - most))
                self.who.require(
                    found[row] <= most[row] * (1.0 + 1e-9) + _EXACT,
                    "travel",
                    f"the {name} in part {part} of {_PARTS} equal parts of a step",
                    f"no more than that part of travel(), {float(most[row]):g}, as nothing may be faster than it says",
                    f"{float(found[row]):g}",
                )

    def check_jacobian(self, components: list[Drive]) -> None:
        """Whether the Jacobian that the drive offers is that of its displacements, to within a small difference."""
        drive, session = stack(components), Session(self.rig, np.arange(ROWS, dtype=np.int64))
        offered: Any = getattr(drive, "jacobian", None)
        if offered is None:
            return
        carried = self.begin(drive, session)
        state, given = dict(drive.start(session.context())), Given(self.who, "inputs", "")
        for t in range(STEPS):
            session.go_to(t)
            self.step(drive, session, state, carried, given)
        joints = carried["joints"]
        wanted = np.empty((ROWS, 3, self.rolling))
        bind_differences(drive, joints, joints, np.ascontiguousarray(drive.rolling_radius()), wanted)()
        found = offered(joints, joints)
        row = int(np.argmax(np.abs(found - wanted).max(axis=(1, 2)) / (1.0 + np.abs(wanted).max(axis=(1, 2)))))
        self.who.require(
            np.allclose(found, wanted, rtol=1e-4, atol=1e-4),
            "jacobian",
            "jacobian()",
            f"{wanted[row].round(6).tolist()}, by displacement() and rolling_radius()",
            found[row].round(6).tolist(),
        )

    def check_inverse(self, components: list[Drive]) -> None:
        """Whether a motion reached by some command is also reached by the drive's `command_for` it."""
        drive, session = stack(components), Session(self.rig, np.arange(ROWS, dtype=np.int64))
        state = dict(drive.start(session.context()))
        shape = (ROWS, self.joints)
        self._place = np.zeros(shape), np.zeros(shape)
        reached, steady = self._settle(drive, session, state, self.commands[0] / 3.0)
        asked = drive.command_for(reached, self._place[0])
        self.who.require(np.isfinite(asked).all(), "command_for", "command_for()", "finite numbers", "nan or inf")
        again, _ = self._settle(drive, session, state, asked)
        off = np.abs(again - reached).max(axis=1) / (1.0 + np.abs(reached).max(axis=1))
        off = np.where(steady, off, 0.0)
        row = int(np.argmax(off))
        self.who.require(
            off[row] <= 1e-6,
            "command_for",
            f"the twist after command_for({reached[row].tolist()}), which the drive has reached before",
            reached[row].tolist(),
            again[row].tolist(),
        )

    def _settle(self, drive: Drive, session: Session, state: State, command: Array) -> tuple[Array, Bools]:
        """The twist [m/s, m/s, rad/s] after some time under a command, and the rows in which it is steady."""
        joints, rates = self._place
        last = twist = np.zeros((ROWS, 3))
        one = np.ones((ROWS, 1))
        for t in range(_SETTLING):
            session.draws.rewind()
            session._counter[:, 2] = t
            before, last = joints, twist
            joints, rates = drive.advance(before, rates, command, DT, state, session.draws)
            twist = drive.twist(before, joints) / DT
            joints = drive.follow(joints, drive.displacement(before, joints, one))
        self._place = joints, rates
        return twist, np.abs(twist - last).max(axis=1) <= 1e-9


def _difference(a: Array, b: Array) -> Array:
    off = b - a
    off[:, 2] = wrap_angle(off[:, 2])
    return off
