"""Bounds of instructions and stack, of disassembled programs that are written down here."""

import pytest

from gyrostat.codegen.bounds import (
    CLoop,
    Instructions,
    Stack,
    UnboundedError,
    c_loops,
    frames,
    read_listing,
)
from gyrostat.codegen.bounds.__main__ import figures


def listing(**functions):
    """Program: name -> lines of instructions of two bytes.

    `top: ` before an instruction names its address inside the function, `@7 ` says that it and
    those after it are from line 7 of code.c.
    """
    address, places, rows = 0x100, {}, []
    for function, text in functions.items():
        places[function] = address
        rows.append((address, function, ""))
        for line in filter(None, map(str.strip, text.splitlines())):
            label, _, line = line.rpartition(": ")
            places[function, label] = address
            rows.append((address, function, line))
            address += 2
        address = (address + 0x20) & ~0xF
    lines = []
    for address, function, text in rows:
        if not text:
            lines += ["", f"{address:08x} <{function}>:"]
            continue
        if text.startswith("@"):
            number, _, text = text[1:].partition(" ")
            lines.append(f"/somewhere/code.c:{number} (discriminator 2)")
        name, _, operands = text.partition(" ")
        word = operands.rpartition(" ")[2]
        target = places.get((function, word), places.get(word))
        if target is not None:
            operands = operands.removesuffix(word) + f"{target:x} <{word}>"
        lines.append(f"     {address:x}:\t4770      \t{name}\t{operands}")
    return read_listing("\n".join(lines))


def bound(program, name="f", loops=(), counted=None):
    return Instructions(program, "code.c", loops, counted or {}).bound(name)


def test_the_longer_branch_counts():
    program = listing(f="cmp r0, #0\nbeq.n short\nadds r0, #1\nadds r0, #2\nshort: bx lr")
    assert bound(program).any == 5


def test_a_call_counts_where_it_is_made():
    program = listing(f="push {r4, lr}\nbl g\nbl g\npop {r4, pc}", g="adds r0, #1\nbx lr")
    assert bound(program).any == 4 + 2 * 2


def test_a_call_in_the_place_of_the_return_is_part_of_the_function():
    assert bound(listing(f="adds r0, #1\nb.w g", g="adds r0, #1\nbx lr")).any == 4


def test_a_return_under_a_condition_may_not_be_taken():
    assert bound(listing(f="it eq\nbxeq lr\nadds r0, #1\npop {r4, pc}")).any == 4


LOOP = (
    "movs r0, #0\ntop: @5 cmp r0, #10\nbeq.n out\n@6 muls r1, r0\nadds r0, #1\nb.n top\nout: bx lr"
)


def test_a_loop_counts_as_often_as_its_line_of_c_says():
    # ten passes of five instructions, and the test that ends it
    assert bound(listing(f=LOOP), loops=[CLoop(5, 5, 7, 10)]).any == 1 + 10 * 5 + 2 + 1


def test_passes_of_loops_in_loops_multiply():
    text = """
        @1 movs r0, #0
        outer: @2 movs r1, #0
        inner: @3 adds r1, #1
        cmp r1, #4
        bne.n inner
        @2 adds r0, #1
        cmp r0, #3
        bne.n outer
        bx lr"""
    loops = [CLoop(2, 2, 5, 3), CLoop(3, 3, 4, 4)]
    assert bound(listing(f=text), loops=loops).any == 1 + 3 * (4 * 3 + 4) + 1


def test_loops_that_the_compiler_has_merged_count_as_both():
    text = "top: @2 cmp r0, #1\n@3 bne.n top\n@2 bne.n top\nbx lr"
    loops = [CLoop(2, 2, 5, 3), CLoop(3, 3, 4, 4)]
    assert bound(listing(f=text), loops=loops).any == (3 * 4 + 1) * 3 + 1


