"""A render on the workers of a Dask cluster, wherever Dask starts them: processes here, Slurm, PBS, Kubernetes.

The image is cut into shares of its tiles, each a task; the lights are traced once, by a worker, and handed to all. A task whose worker is lost
is run again by another one, and so are the lights if all who had them are lost. The joined image is the one that a single machine renders, bit
by bit, whatever happened on the way. Lights of light transport, which are guided to the view, are traced by each worker. Audited pictures are
audited when they are joined: the same bits for any number of shares, another picture than the whole that one machine makes.

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

#: Shares for each thread of the cluster where nobody says how many: the last to finish are then few.
SHARES_PER_THREAD = 8

#: What is handed from worker to worker: the bytes of files, which any version of Python takes apart.
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
    - `shares`: tasks, 8 for each thread of the cluster if not said; more shares lose less when a worker is lost.
    - `retries`: how often a task that raised is tried again. Tasks of workers that were lost are run again by Dask itself, as often as its
      setting `distributed.scheduler.allowed-failures` says.
    - `progress`: called as `progress(done, of)` after each share; what it raises cancels the others.
    - `threads` of each task: 1, since Dask runs a task for each thread of a worker.
    - All else is as for `tashika.render`.

    Raises what a task raised after its last try, and `KilledWorker` of Dask for one that its workers do not survive.
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
    # Told by their number, so that they can be joined in any order.
    tasks = [
        client.submit(
            _share, scene, allow_outside, lights, f"{number}/{shares}", told, retries=retries, pure=False
        )
        for number in range(1, shares + 1)
    ]

    def parts() -> Iterator[Image]:
        for done, (task, part) in enumerate(as_completed(tasks, with_results=True), 1):
            # What is joined is kept by no worker.
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
    """Whether a render sums over one set of lights, as `tashika.render` decides it."""
    if method != "tashika":
        return method != "path"
    return truth == "vpl" or (truth is None and (is_given or claim == "certified"))


def _bytes(thing: VplSet | Image, ending: str) -> _Bytes:
    """A set of lights or an image, as the bytes of its file."""
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
    """The scene of this worker, which its tasks have in common."""
    return load(scene, allow_outside=allow_outside)


@functools.lru_cache(maxsize=1)
def _set(lights: _Bytes) -> VplSet:
    """The lights of this worker, and the tree over them."""
    return _of_bytes(VplSet.load, lights, ".vpl")


def _lights(scene: str, allow_outside: bool, count: int | None, seed: int, clamp: Any) -> _Bytes:
    return _bytes(trace(_scene(scene, allow_outside), count=count, seed=seed, clamp=clamp, threads=1), ".vpl")


def _share(
    scene: str, allow_outside: bool, lights: _Bytes | None, tiles: str, told: dict[str, Any]
) -> _Bytes:
    more: dict[str, Any] = {} if lights is None else {"vpls": _set(lights)}
    return _bytes(render_here(_scene(scene, allow_outside), tiles=tiles, **told, **more), ".exr")
