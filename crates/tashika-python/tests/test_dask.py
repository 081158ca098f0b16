"""Renders on the workers of a Dask cluster: the same bits as here, with workers lost on the way."""

import os
import signal

import numpy as np
import pytest

import tashika

distributed = pytest.importorskip("distributed")
import tashika.dask  # noqa: E402

OPTIONS = {"size": (120, 70), "gather": 8, "error": 0.02, "truth": "vpl", "seed": 3}
LIGHTS = 1000


@pytest.fixture(scope="module")
def whole():
    return tashika.render(tashika.builtin("tiny"), vpls=LIGHTS, **OPTIONS)


def cluster(workers):
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    )


def same(image, whole):
    assert image.metadata == whole.metadata
    for name in whole:
        assert np.array_equal(image[name].view(np.uint32), whole[name].view(np.uint32)), name


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_any_number_of_workers_gives_the_same_bits(workers, whole):
    told = []
    with cluster(workers) as there, distributed.Client(there) as client:
        image = tashika.dask.render(
            client, "builtin:tiny", shares=7, vpls=LIGHTS, progress=lambda *done: told.append(done), **OPTIONS
        )
        same(image, whole)
        assert told == [(done, 7) for done in range(1, 8)]
        if workers == 2:
            lights = tashika.vpls(tashika.builtin("tiny"), count=LIGHTS, seed=OPTIONS["seed"])
            same(tashika.dask.render(client, "builtin:tiny", shares=2, vpls=lights, **OPTIONS), whole)
            with pytest.raises(tashika.OptionError, match="error"):
                tashika.dask.render(client, "builtin:tiny", retries=0, error=2.0)


def test_a_worker_that_is_killed_in_its_work_changes_nothing(whole):
    with cluster(2) as there, distributed.Client(there) as client:
        victim = next(iter(client.run(os.getpid).values()))
        killed = []

        def kill(done, of):
            # After the first share the other tasks, and the lights, are on the workers.
            if done == 1:
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)

        image = tashika.dask.render(client, "builtin:tiny", shares=20, vpls=LIGHTS, progress=kill, **OPTIONS)
        assert killed
        same(image, whole)
        assert victim not in client.run(os.getpid).values(), "it was another process that was killed"


def test_what_progress_raises_cancels_the_render():
    class Enough(Exception):
        pass

    def stop(done, of):
        raise Enough

    with cluster(1) as there, distributed.Client(there) as client, pytest.raises(Enough):
        tashika.dask.render(client, "builtin:tiny", shares=50, vpls=LIGHTS, progress=stop, **OPTIONS)
