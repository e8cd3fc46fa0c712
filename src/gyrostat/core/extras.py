"""Packages of the extras, and the error where one is missing.

The name gyrostat is not registered on the package index: a command that names it there could
install a stranger's package. Messages therefore name the packages themselves.
"""

from gyrostat.core.errors import InputError

EXTRAS = {
    "bench": ("npTDMS>=1.10", "asammdf>=8.0", "space_packet_parser>=6.0"),
    "cluster": ("dask>=2025.1", "distributed>=2025.1"),
    "cuda": ("nvidia-cuda-nvrtc>=13",),
    "fly": ("ziglang>=0.17",),
    "opencl": ("pyopencl>=2024.1",),
    "orbit": ("sgp4>=2.23", "ppigrf>=2.0", "pyerfa>=2.0.1.4", "pymsis>=0.10"),
    "posterior": ("blackjax>=1.2",),
    "s3": ("s3fs>=2024.10",),
    "search": ("cma>=4.0",),
    "structure": ("pyuff>=2.5", "pyyeti>=1.4"),
}
"""Extra -> its packages, as in pyproject.toml."""


def missing(where: str, package: str, extra: str) -> InputError:
    """Error for a package that is not installed, with the command that installs it.

    Args:
        where: Option or key that needs the package.
        package: Name of the package.
        extra: Name of its extra.
    """
    packages = " ".join(f"'{each}'" for each in EXTRAS[extra])
    return InputError(
        f"{where}: found no {package}, expected the packages of the extra {extra}: "
        f"pip install {packages}"
    )
