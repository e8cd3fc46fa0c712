"""The folder of a campaign, damaged: mended or refused. The runs cost nothing and fly here."""

import contextlib
import json
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from gyrostat.campaigns import Store, run_campaign
from gyrostat.campaigns.description import read_campaign
from gyrostat.core.errors import InputError

HERE = Path(__file__).parent
RUNS, KEPT = 41, 7


@pytest.fixture(scope="module")
def fly(module_at):
    """Fly the fake campaign in this process; the lines that it says."""
    fake = module_at(HERE / "fake_campaign.py")
    here = module_at(HERE.parents[1] / "benchmarks" / "soak_files.py").Here()

    def call(out, seed=0, **options):
        said = []
        run_campaign(
            fake.SCENARIO,
            out,
            runs=RUNS,
            seed=seed,
            opener=lambda: contextlib.nullcontext(here),
            workers=1,
            block=4,
            engine="jax",
            keep=[KEPT],
            worst=1,
            fly_job=fake.fly,
            say=said.append,
            **options,
        )
        return "\n".join(said)

    return call


@pytest.fixture(scope="module")
def undisturbed(fly, tmp_path_factory):
    """Folder of a campaign that nothing happened to."""
    out = tmp_path_factory.mktemp("undisturbed") / "out"
    fly(out)
    return out


@pytest.fixture
def out(undisturbed, tmp_path):
    """A copy of it."""
    shutil.copytree(undisturbed, tmp_path / "out")
    return tmp_path / "out"


@pytest.fixture
def same(undisturbed, fly):
    """Check that the campaign mends a folder, and what it says."""

    def check(out, expected):
        assert expected in fly(out)
        kept = [p for p in undisturbed.rglob("*") if p.is_file() and p.name[0] != "."]
        assert len(kept) == 11 + 2 + 2
        for path in kept:
            assert (out / path.relative_to(undisturbed)).read_bytes() == path.read_bytes()
        assert "damage" not in fly(out)

    return check


