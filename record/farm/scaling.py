"""How renders scale with Dask workers of one thread, and what a share costs besides its pixels: scaling.py SCENE WIDTH HEIGHT VPLS

Needs the package tashika with its extra `dask`.
"""

import sys
import time

import distributed
import tashika
import tashika.dask

scene, width, height, vpls = sys.argv[1], *map(int, sys.argv[2:])
options = {"size": (width, height), "gather": 16}


def timed(work):
    begun = time.time()
    result = work()
    return time.time() - begun, result


if __name__ == "__main__":
    loaded = tashika.load(scene)
    lights = tashika.vpls(loaded, count=vpls)
    alone = lambda tiles=None: tashika.render(loaded, vpls=lights, threads=1, tiles=tiles, **options)
    load, _ = timed(lambda: tashika.load(scene))
    first, _ = timed(lambda: alone((1, 2**20)))
    again, _ = timed(lambda: alone((1, 2**20)))
    print(f"load {load:.2f} s; a share of one tile {first:.2f} s the first time, {again:.2f} s again")
    whole, image = timed(alone)
    print(f"one thread, in this process: {whole:.1f} s")
    for workers in (1, 2):
        cluster = distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        )
        with cluster, distributed.Client(cluster) as client:
            for shares in (16, 128):
                run = lambda: tashika.dask.render(client, scene, shares=shares, vpls=vpls, **options)
                cold, joined = timed(run)
                warm, _ = timed(run)
                assert (joined["radiance"] == image["radiance"]).all()
                print(f"{workers} workers, {shares} shares: {cold:.1f} s, again {warm:.1f} s")
