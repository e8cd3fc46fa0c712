"""A campaign whose workers are jobs of Slurm, started and ended by dask-jobqueue.

    python slurm.py SCENARIO.toml RUNS OUT [--jobs 64] [--queue NAME] [--script]

Run it where sbatch works and jobs can reach this machine. --script only prints the job.
"""

import argparse
import sys

from dask_jobqueue import SLURMCluster

import gyrostat as gs


def main() -> None:
    """Start the workers, run the campaign, end the workers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario")
    parser.add_argument("runs", type=int)
    parser.add_argument("out", help="folder, or s3://BUCKET/PREFIX")
    parser.add_argument("--jobs", type=int, default=64, help="jobs, each with one worker")
    parser.add_argument("--queue", help="partition")
    parser.add_argument("--memory", default="2GB", help="of a job")
    parser.add_argument("--script", action="store_true", help="only print the job")
    given = parser.parse_args()
    with SLURMCluster(
        queue=given.queue,
        cores=1,
        processes=1,
        memory=given.memory,
        walltime="04:00:00",
        python=sys.executable,
        job_script_prologue=["export OMP_NUM_THREADS=1"],
        scheduler_options={"dashboard_address": None},
    ) as workers:
        if given.script:
            print(workers.job_script())
            return
        workers.scale(jobs=given.jobs)
        address = workers.scheduler_address
        gs.campaign(given.scenario, given.runs, given.out, seed=1, scheduler=address, say=print)


if __name__ == "__main__":
    main()
