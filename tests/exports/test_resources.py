"""Bounds of instructions and stack against counts on simulated processors."""

import re
import shutil
import subprocess

import pytest

from gyrostat.codegen import bounds
from gyrostat.codegen.bounds.angles import angles
from gyrostat.codegen.bounds.library import COUNTED
from gyrostat.core.files import write_texts
from gyrostat.exports.evidence.board import board_files, counting_code

TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-objdump", "qemu-system-arm", "sh")
MISSING = [tool for tool in TOOLS if shutil.which(tool) is None]
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"{', '.join(MISSING)} not installed")

M4 = ("cortex-m4", "fpv4-sp-d16", "mps2-an386")
M7 = ("cortex-m7", "fpv5-d16", "mps2-an500")


class Board:
    """Programs for a simulated board, in one folder."""

    def __init__(self, folder):
        self.folder = folder
        write_texts(folder, board_files())

    def build(self, processor, code, main, names, *options):
        """Program of the file code.c, with lines and frames, and a main; functions are counted."""
        cpu, fpu, _ = processor
        self.processor = processor
        heads = [f"int {name}({arguments})" for name, arguments in names.items()]
        declared = "\n".join(f"{head};" for head in heads)
        texts = {"code.c": code, "main.c": f"#include <stdint.h>\n{declared}\n{main}"}
        write_texts(self.folder, {**texts, "count.c": counting_code("", heads)})
        flags = ("-std=c99", "-mthumb", f"-mcpu={cpu}", f"-mfpu={fpu}", "-mfloat-abi=hard")
        command = ("arm-none-eabi-gcc", *flags, "-ffp-contract=off", "-DPAINTED=512")
        self._run(*command, *options, "-g", "-fstack-usage", "-c", "code.c", "-o", "code.o")
        wrapped = [f"-Wl,--wrap={name}" for name in names]
        files = ("main.c", "count.c", "board.c", "code.o", "-lm", "-o", "program")
        options = ("-Os", "-nostartfiles", "--specs=rdimon.specs", "-T", "board.ld")
        self._run(*command, *wrapped, *options, *files)

    def counts(self):
        """Function -> largest count of instructions, bytes of stack."""
        printed = self._run(
            *("qemu-system-arm", "-M", self.processor[2], "-nographic", "-monitor", "none"),
            *("-semihosting-config", "enable=on,target=native", "-icount", "shift=9"),
            *("-kernel", "program"),
        )
        rows = (row.split("\t") for row in printed.splitlines())
        return {name: (int(count), int(stack)) for _, name, count, stack in rows}

    def bounds(self, counted=None):
        """Function of the program -> bounds of its instructions and of its stack."""
        listing = bounds.read_listing(self._run("arm-none-eabi-objdump", "-d", "-l", "program"))
        loops = bounds.c_loops((self.folder / "code.c").read_text(encoding="utf-8"))
        frames = bounds.frames((self.folder / "code.su").read_text(encoding="utf-8"))
        instructions = bounds.Instructions(listing, "code.c", loops, counted or {})
        stack = bounds.Stack(listing, frames)
        names = [name for name in listing.symbols.values() if name.startswith("call_")]
        return {
            name.removeprefix("call_"): (instructions.bound(name), stack.bound(name))
            for name in names
        }

    def _run(self, *words):
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=100)
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture
def board(tmp_path):
    return Board(tmp_path)


STRUCTURED = """
#include <stdint.h>
static double table[12][12];
typedef struct { double x[24]; } Block;
static Block first, second;
__attribute__((noinline)) static double product(const double *a, const double *b)
{
    double sum = 0.0;
    for (int64_t k = 0; k < 12; ++k) {
        sum += a[k] * b[k];
    }
    return sum;
}
int fixed(double *x)
{
    for (int64_t i = 0; i < 12; ++i) {
        for (int64_t j = 0; j < 12; ++j) {
            table[i][j] = *x + (double)i * (double)j;
        }
    }
    for (int64_t pass = 0; pass < 5; ++pass) {
        for (int64_t i = 11; i >= 0; --i) {
            *x += product(table[i], table[11 - i]);
        }
    }
    return 0;
}
int triangle(double *x)
{
    for (int64_t i = 0; i < 12; ++i) {
        for (int64_t j = 0; j <= i; ++j) {
            *x += table[i][j];
        }
        if (*x > 1e9) {
            *x = product(table[i], table[0]);
        }
    }
    return 0;
}
int stopping(double *x)
{
    int64_t pass;
    for (pass = 0; pass < 40; ++pass) {
        if (!(*x < 1e6)) { break; }
        *x = *x * 3.0;
    }
    return pass == 40;
}
int copying(double *x)
{
    double row[30] = {0.0};
    row[3] = *x;
    second = first;
    for (int64_t k = 0; k < 30; ++k) {
        *x += row[k] + row[29 - k];
    }
    return 0;
}
int choosing(double *x)
{
    switch ((int)*x) {
    case 0: *x = 1.0; break;
    case 1: *x = product(table[1], table[2]); break;
    case 2: *x = product(table[1], table[2]) + product(table[3], table[2]); break;
    case 3: *x = 5.0; break;
    case 4: *x = 7.0 * *x; break;
    default: *x = -1.0; break;
    }
    return 0;
}
"""
CALLS = """
int main(void)
{
    static const double values[] = {0.0, 1.0, 2.0, 3.0, 4.0, -3.0, 1e9, 1e-3, -1e30};
    for (unsigned k = 0u; k < sizeof values / sizeof *values; ++k) {
        double x = values[k];
        fixed(&x); x = values[k];
        triangle(&x); x = values[k];
        stopping(&x); x = values[k];
        copying(&x); x = values[k];
        choosing(&x);
    }
    return 0;
}
"""
NAMES = ("fixed", "triangle", "stopping", "copying", "choosing")


