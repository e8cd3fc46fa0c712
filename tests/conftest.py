"""What every test shares: one thread for each worker, and patience for compilation."""

import gc
import importlib.util
import os
import shutil
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Before numpy or jax is loaded: the workers of pytest-xdist already use the cores.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
_flags = ["--xla_cpu_multi_thread_eigen=false", "--xla_backend_optimization_level=1"]
# Tests compile more than they run: without the emitters of fused loops XLA needs half the time, and
# less again if it does not split a module for several threads. A flag that it does not know ends
# the process, so that only the pinned release is given these.
if version("jaxlib").startswith("0.10."):
    _flags.append("--xla_cpu_use_fusion_emitters=false")
    _flags.append("--xla_cpu_parallel_codegen_split_count=1")
    # Passes that make loops faster: a tenth of the time that XLA needs for what a test compiles.
    _passes = ("simplify-while-loops", "while-loop-invariant-code-motion", "cse", "reshape-mover")
    _passes += ("small-while-loop-hoisting", "while-loop-constant-sinking")
    _passes += ("cpu-parallel-task-assigner", "tree_reduction_rewriter")
    _flags.append(f"--xla_disable_hlo_passes={','.join(_passes)}")
_given = os.environ.get("XLA_FLAGS", "")
_flags = [flag for flag in _flags if flag.partition("=")[0] not in _given]
os.environ["XLA_FLAGS"] = " ".join([*_flags, _given]).strip()
os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("MPLBACKEND", "Agg")
# Lines of Python in compiled programs: nothing reads them, and lowering and XLA carry them along.
os.environ.setdefault("JAX_TRACEBACK_IN_LOCATIONS_LIMIT", "0")
# What one process that a test starts has compiled, the next need not: 1 s of each is bytecode.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
_cache = (Path(__file__).parents[1] / ".pytest_cache" / "compiled").resolve()
os.environ.setdefault("GYROSTAT_CACHE", str(_cache))
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(Path(os.environ["GYROSTAT_CACHE"]) / "jax"))
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.05")

C_COMPILER = os.environ.get("CC") or next(filter(shutil.which, ("cc", "gcc", "clang")), "")
# As the command line does: tracing makes many objects, and collecting them often finds none.
gc.set_threshold(1_000_000)

