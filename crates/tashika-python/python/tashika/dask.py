"""A render on the workers of any Dask cluster: local processes, Slurm, PBS, Kubernetes.

The image is cut into shares of its tiles, and each share is a task. The lights are traced once, by
one worker, and passed to all workers. If a worker is lost, another one runs its task again, and the
lights are traced again if all workers that had them are lost. The joined image is the one that a
single machine renders, bit by bit, whatever happened on the way. Lights of light transport, which
are guided to the view, are traced by each worker. Audited pictures are audited when they are
joined: the bits are equal for any number of shares, but differ from those of a picture that one
machine renders as a whole.

    from dask.distributed import Client
    import tashika.dask

    with Client() as client:
        image = tashika.dask.render(client, "kitchen.pbrt", error=0.02)

Held to this by tests/test_dask.py, which ends a worker by force.
"""

from __future__ import annotations

import functools
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import Image, Scene, VplSet, load, merge, read
from . import render as render_here
from . import vpls as trace

if TYPE_CHECKING:
    from distributed import Client

#: Default number of shares for each thread of the cluster: with several, all threads finish at
#: nearly the same time.
SHARES_PER_THREAD = 8

#: Data passed between workers: the bytes of files, which any version of Python unpickles.
_Bytes = bytes


def render(
    client: Client,
    scene: str | os.PathLike[str],
    *,
    shares: int | None = None,
    retries: int = 3,
    progress: Callable[[int, int], object] | None = None,
    allow_outside: bool = False,
    vpls: VplSet | int | None = None,
    clamp: float | str | None = None,
    seed: int = 1,
    threads: int = 1,
    **options: Any,
) -> Image:
    """Renders an image on the workers of a cluster.

    - `client`: a `dask.distributed.Client`.
    - `scene`: a file that all workers see under this name, or "builtin:room", "builtin:tiny".
    - `shares`: number of tasks, by default 8 for each thread of the cluster; with more shares, less
      work is lost with a worker.
    - `retries`: number of times that a task is tried again after an exception. Tasks of lost
      workers are run again by Dask itself, as often as its setting
      `distributed.scheduler.allowed-failures` allows.
    - `progress`: called as `progress(done, of)` after each share; an exception from it cancels the
      others.
    - `threads` of each task: 1, since Dask runs a task for each thread of a worker.
    - All other options are those of `tashika.render`.

    Raises the exception of a task after its last try, and `KilledWorker` of Dask for a task that
    its workers do not survive.
    """
    from distributed import as_completed

    scene = os.fspath(scene)
    if shares is None:
        shares = SHARES_PER_THREAD * max(1, sum(client.nthreads().values()))
    lights: Any = None
    if _is_of_one_set(isinstance(vpls, VplSet), **options):
        if isinstance(vpls, VplSet):
            lights = client.scatter(_bytes(vpls, ".vpl"), broadcast=True)
        else:
            lights = client.submit(
                _lights, scene, allow_outside, vpls, seed, clamp, retries=retries, pure=False
            )
        vpls = clamp = None
    told = {"vpls": vpls, "clamp": clamp, "seed": seed, "threads": threads, **options}
    told = {name: value for name, value in told.items() if value is not None}
    # Tasks have the numbers of their shares, so that they can be joined in any order.
    tasks = [
        client.submit(
            _share, scene, allow_outside, lights, f"{number}/{shares}", told, retries=retries, pure=False
        )
        for number in range(1, shares + 1)
    ]

    def parts() -> Iterator[Image]:
        for done, (task, part) in enumerate(as_completed(tasks, with_results=True), 1):
            # Workers release parts that are joined.
            task.release()
            yield _of_bytes(read, part, ".exr")
            if progress is not None:
                progress(done, shares)

    try:
        return merge(parts(), denoiser=options.get("denoiser"))
    except BaseException:
        client.cancel(tasks)
        raise


def _is_of_one_set(
    is_given: bool, method: str = "tashika", truth: str | None = None, claim: str | None = None, **_: Any
) -> bool:
    """Returns true if a render sums over one set of lights, by the rules of `tashika.render`."""
    if method != "tashika":
        return method != "path"
    return truth == "vpl" or (truth is None and (is_given or claim == "certified"))


def _bytes(thing: VplSet | Image, ending: str) -> _Bytes:
    """Converts a set of lights or an image to the bytes of its file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"it{ending}")
        thing.save(path)
        return path.read_bytes()


def _of_bytes(reader: Callable[[Path], Any], data: _Bytes, ending: str) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"it{ending}")
        path.write_bytes(data)
        return reader(path)


@functools.lru_cache(maxsize=1)
def _scene(scene: str, allow_outside: bool) -> Scene:
    """Returns the scene of this worker, which its tasks share."""
    return load(scene, allow_outside=allow_outside)


@functools.lru_cache(maxsize=1)
def _set(lights: _Bytes) -> VplSet:
    """Returns the lights of this worker, with the tree over them."""
    return _of_bytes(VplSet.load, lights, ".vpl")


def _lights(scene: str, allow_outside: bool, count: int | None, seed: int, clamp: Any) -> _Bytes:
    return _bytes(trace(_scene(scene, allow_outside), count=count, seed=seed, clamp=clamp, threads=1), ".vpl")


def _share(
    scene: str, allow_outside: bool, lights: _Bytes | None, tiles: str, told: dict[str, Any]
) -> _Bytes:
    more: dict[str, Any] = {} if lights is None else {"vpls": _set(lights)}
    return _bytes(render_here(_scene(scene, allow_outside), tiles=tiles, **told, **more), ".exr")
