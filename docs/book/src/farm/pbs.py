"""A render on nodes of a PBS cluster, by Dask, or on processes of this machine: the same bits.

python pbs.py /shared/kitchen.glb /shared/kitchen.exr --jobs 8 --cores 16 --error 0.02
python pbs.py /shared/kitchen.glb kitchen.exr --local 2 --error 0.02

Scene and package are to be there under the same names on all nodes. `--print-job` prints what would be
submitted for each node, and ends.
"""

import argparse

from dask.distributed import Client, LocalCluster

import tashika.dask


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("scene", help="a scene file that all nodes see, builtin:room or builtin:tiny")
    options.add_argument("image", help="the OpenEXR file to write")
    options.add_argument("--error", type=float, default=0.05)
    options.add_argument("--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"))
    options.add_argument("--jobs", type=int, default=4, help="nodes that are asked for")
    options.add_argument("--cores", type=int, default=16, help="of each node")
    options.add_argument("--memory", default="32GB", help="of each node")
    options.add_argument("--queue", default="workq")
    options.add_argument("--walltime", default="02:00:00")
    options.add_argument("--local", type=int, metavar="WORKERS", help="processes of this machine instead of PBS")
    options.add_argument("--print-job", action="store_true")
    typed = options.parse_args()

    if typed.local:
        cluster = LocalCluster(n_workers=typed.local, threads_per_worker=1, dashboard_address=None)
    else:
        from dask_jobqueue import PBSCluster

        # One process a node: its threads share the scene and the lights.
        cluster = PBSCluster(
            cores=typed.cores,
            processes=1,
            memory=typed.memory,
            queue=typed.queue,
            walltime=typed.walltime,
            scheduler_options={"dashboard_address": None},
        )
    with cluster:
        if typed.print_job:
            print(cluster.job_script())
            return
        if not typed.local:
            # Nodes that are lost are asked for again; their shares are rendered by the others.
            cluster.adapt(minimum_jobs=1, maximum_jobs=typed.jobs)
        with Client(cluster) as client:
            client.wait_for_workers(1)
            image = tashika.dask.render(
                client,
                typed.scene,
                size=typed.size,
                error=typed.error,
                shares=8 * typed.jobs * typed.cores if not typed.local else None,
            )
        image.save(typed.image)
        print(image)


if __name__ == "__main__":
    main()