def test_a_loop_of_the_library_has_the_passes_that_are_known_of_it():
    text = "top: subs r0, #1\nbne.n top\nbx lr"
    assert bound(listing(f="b.w __aeabi_ddiv", __aeabi_ddiv=text)).any == 1 + 13 * 2 + 1
    subnormal = bound(listing(f="b.w __aeabi_dmul", __aeabi_dmul=text))
    assert (subnormal.any, subnormal.normal) == (1 + 53 * 2 + 1, 1 + 2 + 1)


def test_memset_of_a_known_size_writes_each_byte_once():
    text = """
        wide: str r1, [r0]
        str r1, [r0, #4]
        subs r2, #8
        bne.n wide
        narrow: strb r1, [r0]
        bne.n narrow
        bx lr"""
    program = listing(
        f="push {r4, lr}\nmovs r2, #80\nmov r0, sp\nbl memset\npop {r4, pc}", memset=text
    )
    assert bound(program).any == 5 + (80 // 8 + 1) * 4 + (3 + 1) * 2 + 1


def test_a_function_with_a_count_has_that_as_its_bound():
    program = listing(f="b.w g", g="bl __kernel_rem_pio2\nbx lr", __kernel_rem_pio2="bx lr")
    assert bound(program, counted={"__kernel_rem_pio2": 500}).any == 503
    with pytest.raises(UnboundedError, match=r"__kernel_rem_pio2: its largest count is not given"):
        bound(program)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("bl f\nbx lr", "f: recursion"),
        ("blx r3\nbx lr", "f at 0x100: call of a computed address"),
        ("bx r3", "f at 0x100: jump to a computed address"),
        ("ldr pc, [r3]", "f at 0x100: jump to a computed address"),
        ("top: subs r0, #1\nbne.n top\nbx lr", "f at 0x100: a loop of unknown length"),
        (
            "top: @3 subs r0, #1\nbne.n top\nbx lr",
            "f at 0x100, line 3: a loop that C does not have",
        ),
        ("cbz r0, in\ntop: subs r0, #1\nin: subs r1, #1\nbne.n top\nbx lr", "several entries"),
        ("udf #0", "f at 0x100: does not return"),
        ("mov r2, r3\nbl memset\nbx lr", "memset .* a loop of unknown length"),
        ("movs r2, #8\nmul r2, r3\nbl memset\nbx lr", "memset .* a loop of unknown length"),
    ],
)
def test_code_without_a_bound_is_refused(text, reason):
    program = listing(f=text, memset="top: str r1, [r0]\nbne.n top\nbx lr")
    with pytest.raises(UnboundedError, match=reason):
        bound(program)


def test_a_table_of_jumps_leads_to_each_of_its_targets():
    text = """
00000100 <f>:
     100:\te8df f001 \ttbb\t[pc, r1]
     104:\t0402      \t.short\t0x0402
     106:\t03        \t.byte\t0x03
     107:\t00        \t.byte\t0x00
     108:\t4770      \tbx\tlr
     10a:\t3001      \tadds\tr0, #1
     10c:\t3001      \tadds\tr0, #1
     10e:\t4770      \tbx\tlr
"""
    # the entries lead to 0x108, 0x10c and 0x10a; the last byte fills the table up
    assert bound(read_listing(text)).any == 1 + 3


def test_the_stack_is_that_of_the_deepest_chain_of_calls():
    program = listing(
        f="push {r4, r5, lr}\nsub sp, #20\nbl g\nadd sp, #20\nbl h\npop {r4, r5, pc}",
        g="vpush {d8-d11}\nbl h\nvpop {d8-d11}\nbx lr",
        h="str r1, [sp, #-4]!\nldr r1, [sp], #4\nbx lr",
    )
    assert Stack(program, {}).bound("h") == 4
    assert Stack(program, {}).bound("f") == 12 + 20 + 4 * 8 + 4


