"""Order of the stages that build a run: each reads what stages before it have set."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax
from gyrostat.runs import build_plant
from gyrostat.runs.assembly import Assembly
from gyrostat.runs.build import STAGES
from gyrostat.runs.plans import designs_of
from gyrostat.scenario.structure import structure_of


class Recorded:
    """Assembly that records which of its fields are read."""

    def __init__(self, run):
        self.run, self.read = run, set()

    def __getattr__(self, name):
        self.read.add(name)
        return getattr(self.run, name)


def read_too_early(stages, scenario):
    """Pairs of a stage, and a field that it reads and a later stage sets without a look at it."""
    structure, plans = structure_of(scenario), designs_of(scenario)
    reads, sets = [], []

    def build(values):
        run = Assembly(structure, values, plans)
        for stage in stages:
            recorded = Recorded(run)
            fields = stage(recorded)
            reads.append(recorded.read)
            sets.append(fields.keys() - recorded.read)  # what it reads too, it wraps
            run = run._replace(**fields)
        return run.start

    jax.eval_shape(build, {key: np.asarray(value) for key, value in scenario.values.items()})
    places = {field: place for place in range(len(stages)) for field in sets[place]}
    return [
        (stage.__name__, field)
        for place, stage in enumerate(stages)
        for field in reads[place]
        if places.get(field, -1) > place
    ]


def test_each_stage_reads_what_stages_before_it_have_set(scenario):
    assert read_too_early(STAGES, scenario) == []


@pytest.mark.parametrize(
    ("stage", "field"),
    [(build_plant.add_imbalance, "motion"), (build_plant.add_body, "orbit")],
)
def test_stage_that_comes_too_early_is_found(scenario, stage, field):
    others = [each for each in STAGES if each is not stage]
    place = 1 if field == "orbit" else others.index(build_plant.add_motion)
    early = [*others[:place], stage, *others[place:]]
    assert (stage.__name__, field) in read_too_early(early, scenario)
