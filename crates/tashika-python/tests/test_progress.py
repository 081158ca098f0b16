"""Progress, and three ways to end a render early."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import tashika

#: Takes minutes if it is not ended.
LONG = {"size": (1024, 1024), "vpls": 3000, "method": "exact", "gather": 64}


def test_progress_is_told_until_the_end(tiny: tashika.Scene) -> None:
    told: list[tuple[int, int, int, int]] = []
    tashika.render(tiny, size=(16, 12), vpls=300, truth="vpl", progress=lambda *now: told.append(now))
    pixels, of, promise_met, rays = told[-1]
    assert (pixels, of, promise_met) == (192, 192, 192) and rays > 192
    assert told == sorted(told)


def test_an_exception_ends_the_render_and_is_raised_again(tiny: tashika.Scene) -> None:
    class Enough(Exception):
        pass

    def progress(pixels: int, of: int, promise_met: int, rays: int) -> None:
        assert 0 < pixels < of
        raise Enough("of this")

    begun = time.monotonic()
    with pytest.raises(Enough, match="of this"):
        tashika.render(tiny, progress=progress, **LONG)
    assert time.monotonic() - begun < 60
    # A cancelled render leaves nothing behind that would disturb the next.
    assert tashika.render(tiny, size=(4, 3), vpls=10, passes=1).complete


def test_other_threads_run_meanwhile(tiny: tashika.Scene) -> None:
    counted = 0
    over = threading.Event()

    def count() -> None:
        nonlocal counted
        while not over.is_set():
            counted += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    tashika.render(tiny, size=(48, 36), vpls=1000, truth="vpl")
    over.set()
    counter.join()
    assert counted > 5


@pytest.mark.skipif(os.name != "posix", reason="signals to processes are of POSIX")
@pytest.mark.parametrize(
    "call",
    [
        "render(scene, **long)",
        "exact(scene, [(x, y) for x in range(999) for y in range(999)], size=(1024, 1024), vpls=5000)",
    ],
)
def test_ctrl_c_ends_the_work(call: str) -> None:
    program = f"""
import signal, tashika
# Jobs that a shell started in the background ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
scene, long = tashika.builtin("tiny"), {LONG!r}
print("begun", flush=True)
try:
    tashika.{call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    print(tashika.render(scene, size=(4, 3), vpls=10, passes=1).complete)
"""
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "begun\n"
    time.sleep(1)
    child.send_signal(signal.SIGINT)
    try:
        output, _ = child.communicate(timeout=60)
    finally:
        child.kill()
    assert output == "interrupted\nTrue\n" and child.returncode == 0
