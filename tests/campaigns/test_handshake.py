"""Handshake with a worker, here this process."""

import dataclasses
import os
import pickle

import pytest

from gyrostat.campaigns import delivered_programs, handshake
from gyrostat.campaigns.cluster_pool import ClusterPool
from gyrostat.campaigns.delivered_programs import Label, digest_of_content, install_programs
from gyrostat.campaigns.handshake import Answer, Handshake, Outcome, carry_out_greeted, greet
from gyrostat.core.errors import InputError
from gyrostat.runs.fingerprint import engine_record, mathematical_library

JOBS = [(abs, -2), (float, "3")]
WHERE = "worker tcp://10.0.0.3:41"


@pytest.fixture
def record(monkeypatch):
    """Fingerprint of this process; the process has accepted nothing."""
    monkeypatch.setattr(handshake, "_accepted", set())
    monkeypatch.setattr(handshake, "_flags", set())
    monkeypatch.setattr(delivered_programs, "_contents", {})
    monkeypatch.setattr(delivered_programs, "_labels", {})
    return engine_record("cpu", os.environ["XLA_FLAGS"])


@pytest.mark.parametrize(
    "name", ["gyrostat", "python", "numpy", "jaxlib", "instructions", "mathematical library"]
)
def test_a_worker_that_differs_is_refused_with_worker_found_and_expected(record, name):
    answer = greet(Handshake({**record, name: "another"}), WHERE, {})
    assert answer.refusal.startswith(f"{WHERE}: found {name} {record[name]}, expected another")
    assert carry_out_greeted(Handshake({**record, name: "another"}).identity, JOBS) == Outcome(
        False
    )


def test_a_compiler_matters_only_where_programs_are_not_delivered(record):
    other = {**engine_record("cpu", record["flags"], "native"), "compiler": "another"}
    asked = Handshake(other)
    assert greet(asked, WHERE, {}) == Answer()
    assert carry_out_greeted(asked.identity, JOBS).results == [2, 3.0]
    compiled = greet(Handshake(other, scenarios=("a scenario of the user",)), WHERE, {})
    assert compiled.refusal.startswith(f"{WHERE}: found compiler ")


def test_programs_are_asked_for_by_digest_and_damaged_ones_refused(record):
    content = pickle.dumps((None, []))
    label = Label("scenario", 0, digest_of_content(content))
    asked = Handshake(record, labels=(label,), contents={label.program: content})
    assert pickle.loads(pickle.dumps(asked)).contents == {}
    assert greet(asked, WHERE, {}) == Answer(missing=[label.program])
    damaged = greet(asked, WHERE, {label.program: content + b"."})
    assert damaged.refusal.startswith(f"{WHERE}: program: found digest ")
    assert greet(asked, WHERE, {label.program: content}) == Answer()
    assert greet(asked, WHERE, {}) == Answer()
    assert greet(dataclasses.replace(asked), WHERE, {}) == Answer()


def test_another_program_for_the_same_runs_ends_earlier_handshakes(record):
    contents = [pickle.dumps((None, [])), pickle.dumps((None, []), protocol=2)]
    labels = [Label("scenario", 0, digest_of_content(each)) for each in contents]
    pairs = zip(labels, contents, strict=True)
    first, second = (Handshake(record, labels=(a,), contents={a.program: b}) for a, b in pairs)
    assert greet(first, WHERE, first.contents) == Answer()
    assert greet(second, WHERE, second.contents) == Answer()
    assert not carry_out_greeted(first.identity, JOBS).was_greeted
    assert carry_out_greeted(second.identity, JOBS).results == [2, 3.0]


def test_a_worker_of_a_computation_with_other_flags_must_start_again(record):
    assert greet(Handshake(record), WHERE, {}) == Answer()
    answer = greet(Handshake({**record, "flags": ""}), WHERE, {})
    assert "found flags of an earlier computation" in answer.refusal


def test_content_that_cannot_be_loaded_is_an_error(record):
    content = pickle.dumps((None, [b"not a library"]))
    label = Label("scenario", 0, digest_of_content(content))
    with pytest.raises(InputError, match="expected the delivered program to be a library"):
        install_programs([label], {label.program: content})


def test_the_mathematical_library_has_a_name_and_a_version():
    assert len(mathematical_library().split()) >= 2


def refuse_disk(job):
    """Job on a full disk."""
    raise OSError(28, "No space left on device")


def test_errors_of_jobs_are_not_those_of_the_connection(record):
    asked = Handshake(record)
    assert greet(asked, WHERE, {}) == Answer()
    failed = carry_out_greeted(asked.identity, [(float, "x")])
    assert isinstance(failed.error, ValueError)
    full = carry_out_greeted(asked.identity, [(refuse_disk, 0)])
    assert isinstance(full.error, InputError)
    assert "found [Errno 28] No space left on device" in str(full.error)


def test_a_full_disk_refuses_the_worker(record, monkeypatch):
    def full(labels):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(handshake, "missing_programs", full)
    answer = greet(Handshake(record), WHERE, {})
    assert answer.refusal.startswith(f"{WHERE}: ")
    assert "No space left on device" in answer.refusal


class SilentConnection:
    """Connection whose calls are lost, to a worker that stays in the list."""

    address, is_closed, is_broken = "tcp://10.0.0.1:8786", False, False

    def ask_for_workers(self, take):
        take({"tcp://10.0.0.3:41": 1})

    def send(self, address, function, *arguments):
        return None

    def when_done(self, call, take):
        take((None, OSError("connection reset")))

    def cancel(self, calls):
        pass


def test_a_worker_that_never_answers_its_greeting_is_refused(record):
    said = []
    pool = ClusterPool(SilentConnection(), Handshake(record), said.append)
    try:
        with pytest.raises(InputError, match="all of them refused"):
            pool.submit(abs, -1).result(timeout=10)
    finally:
        pool.shutdown()
    assert "found connection reset" in said[0]
