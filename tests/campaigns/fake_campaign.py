"""A campaign whose runs cost nothing: python fake_campaign.py OUT RUNS PAUSE [SCHEDULER].

Store, executor and order of work are the real ones; only what a worker computes is made up.
"""

import os
import signal
import sys
import threading
import time
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gyrostat.scenario import Scenario

if __name__ == "__main__":  # what is started in the background is told to ignore Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)
PAUSE = float(sys.argv[3]) if Path(sys.argv[0]).name == Path(__file__).name else 0.0
SCENARIO = Scenario(
    name="fake",
    wheels=(),
    axes=(),
    friction="stribeck",
    controller="three_axis",
    compensator="none",
    sensors="white_noise",
    estimator="none",
    environment="constant",
    attitude=(1.0, 0.0, 0.0, 0.0),
    target=(1.0, 0.0, 0.0, 0.0),
    boresight=None,
    count=10,
    substeps=1,
    command_delay=0,
    percentiles=(99.7,),
    events=(),
    dispersions=(),
    values={"run.control_period": 1.0},
)


class Flown(NamedTuple):
    """As the engine gives it."""

    columns: dict
    histories: object = None


class History:
    """Stands for the history of a run."""

    def __init__(self, run=None):
        self.run = run

    def of_run(self, run):
        return History(run)

    def write(self, path):
        Path(path).write_text(f"history {self.run}")


def fly(job):
    """Made-up numbers that depend on the run alone."""
    time.sleep(float(os.environ.get("FAKE_PAUSE", PAUSE)))
    runs = np.array(job.runs)
    if int(os.environ.get("FAKE_DIES_AT", -1)) in job.runs:
        once = os.environ.get("FAKE_DIES_ONCE")
        if once is None or not Path(once).exists():
            if once is not None:
                Path(once).touch()
            os.kill(os.getpid(), 9)
    columns = {
        "run": runs,
        "status": np.zeros(len(runs), np.int8),
        "ended": np.full(len(runs), 10.0),
    }
    metrics = {name: np.sin(runs + k) for k, name in enumerate(metric_names())}
    return Flown(columns | metrics, History())


def metric_names():
    """Names of the metrics; a worker is given them, because their import takes most of its time."""
    if "FAKE_METRICS" in os.environ:
        return os.environ["FAKE_METRICS"].split()
    from gyrostat.scenario.metrics.results import metrics_of

    return [*metrics_of(SCENARIO)]


def begin(words, outputs, environment):
    """Simulate the campaign in a forked process, at the head of its group.

    Args:
        words: Words of the command line.
        outputs: Files of both outputs.
        environment: Variables of the environment.
    """
    os.setsid()
    for stream, path in enumerate(outputs, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), stream)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.argv = [__file__, *words]
    os.environ.update(environment, FAKE_METRICS=" ".join(metric_names()))
    try:
        run()
    finally:
        threading._shutdown()  # as of a program: threads end before what they use is closed


def main():
    """Simulate the campaign."""
    from gyrostat.campaigns import cluster, run_campaign
    from gyrostat.core.remote_folder import local_folder

    # workers do not load the main module: what they compute must be importable, or sent by value
    by_value = len(sys.argv) > 4
    say = partial(print, file=sys.stderr)
    job = fly if by_value else import_module(Path(__file__).stem).fly
    with local_folder(sys.argv[1], say) as (folder, say):
        done = run_campaign(
            SCENARIO,
            folder,
            runs=int(sys.argv[2]),
            opener=cluster(sys.argv[4], say) if by_value else None,
            workers=1,
            block=4,
            engine="jax",
            fly_job=job,
            say=say,
        )
    assert by_value or "pandas" not in sys.modules, "its import takes 0.2 s"
    print(done)


def run():
    """Simulate the campaign, and exit as the command line does."""
    from gyrostat.core.errors import InputError

    try:
        main()
    except InputError as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    run()
