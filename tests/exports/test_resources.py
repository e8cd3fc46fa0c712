"""Bounds of instructions and stack against counts on simulated processors."""

import re
import subprocess
from pathlib import Path

import pytest

from gyrostat.codegen.bounds.angles import angles
from gyrostat.codegen.bounds.library import COUNTED
from gyrostat.exports import read_results

SOAK = Path(__file__).parents[2] / "benchmarks" / "soak_bounds.py"
M4 = ("cortex-m4", "fpv4-sp-d16", "mps2-an386", "0x21000000")
M7 = ("cortex-m7", "fpv5-d16", "mps2-an500", "0x60000000")


@pytest.fixture(scope="module")
def soak(module_at):
    if not SOAK.is_file():
        pytest.skip("found no benchmarks/soak_bounds.py, which a source distribution lacks")
    soak = module_at(SOAK)
    if missing := soak.missing_tools():
        pytest.skip(f"{', '.join(missing)} not installed")
    return soak


@pytest.fixture
def board(soak, tmp_path):
    return soak.Board(tmp_path)


@pytest.mark.parametrize("seed", range(3))
def test_no_count_of_a_random_program_is_above_its_bound(soak, board, seed):
    ratios, unbounded, wrong = soak.check(board, seed)
    assert len(ratios) == 3
    assert not unbounded
    assert not wrong


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


MODEL = """
[wheel]
inertia = 0.0015
motor_constant = 0.0228

[friction]
model = "stribeck"
viscous = 4.83e-06
coulomb = 0.8795e-3
static = 0.9055e-3
stribeck_speed = 0.418879
"""


@pytest.fixture
def folder(soak, run, tmp_path):
    """Flight folder of an attitude law."""
    (tmp_path / "model.toml").write_text(MODEL, encoding="utf-8")
    words = ("--to", "c", "--what", "controller", "--period", "100ms", "--gains", "0.1,0.01,0.3")
    code, _, said = run("export", tmp_path / "model.toml", *words, "--out", tmp_path / "out")
    assert code == 0, said
    return tmp_path / "out"


def resources(folder):
    """Result of the evidence about resources, and its figures: name -> value."""
    script = folder / "evidence" / "run.sh"
    subprocess.run(["sh", script, "resources"], capture_output=True, timeout=100)
    (result,) = (each for each in read_results(folder) if each.name == "resources")
    return result, {figure.name: figure.value for figure in result.figures}


def test_the_folder_counts_and_bounds_each_entry(folder):
    result, figures = resources(folder)
    assert (result.outcome, result.reason) == ("passed", "")
    assert any("newlib" in tool for tool in result.tools)
    for processor in ("Cortex-M4F", "Cortex-M7"):
        for entry in ("controller_parameters", "controller_start", "controller_step"):
            name = f"{processor}: {entry}"
            count, bound = int(figures[f"{name}, largest count"]), int(figures[f"{name}, bound"])
            assert 0 < count <= bound
            stack, depth = int(figures[f"{name}, stack used"]), int(figures[f"{name}, stack bound"])
            assert 0 < stack <= depth
        code = int(figures[f"memory: {processor}, code and constants"])
        assert (
            0 < code <= int(figures[f"memory: {processor}, code and constants with the C library"])
        )
        assert figures[f"memory: {processor}, static data"] == "0"


def test_results_that_are_not_those_of_python_fail(folder):
    expected = folder / "expected.txt"
    text = expected.read_text(encoding="utf-8").replace("as in Python", "not as in Python", 1)
    expected.write_text(text, encoding="utf-8")
    result, _ = resources(folder)
    assert (result.outcome, result.reason) == ("failed", "Cortex-M4F: not as in Python")


def test_a_loop_without_a_bound_fails(folder):
    source = folder / "controller.c"
    text = source.read_text(encoding="utf-8")
    where = text.rindex("    return 0;")
    loop = "    while (command->current > 1e9) { command->current -= 1.0; }\n"
    source.write_text(text[:where] + loop + text[where:], encoding="utf-8")
    result, _ = resources(folder)
    assert result.outcome == "failed"
    assert re.fullmatch(r"Cortex-M4F: line \d+: found while, expected for", result.reason)