def test_a_frame_that_the_compiler_says_counts_if_it_is_larger():
    program = listing(f="push {r4, lr}\nbl g\npop {r4, pc}", g="bx lr")
    sizes = frames("code.c:3:5:f\t24\tstatic\ncode.c:9:5:g\t0\tstatic\n")
    assert Stack(program, sizes).bound("f") == 24


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("sub sp, sp, r0\nbx lr", "f at 0x100: a frame of computed size"),
        ("mov sp, r7\nbx lr", "f at 0x100: a frame of computed size"),
        ("top: push {r4}\nbne.n top\nbx lr", "f at 0x100: a loop pushes"),
        ("bl f\nbx lr", "f: recursion"),
    ],
)
def test_a_stack_without_a_bound_is_refused(text, reason):
    with pytest.raises(UnboundedError, match=reason):
        Stack(listing(f=text), {}).bound("f")


def test_a_frame_that_is_not_fixed_is_refused():
    with pytest.raises(UnboundedError, match="f: its frame has no fixed size"):
        frames("code.c:3:5:f\t24\tdynamic\n")


C = """
/* for (k = 0; k < 9; ++k) { */
int f(int n)
{
    for (int64_t k = 0; k < 15; ++k) {
        const int32_t limit = k + 1;
        for (int64_t j = 0; j < limit; ++j) { x[k] = x[j]; }

        for (int64_t j = 14;
             j >= k; j -= 2) {
            x[k] = x[j] == 2.0;
        }
    }
    int64_t pass;
    for (pass = 0; pass < INT64_C(1000); ++pass) {
        if (x[0] > "}"[0]) { break; }
    }
    return 0;
}
"""


def test_loops_of_c_have_the_passes_of_their_counters():
    assert c_loops(C) == [
        CLoop(5, 5, 13, 15, 4),
        CLoop(7, 7, 7, 15, 4),
        CLoop(9, 10, 12, 8, 4),
        CLoop(15, 15, 17, 1000, 4),
    ]


@pytest.mark.parametrize(
    ("loop", "reason"),
    [
        ("while (x) {}", "line 1: found while, expected for"),
        ("again: goto again;", "line 1: found goto, expected for"),
        ("for (;;) {}", "line 1: found for .*, expected a counted loop"),
        ("for (k = 0; k < n; ++k) {}", "line 1: found n, expected a constant limit"),
        ("for (k = 0; k < 3; --k) {}", "line 1: the counter does not approach its limit"),
        ("for (k = 0; k < 3; ++j) {}", "line 1: the counter does not approach its limit"),
        ("for (k = 0; k < 3; ++k) { k = 0; }", "line 1: the body changes the counter k"),
        ("for (k = 0; k < 3; ++k) { f(&k); }", "line 1: the body changes the counter k"),
        ("for (k = 0; k < 3; ++k) f();", "line 1: found for without braces"),
    ],
)
def test_loops_of_another_form_are_refused(loop, reason):
    with pytest.raises(UnboundedError, match=reason):
        c_loops(loop)


PROGRAM = """
00000100 <call_step>:
     100:\tb510      \tpush\t{r4, lr}
     102:\tf000 f80c \tbl\t120 <step>
     106:\tbd10      \tpop\t{r4, pc}

00000120 <step>:
     120:\t3001      \tadds\tr0, #1
     122:\t4770      \tbx\tlr
"""


@pytest.mark.parametrize(
    ("count", "stack", "wrong"),
    [(5, 8, []), (6, 8, ["M7: step is above its bound"]), (5, 12, ["M7: step is above its bound"])],
)
def test_counts_stand_beside_their_bounds_and_above_them_is_wrong(tmp_path, count, stack, wrong):
    texts = {
        "listing": PROGRAM,
        "code.c": "",
        "frames": "code.c:3:5:step\t0\tstatic\n",
        "counts": f"step: as in Python\ncount\tstep\t{count}\t{stack}\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    rows, found = figures("M7", [tmp_path / name for name in texts])
    assert found == wrong
    assert rows == [
        "figure\tM7: step, bound\t5\tinstructions",
        f"figure\tM7: step, largest count\t{count}\tinstructions",
        f"figure\tM7: step, bound over count\t{5 / count:.2f}\t",
        "figure\tM7: step, stack bound\t8\tbytes",
        f"figure\tM7: step, stack used\t{stack}\tbytes",
    ]
