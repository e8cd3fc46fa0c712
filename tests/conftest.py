"""What every test shares: one thread for each worker, and patience for compilation."""

import os

from hypothesis import HealthCheck, settings

# Before numpy or jax is loaded: the workers of pytest-xdist already use the cores.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")
os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("MPLBACKEND", "Agg")

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
