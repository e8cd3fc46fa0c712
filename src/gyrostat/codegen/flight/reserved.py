"""Names that emitted C must not use: words of C and C++, macros, and names of the C library."""

import re

from gyrostat.codegen.flight.expressions import HELPERS

KEYWORDS = frozenset(
    {
        *("auto", "bool", "break", "case", "char", "const", "continue", "default", "do"),
        *("double", "else", "enum", "extern", "false", "float", "for", "goto", "if", "inline"),
        *("int", "long", "register", "restrict", "return", "short", "signed", "sizeof"),
        *("static", "struct", "switch", "true", "typedef", "union", "unsigned", "void"),
        *("volatile", "while", "asm", "typeof"),
        *("_Alignas", "_Alignof", "_Atomic", "_Bool", "_Complex", "_Generic", "_Imaginary"),
        *("_Noreturn", "_Pragma", "_Static_assert", "_Thread_local"),
    }
)
"""Keywords of C99 and C11, and those of GNU C that have no underscore."""
HEADERS = frozenset(
    {
        *("assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits"),
        *("locale", "math", "setjmp", "signal", "stdalign", "stdarg", "stdatomic", "stdbool"),
        *("stddef", "stdint", "stdio", "stdlib", "stdnoreturn", "string", "tgmath", "threads"),
        *("time", "uchar", "wchar", "wctype"),
    }
)
"""Headers of the C library, which a file of the same name would hide."""
CPP_KEYWORDS = frozenset(
    {
        *("alignas", "alignof", "and", "and_eq", "bitand", "bitor", "catch", "char16_t"),
        *("char32_t", "char8_t", "class", "co_await", "co_return", "co_yield", "compl", "concept"),
        *("consteval", "constexpr", "constinit", "const_cast", "decltype", "delete"),
        *("dynamic_cast", "explicit", "export", "friend", "mutable", "namespace", "new"),
        *("noexcept", "not", "not_eq", "nullptr", "operator", "or", "or_eq", "private"),
        *("protected", "public", "reinterpret_cast", "requires", "static_assert", "static_cast"),
        *("template", "this", "thread_local", "throw", "try", "typeid", "typename", "using"),
        *("virtual", "wchar_t", "xor", "xor_eq"),
    }
)
"""Keywords and alternative tokens of C++, up to C++20, that are none of C."""
FUNCTIONS = frozenset(
    {
        *HELPERS.values(),
        *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "cos"),
        *("cosh", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "isfinite"),
        *("log", "log1p", "main", "memcpy", "pow", "printf", "rint", "round", "sin", "sinh"),
        *("sqrt", "status", "tan", "tanh"),
    }
)
"""Names used by the emitted code, not available for variables."""
MACROS = re.compile(
    r"U?INT(_LEAST|_FAST)?\d+_(MAX|MIN|C)|U?INT(MAX|PTR)_(MAX|MIN|C)"
    r"|(U?CHAR|SCHAR|U?SHRT|U?INT|U?LONG|U?LLONG|PTRDIFF|SIG_ATOMIC|S?SIZE|WCHAR|WINT)_(MAX|MIN)"
    r"|(FLT|DBL|LDBL)_(\w+_)?(DIG|EPSILON|EXP|MAX|MIN|ROUNDS|RADIX|METHOD|SUBNORM)"
    r"|M_(E|LOG2E|LOG10E|LN2|LN10|PI|PI_2|PI_4|1_PI|2_PI|2_SQRTPI|SQRT2|SQRT1_2)"
    r"|FP_(INFINITE|NAN|NORMAL|SUBNORMAL|ZERO|ILOGB0|ILOGBNAN|FAST_FMA[FL]?)"
    r"|NAN|INFINITY|HUGE_VAL[FL]?|HUGE|MATH_ERRNO|MATH_ERREXCEPT|math_errhandling|signgam"
    r"|EOF|NULL|BUFSIZ|FILENAME_MAX|FOPEN_MAX|L_\w*[^\W_]|P_tmpdir|SEEK_(SET|CUR|END)|TMP_MAX"
    r"|stdin|stdout|stderr|errno|EDOM|EILSEQ|ERANGE|offsetof|assert|NDEBUG"
    r"|CHAR_BIT|MB_LEN_MAX|MB_CUR_MAX|DECIMAL_DIG|RAND_MAX|EXIT_(SUCCESS|FAILURE)"
    r"|(BIG|LITTLE|PDP)_ENDIAN|BYTE_ORDER|FD_SETSIZE|NFDBITS"
    r"|W(NOHANG|UNTRACED|STOPPED|EXITED|CONTINUED|NOWAIT)"
    r"|linux|unix|i386|GYROSTAT_\w+_H"
    r"|u?int(_least|_fast)?\d+_t|u?int(max|ptr)_t|size_t|ptrdiff_t|max_align_t"
)
"""Macros and types of the standard headers that emitted C and its test program include, and those
that compilers define; the guard of a header."""
_MATH = (
    *("copysign", "exp10", "fdim", "fma", "fmax", "fmin", "frexp", "hypot", "ilogb", "ldexp"),
    *("lgamma", "llrint", "llround", "log10", "log2", "logb", "lrint", "lround", "modf", "nan"),
    *("nearbyint", "nextafter", "nexttoward", "remainder", "remquo", "scalbln", "scalbn"),
    *("tgamma", "trunc", "drem", "finite", "gamma", "isinf", "isnan", "j0", "j1", "jn", "pow10"),
    *("scalb", "significand", "y0", "y1", "yn"),
)
MATH = frozenset(
    {
        *(f"{name}{kind}" for name in (*_MATH, *FUNCTIONS) for kind in ("", "f", "l")),
        *("double_t", "float_t", "fpclassify", "isgreater", "isgreaterequal", "isless"),
        *("islessequal", "islessgreater", "isnormal", "isunordered", "lgamma_r", "signbit"),
    }
)
"""Names that math.h declares: none for a function or a type of the module."""
LIBRARY = MATH | frozenset(
    {
        *("FILE", "abort", "abs", "atexit", "atof", "atoi", "atol", "atoll", "bcmp", "bcopy"),
        *("bsearch", "bzero", "calloc", "clearerr", "ctermid", "div", "div_t", "drand48"),
        *("exit", "fclose", "fdopen", "feof", "ferror", "fflush", "ffs", "fgetc", "fgetpos"),
        *("fgets", "fileno", "fopen", "fpos_t", "fprintf", "fputc", "fputs", "fread", "free"),
        *("freopen", "fscanf", "fseek", "fsetpos", "ftell", "fwrite", "getc", "getchar"),
        *("getenv", "getline", "gets", "index", "labs", "ldiv", "ldiv_t", "llabs", "lldiv"),
        *("lldiv_t", "malloc", "memccpy", "memchr", "memcmp", "memmove", "memset", "off_t"),
        *("pclose", "perror", "popen", "putc", "putchar", "puts", "qsort", "rand", "random"),
        *("realloc", "remove", "rename", "rewind", "rindex", "scanf", "setbuf", "setvbuf"),
        *("snprintf", "sprintf", "srand", "srandom", "sscanf", "strcat", "strchr", "strcmp"),
        *("strcoll", "strcpy", "strcspn", "strdup", "strerror", "strlen", "strncat", "strncmp"),
        *("strncpy", "strpbrk", "strrchr", "strspn", "strstr", "strtod", "strtof", "strtok"),
        *("strtol", "strtold", "strtoll", "strtoul", "strtoull", "strxfrm", "system", "time_t"),
        *("tmpfile", "tmpnam", "ungetc", "va_list", "vfprintf", "vprintf", "vsnprintf"),
        *("vsprintf", "OUTPUTS", "VECTOR_INPUTS", "VECTOR_ROWS", "add_errors", "cut_short"),
        *("first", "name", "vector", "vector_begins", "vector_change", "vector_prepare"),
        *("vector_set", "vector_step"),
    }
)
"""Names that the test program and its headers declare: none for a type of the module."""