def flip(path, place=None):
    """Flip a bit in the middle."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2 if place is None else place] ^= 16
    path.write_bytes(content)


def test_no_flipped_bit_of_the_description_is_taken(undisturbed, tmp_path):
    content = (undisturbed / "campaign.json").read_bytes()
    file = tmp_path / "campaign.json"
    for place in range(0, 8 * len(content), 11):
        flipped = bytearray(content)
        flipped[place // 8] ^= 1 << place % 8
        file.write_bytes(flipped)
        with pytest.raises(InputError):
            read_campaign(file)


@pytest.mark.parametrize("damage", ["flip", "delete", "empty", "folder", "link"])
def test_the_description_is_written_again_by_the_same_command_alone(out, fly, same, damage):
    file = out / "campaign.json"
    if damage == "flip":
        flip(file)
    elif damage == "empty":
        file.write_text("")
    else:
        file.unlink()
    if damage == "folder":
        file.mkdir()
    if damage == "link":
        file.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="expected"):
        Store(out).known()
    with pytest.raises(InputError, match="repeat the command that started"):
        fly(out, seed=1)
    same(out, "campaign.json: found no valid file: it is written again")


def test_blocks_of_another_campaign_and_renumbered_ones_are_flown_again(out, fly, same, tmp_path):
    fly(tmp_path / "other", seed=1)
    (foreign,) = (tmp_path / "other").glob("blocks/000002.*")
    (own,) = out.glob("blocks/000002.*")
    own.unlink()
    shutil.copy(foreign, out / "blocks")
    third, fourth = (next(out.glob(f"blocks/00000{k}.*")) for k in (3, 4))
    fourth.unlink()
    shutil.copy(third, third.with_name(third.name.replace("000003", "000004")))
    (out / "runs.parquet").unlink()
    with pytest.raises(InputError, match="9 of 11 blocks intact and no intact runs"):
        Store(out).merge(Store(out).known())
    same(out, "block 4 is damaged or of another campaign; it is simulated again")


def test_blocks_name_their_campaign_seed_and_runs(undisturbed):
    (block,) = undisturbed.glob("blocks/000003.*")
    told = pq.read_schema(block).metadata
    assert told[b"campaign"].decode() == Store(undisturbed).known().identity
    assert (told[b"seed"], told[b"runs"]) == (b"0", b"12 to 15")


@pytest.mark.parametrize("name", ["runs.parquet", "runs/run_000007.nc"])
@pytest.mark.parametrize("damage", ["flip", "truncate", "append", "folder", "link"])
def test_results_are_made_again_and_what_was_there_is_kept(out, same, name, damage):
    file = out / name
    content = file.read_bytes()
    if damage == "flip":
        flip(file)
    elif damage == "truncate":
        file.write_bytes(content[:-3])
    elif damage == "append":
        file.write_bytes(content + b"\0")
    else:
        file.rename(out / "precious")
        file.mkdir() if damage == "folder" else file.symlink_to(out / "precious")
    if name == "runs.parquet":
        with pytest.raises(InputError, match="damaged"):
            Store(out).read_table()
    same(out, f"it is kept as {file.name}.changed")
    if damage == "link":
        assert (out / "precious").read_bytes() == content


@pytest.mark.parametrize("damage", ["flip", "delete", "folder"])
def test_without_the_manifest_all_results_are_made_again(out, same, damage):
    manifest = out / ".gyrostat.json"
    if damage == "flip":
        flip(manifest, 0)
    else:
        manifest.unlink()
    if damage == "folder":
        manifest.mkdir()
    same(out, "runs.parquet: found a file that gyrostat campaign did not write")


def test_a_history_that_nobody_kept_is_set_aside_and_not_flown(out, same):
    for run in (5, 99):
        (out / "runs" / f"run_{run:06d}.nc").write_text("mine")
    same(out, "run_000099.nc: found a file that gyrostat campaign did not write")
    assert (out / "runs" / "run_000099.nc.changed").read_text() == "mine"
    assert len(list(out.glob("runs/*.nc"))) == 2


def test_a_table_is_mended_by_those_who_only_read(out, undisturbed):
    flip(out / "runs.parquet")
    (block,) = out.glob("blocks/000003.*")
    store = Store(out)
    with store.locked():
        store.mend(store.known())
    assert (out / "runs.parquet").read_bytes() == (undisturbed / "runs.parquet").read_bytes()
    flip(block)
    said = []
    store = Store(out, said.append)
    with store.locked():
        store.mend(store.known())
    assert said == [
        "block 3 is damaged or of another campaign: gyrostat campaign simulates it again"
    ]
    flip(out / "runs.parquet")
    with pytest.raises(InputError, match="10 of 11 blocks intact"), store.locked():
        store.mend(store.known())


def test_a_folder_of_an_earlier_format_is_refused(out, fly):
    file = out / "campaign.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "format": 1}))
    with pytest.raises(InputError, match="found format 1 of another gyrostat, expected 2: run"):
        fly(out)


def test_a_new_campaign_takes_no_name_of_the_user(fly, tmp_path):
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(InputError, match=r"report\.html: found a file that .* did not write"):
        fly(tmp_path)
    assert not (tmp_path / "campaign.json").exists()
    fly(tmp_path, force=True)
    assert (tmp_path / "report.html.changed").read_text() == "mine"


@pytest.mark.parametrize("name", ["blocks", "runs", ".lock"])
def test_a_linked_part_of_the_folder_is_refused(fly, tmp_path, name):
    elsewhere = tmp_path / "elsewhere"
    if name == ".lock":
        elsewhere.write_text("mine")
    else:
        elsewhere.mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).symlink_to(elsewhere)
    with pytest.raises(InputError, match="symbolic link"):
        fly(tmp_path / "out")
    assert elsewhere.read_text() == "mine" if name == ".lock" else not list(elsewhere.iterdir())