# A first example compiles, so its time says nothing: no deadline.
settings.register_profile(
    "gyrostat",
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
# Where the result decides whether a change goes in, the examples are the same each time.
settings.register_profile("ci", settings.get_profile("gyrostat"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "gyrostat")


# Files that take longest, the longest first; the campaign files that share one flown campaign.
LONGEST = (
    *("papers/test_carvalho_fenili", "identification/test_batch", "campaigns/test_engine"),
    *("campaigns/test_user_orbits", "identification/test_design", "runs/test_keep_out_slews"),
    *("campaigns/test_user_world", "papers/test_carrara_kuga", "test_cli", "campaigns/test_faults"),
    *("spacecraft/test_added_parts", "campaigns/test_user_metrics", "spacecraft/test_gyrostat"),
    *("campaigns/test_user_controllers", "identification/test_diagnosis"),
    *("campaigns/test_user_data", "runs/test_targets", "runs/test_modes"),
    *("runs/test_example_scenarios", "runs/test_magnetic_scenarios"),
    *("identification/test_comparison", "spacecraft/test_flexible", "simulation/test_in_lanes"),
    *("papers/test_endo_sekiguchi_nonaka", "control/test_following", "control/test_optimal_laws"),
    *("failures/test_recover", "control/test_guidance", "control/test_recovery_momentum"),
    *("identification/test_steady", "papers/test_dispersed_recoveries", "wheel/test_bristles"),
    *("runs/test_jitter_metric", "spacecraft/test_actuators_with_state"),
    *("codegen/test_evaluation", "scenario_files/test_user_mistakes", "search/test_tuning"),
    *("scenario_files/test_scenario_file", "identification/test_bench_tests"),
    *("test_verbs", "test_operator", "wheel/test_batches_and_properties"),
    "control/test_estimating_compensator",
    *("control/test_recovery_zero_momentum", "control/test_wheel_array_control"),
    *("exports/test_cfs_flight", "exports/test_flight_targets", "exports/test_cfs"),
    *("control/test_magnetic_control", "control/test_riccati"),
    *("exports/test_resources", "exports/test_same_c"),
    *("spacecraft/test_bristles_on_body", "wheel/test_step_bounds", "spacecraft/test_table"),
    *("exports/test_against_interpreter", "runs/test_references", "simulation/test_loop"),
    *("control/test_recovery_on_gyrostat", "wheel/test_crossings", "wheel/test_sensitivities"),
    *("spacecraft/test_environment_torques", "papers/test_filter_with_friction_model"),
    *("runs/test_user_support", "runs/test_user_purity"),
)
SHARING = (
    *("test_engine", "test_command_line", "test_damage", "test_replay", "test_report_page"),
    "test_stored_program",
)


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def pytest_configure(config):
    """The fixtures of small_campaign.py are for the tests of several rooms."""
    module = load(Path(__file__).with_name("small_campaign.py"))
    config.pluginmanager.register(module, "small campaign")


def pytest_collection_modifyitems(config, items):
    """The longest files first: none of them is begun when the other workers are done."""
    places = {name: place for place, name in enumerate(LONGEST)}
    here = Path(__file__).parent

    def place(item):
        return places.get(item.path.relative_to(here).with_suffix("").as_posix(), len(places))

    if hasattr(config, "workerinput"):
        items.sort(key=place)
    # The process of the shared campaign, and all that is compared with it, compile alike.
    shared = {item.path for item in items if "small" in item.fixturenames}
    for item in items:
        if item.path in shared:
            item.add_marker("optimised_c")


def pytest_collection_finish():
    """Exclude what the imports have made from every later garbage collection."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish():
    """Exclude what the tests have made from the last garbage collection, which takes seconds."""
    gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A worker takes a file at a time, or all files that share a campaign."""
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return "campaign" if Path(file).stem in SHARING else file

    return ByFile(config, log)


MOST_MEMORY = 3e9
"""Resident memory of a worker above which the next file begins without what JAX has kept, bytes."""
last = {"file": None}


def resident():
    """Resident memory of this process, bytes; 0 where the system does not tell it as Linux does."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Compile without optimisation, except for tests marked `optimised` or `optimised_c`.

    Most tests compile for longer than they run. XLA then needs half the time, and the C compiler a
    fifth. Tests of codegen, of the numbers of both engines and of the shared campaign compile C as
    for users. Processes that a test starts keep the XLA flags above.
    """
    from gyrostat.core.jax64 import jax

    if item.path != last["file"] and resident() > MOST_MEMORY:
        # a worker that keeps the traces of all files needs 7 GB
        jax.clear_caches()
        gc.collect()
    last["file"] = item.path
    optimised = item.get_closest_marker("optimised") is not None
    jax.config.update("jax_disable_most_optimizations", not optimised)
    # What this process compiles is not stored: few of its programs are met again in another one.
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 1e9)
    own = "codegen" in item.path.parts or item.get_closest_marker("optimised_c") is not None
    # What flight C takes in memory is measured with optimisation, which matters to exports alone.
    size = "-Os" if own or "exports" in item.path.parts else "-O0"
    importlib.import_module("gyrostat.codegen.flight.measure").OPTIMISATION = size
    if C_COMPILER:
        os.environ["CC"] = C_COMPILER if optimised or own else f"{C_COMPILER} -O0"


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the command line in this process: exit code, stdout, stderr."""

    def call(*words):
        from gyrostat.cli import main

        monkeypatch.setattr(sys, "argv", ["gyrostat", *map(str, words)])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return call


@pytest.fixture(scope="session")
def module_at():
    """Load a module by its path; the tests are no package that could be imported from."""
    return load


@pytest.fixture(scope="session")
def tools(module_at):
    """Flight C as functions, and the interpreter of jaxprs beside it, both of tests/codegen."""
    from types import SimpleNamespace

    here = Path(__file__).parent / "codegen"
    compiled = module_at(here / "compiled.py")
    interpreter = module_at(here / "interpreter.py")
    return SimpleNamespace(
        Compiled=compiled.Compiled,
        write=compiled.write,
        build=compiled.build,
        compiler=compiled.compiler,
        interpret=interpreter.interpret,
    )


@pytest.fixture(scope="session")
def table_reference(module_at):
    """The independent wheel on a table of table_reference.py beside this file."""
    return module_at(Path(__file__).with_name("table_reference.py")).TableReference


@pytest.fixture(scope="session")
def frictionless(module_at):
    """The gyrostat without friction of frictionless.py beside this file."""
    return module_at(Path(__file__).with_name("frictionless.py")).Frictionless


@pytest.fixture(scope="session")
def g2():
    """The closed loop "G2" of Carrara and Kuga: table, wheel and gains, SI units."""
    from types import SimpleNamespace

    from gyrostat.control import AttitudePID
    from gyrostat.core.units import RPM
    from gyrostat.spacecraft import AirBearingTable
    from gyrostat.wheel import Wheel
    from gyrostat.wheel.friction import Stribeck

    friction = (4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
    wheel = Wheel(1.5e-3, 0.0228, Stribeck(*friction))
    gains = (0.0571, 0.00234, 0.3126)
    return SimpleNamespace(
        friction=friction,
        gains=gains,
        law=AttitudePID(*gains),
        wheel=wheel,
        inertia=0.495,
        fan=0.46e-3,
        speed=-673.5 * RPM,
        table=AirBearingTable(0.495, wheel, external_torque=0.46e-3),
    )


@pytest.fixture(scope="module")
def chromium(module_at, tmp_path_factory):
    """Chromium with an empty page, see browser.py beside this file; it takes a second to start."""
    made = module_at(Path(__file__).with_name("browser.py")).Browser
    with made(tmp_path_factory.mktemp("profile")) as found:
        yield found


@pytest.fixture
def browser(chromium):
    """Chromium in which no script may fail."""
    chromium.errors.clear()
    yield chromium
    assert chromium.errors == []
