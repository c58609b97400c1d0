"""Large requests of one page, or of many, take a bounded amount of memory together."""

import asyncio

import pytest

from mjsim.web.server.request_bodies import MAX_SMALL_BODY, Bodies
from tests.loops import in_a_loop


def test_large_bodies_wait_for_room_and_small_ones_do_not():
    async def work() -> list[str]:
        bodies, order = Bodies(total=4 * MAX_SMALL_BODY), []
        first_may_go = asyncio.Event()

        async def one(name: str, size: int, until: asyncio.Event | None = None) -> None:
            async with bodies.room(size):
                order.append(name)
                if until is not None:
                    await until.wait()

        holding = asyncio.create_task(one("first", 3 * MAX_SMALL_BODY, first_may_go))
        await asyncio.sleep(0)
        waiting = [asyncio.create_task(one(name, 2 * MAX_SMALL_BODY)) for name in ("second", "third")]
        # As large as a client says, but never more than there is.
        waiting.append(asyncio.create_task(one("huge", 10**17)))
        await one("small", MAX_SMALL_BODY)
        assert order == ["first", "small"]
        first_may_go.set()
        await asyncio.gather(holding, *waiting)
        return order

    assert sorted(in_a_loop(work)) == ["first", "huge", "second", "small", "third"]


def test_a_body_that_fails_or_is_given_up_leaves_its_room():
    async def work() -> None:
        bodies = Bodies(total=2 * MAX_SMALL_BODY)
        with pytest.raises(ValueError, match="damaged"):
            async with bodies.room(2 * MAX_SMALL_BODY):
                raise ValueError("damaged")
        async with bodies.room(2 * MAX_SMALL_BODY):
            given_up = asyncio.create_task(bodies.room(2 * MAX_SMALL_BODY).__aenter__())
            await asyncio.sleep(0)
            given_up.cancel()
        async with bodies.room(2 * MAX_SMALL_BODY):
            pass

    in_a_loop(work)
