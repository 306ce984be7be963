"""The frame buffer: each window gets the newest frame of the robot that it looks at, and nobody is waited for."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from amorsim.ui.simulator.frame_buffer import FrameBuffer
from amorsim.ui.simulator.frames.packing import Bundle, Dynamic, FrameFlag, pack_bundle, unpack_frame
from tests.ui.aside import aside
from tests.ui.simulator.test_protocol import moment


class Child:
    """Makes a bundle of the robots that are looked at on request."""

    def __init__(self) -> None:
        self.asked: list[bool] = []
        self.frame_buffer = FrameBuffer(self._ask)

    def _ask(self, now: bool) -> bool:
        self.asked.append(now)
        return True

    def send(self, *robots: int, tick: int = 1) -> None:
        one = moment(3, 0, 2, 1, 2, 2)
        self.frame_buffer.take(Bundle(pack_bundle([one._replace(selected_robot=robot, tick=tick) for robot in robots])))


class Window:
    """Asks for one frame after another."""

    def __init__(self, child: Child, robot: int = 0) -> None:
        self.child = child
        self.robot = robot
        self.number = 0

    def look(self) -> asyncio.Task[Dynamic]:
        async def newest() -> Dynamic:
            frame = unpack_frame(await self.child.frame_buffer.newest(self.number, lambda: self.robot))
            self.number = frame.number
            return frame

        return asyncio.create_task(newest())


def run(story: Callable[[Child], Awaitable[None]]) -> None:
    async def whole() -> None:
        await asyncio.wait_for(story(Child()), 30.0)

    aside(whole())


def test_windows_look_at_robots_of_their_own() -> None:
    async def story(child: Child) -> None:
        one, two = Window(child), Window(child, robot=2)
        looks = [one.look(), two.look()]
        await asyncio.sleep(0)
        assert child.asked == [False]  # once, for both
        child.send(0, 2)
        assert [frame.selected_robot for frame in await asyncio.gather(*looks)] == [0, 2]

    run(story)


def test_who_turns_to_another_robot_sees_it_though_nothing_moves() -> None:
    async def story(child: Child) -> None:
        one = Window(child)
        look = one.look()
        await asyncio.sleep(0)
        child.send(0)
        await look
        # While it waits: the next is asked for at once, and one that is under way without that robot does not do.
        look = one.look()
        await asyncio.sleep(0)
        one.robot = 1
        child.frame_buffer.turn()
        assert child.asked == [False, False, True]
        child.send(0)
        await asyncio.sleep(0.01)
        assert not look.done()
        assert child.asked == [False, False, True, True]
        child.send(1)
        assert (await look).selected_robot == 1
        # While it does not wait.
        one.robot = 2
        child.frame_buffer.turn()
        child.send(1)
        one.number += 1  # which it has seen before it turned
        look = one.look()
        await asyncio.sleep(0)
        assert child.asked[-1] is True
        child.send(2)
        assert (await look).selected_robot == 2

    run(story)


def test_where_no_frame_comes_any_more_the_last_stands_for_all_robots() -> None:
    async def story(child: Child) -> None:
        one = Window(child)
        look = one.look()
        await asyncio.sleep(0)
        child.send(0, tick=7)
        await look
        look = one.look()
        await asyncio.sleep(0)
        child.frame_buffer.stand_still()
        frame = await look
        assert (frame.selected_robot, frame.tick, len(frame.selected.true)) == (0, 7, 2)
        assert frame.flags & FrameFlag.HANG
        assert not frame.flags & FrameFlag.RUNNING
        look = one.look()
        await asyncio.sleep(0)
        one.robot = 2
        child.frame_buffer.turn()
        frame = await look
        assert (frame.selected_robot, frame.tick, len(frame.selected.true)) == (2, 7, 0)
        assert frame.flags & FrameFlag.HANG

    run(story)
