"""Loops of the C library and of the compiler's arithmetic.

Their sources are those of newlib (libm, from FreeBSD's msun) and of libgcc (config/arm).
"""

REPEATS = {
    # a quotient of 53 bits and the guard bits, four in each pass: 5 + 8 passes
    "__aeabi_ddiv": 12,
    # a root bit by bit, in two words of at most 32
    "__ieee754_sqrt": 31,
    # pi/2 is subtracted from three numbers of 24 bits; those that are zero are passed over
    "__ieee754_rem_pio2": 2,
    "__ieee754_rem_pio2f": 2,
    # a rest bit by bit, for the largest difference of exponents, subnormal numbers included
    "__ieee754_fmod": 2098,
    "__ieee754_fmodf": 277,
}
"""Function -> how often a loop in it returns to its beginning at most."""

NORMALISING = {"__aeabi_dmul": 52}
"""Function -> the same, of loops for subnormal operands alone: one pass for each leading zero."""

MEMORY = {
    # 64, 16 and 4 bytes in a pass: 3 passes of the narrower; less than 8 bytes, one by one
    "memcpy": 7,
    # bytes up to a whole word, 16 bytes in a pass, the rest in words and bytes
    "memset": 3,
    # bytes, all of them if the addresses differ in their last two digits
    "memmove": None,
}
"""Function whose third argument is the number of bytes that it writes, each once -> largest number
of passes of the loops that write fewer bytes in a pass than the widest; None if there is none."""

COUNTED = ("__kernel_rem_pio2", "__kernel_rem_pio2f")
"""Functions whose bound is the largest count over adversarial arguments: the reduction of angles
above 8e5 rad (float: 200 rad) by pi/2, whose passes depend on the digits of the angle."""