@pytest.mark.parametrize(
    ("processor", "optimisation"), [(M7, "-O1"), (M7, "-Os"), (M4, "-O2"), (M7, "-O3")]
)
def test_no_count_is_above_its_bound(board, processor, optimisation):
    board.build(processor, STRUCTURED, CALLS, dict.fromkeys(NAMES, "double *x"), optimisation)
    counts, limits = board.counts(), board.bounds()
    assert counts.keys() == limits.keys() == set(NAMES)
    for name, (count, stack) in counts.items():
        bound, depth = limits[name]
        assert count <= bound.normal <= bound.any, name
        assert stack <= depth <= stack + 16, name
    if optimisation == "-Os":
        # nothing depends on data, and every test is at the end of its loop
        assert limits["fixed"][0].any == counts["fixed"][0]


ARITHMETIC = {
    **{name: f"{name}(x)" for name in ("exp", "exp2", "expm1", "log", "log1p", "asin", "acos")},
    **{name: f"{name}(x)" for name in ("atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh")},
    **{name: f"{name}(x)" for name in ("sqrt", "cbrt", "erf", "erfc", "floor", "ceil", "rint")},
    **{name: f"{name}(x, y)" for name in ("atan2", "pow", "fmod")},
    **{"sum": "x + y", "product": "x * y", "quotient": "x / y", "less": "x < y", "equal": "x == y"},
    **{"whole": "(double)(int64_t)x", "ratio": "(double)(n / m)", "rest": "(double)(n % m)"},
}
"""Operations of emitted code on numbers x, y and integers n, m."""


def arithmetic(real):
    rows = [f"#include <math.h>\n#include <stdint.h>\nvolatile {real} result;"]
    for name, text in ARITHMETIC.items():
        if real == "float":
            text = re.sub(r"^(\w+)\(", r"\1f(", text)
        rows.append(
            f"int of_{name}({real} x, {real} y) {{ const int64_t n = *(int64_t *)&(double){{x}};"
            f" const int64_t m = *(int64_t *)&(double){{y}} | 1; (void)n; (void)m;"
            f" result = ({real})({text}); return 0; }}"
        )
    return "\n".join(rows)


VALUES = """
    static const double values[] = {
        0.0, -0.0, 1.0, -1.0, 0.5, 3.0, 0x1.fffffffffffffp+0, 1e-3, 709.0, -745.0, 1e5, 1e300,
        -1e300, 0x1.fffffffffffffp+1023, 0x1p-1022, 0x0.fffffffffffffp-1022,
        -0x0.0000000000001p-1022, 0x0.0000001p-1022, 0x0.0000000000001p-1022,
        0x1.5555555555555p+5,
        0x1p-126, 0x1p-149, -0x1p-140, 0x1.fffffep+127, 0x1.555554p+3,
        1.0 / 0.0, -1.0 / 0.0, 0.0 / 0.0};
    for (unsigned k = 0u; k < sizeof values / sizeof *values; ++k) {
        for (unsigned j = 0u; j < sizeof values / sizeof *values; ++j) {
"""


@pytest.mark.parametrize(
    ("processor", "real"), [(M4, "double"), (M7, "double"), (M4, "float")], ids=str
)
def test_no_operation_of_the_library_counts_more_than_its_bound(board, processor, real):
    calls = "".join(f"of_{name}(({real})values[k], ({real})values[j]);\n" for name in ARITHMETIC)
    main = f"int main(void)\n{{{VALUES}{calls}}}\n}}\nreturn 0;\n}}\n"
    names = {f"of_{name}": f"{real} x, {real} y" for name in ARITHMETIC}
    board.build(processor, arithmetic(real), main, names, "-Os", "-fno-strict-aliasing")
    counts, limits = board.counts(), board.bounds()
    assert counts.keys() == limits.keys() == names.keys()
    for name, (count, stack) in counts.items():
        bound, depth = limits[name]
        assert count <= bound.any, name
        assert stack <= depth, name
    if (processor, real) == (M4, "double"):
        # subnormal operands take the loops that the smaller bound leaves out
        assert counts["of_product"][0] > limits["of_product"][0].normal
        assert limits["of_product"][0].any <= 2.2 * counts["of_product"][0]
        assert limits["of_quotient"][0].any <= 2.2 * counts["of_quotient"][0]
        assert limits["of_fmod"][0].any <= 3.0 * counts["of_fmod"][0]


RANDOM = """
static uint64_t state = 1u;
static double scale(void) /* 0.5 to 1.5 */
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return 0.5 + (double)(state >> 40) / 16777216.0;
}
"""


@pytest.mark.parametrize(("real", "suffix"), [("double", ""), ("float", "f")])
def test_no_reduction_takes_longer_than_that_of_the_angles(board, real, suffix):
    name = f"__kernel_rem_pio2{suffix}"
    assert name in COUNTED
    names = {name: f"{real} *x, {real} *y, int e0, int nx, int prec, const int32_t *digits"}
    listed = [angle.hex() for angle in angles(real)]
    counts = []
    for passes, scale in ((1, "1.0"), (4, "scale()")):
        main = f"""
            #include <math.h>
            static const {real} angles[] = {{{",".join(listed)}}};
            {RANDOM}
            int main(void)
            {{
                volatile {real} y = ({real})scale();
                for (unsigned k = 0u; k < {len(listed) * passes}u; ++k) {{
                    y = tan{suffix}(angles[k / {passes}] * ({real}){scale});
                }}
                return 0;
            }}"""
        board.build(M7, "", main, names)
        counts.append(board.counts()[name][0])
    assert counts[0] >= counts[1] > 0
