"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "python3 is older than 3.10"
options="@flags@ -mthumb -mfloat-abi=hard"
program="-nostartfiles --specs=rdimon.specs -T resources/board.ld"
reduction="@reduction@"
printf 'tool\tnewlib %s\n' "$(echo '#include <newlib.h>' | "$gcc" -E -dM - |
    sed -n 's/.* _NEWLIB_VERSION "\(.*\)"/\1/p')" >> "$work/tools"
figure options "$options"

# on BOARD PROGRAM: what the program prints; an instruction takes 512 ns
on() {
    "$qemu" -M "$1" -nographic -monitor none -semihosting-config enable=on,target=native \
        -icount shift=9 -kernel "$2" < /dev/null
}

# build NAME WORDS...
build() {
    label=$1
    shift
    "$gcc" "$@" > "$work/log" 2>&1 || fail "$label: $(sed -n '/error\|undefined/{p;q;}' "$work/log")"
}

# measure NAME CPU FPU BOARD PSRAM
measure() {
    built="$options -mcpu=$2 -mfpu=$3 -Wl,--defsym=psram=$5"
    # shellcheck disable=SC2086
    {
        build "$1" $built -g -fstack-usage -c "../$name.c" -o "$work/code.o"
        build "$1" $built -I.. "../${name}_test.c" resources/count.c resources/board.c \
            "$work/code.o" $program @wrapped@ -lm -o "$work/test.elf"
        build "$1" $built -nostartfiles --specs=nosys.specs -Wl,--gc-sections @entries@ \
            "$work/code.o" -lm -o "$work/flight.elf"
    }
    on "$4" "$work/test.elf" > "$work/counts" || fail "$1: the test program failed"
    grep -v '^count' "$work/counts" | cmp -s - ../expected.txt || fail "$1: not as in Python"
    if [ -n "$reduction" ]; then
        "$python" -B -m bounds.angles @real@ > "$work/angles.h"
        # shellcheck disable=SC2086
        build "$1" $built -I"$work" resources/angles.c resources/count_reduction.c \
            resources/board.c $program "-Wl,--wrap=$reduction" -lm -o "$work/angles.elf"
        on "$4" "$work/angles.elf" >> "$work/counts" || fail "$1: the program of angles failed"
    fi
    "$objdump" -d -l "$work/test.elf" > "$work/listing"
    "$python" -B -m bounds "$1" "$work/listing" "../$name.c" "$work/code.su" "$work/counts" \
        > "$work/bounds" 2> "$work/log" || fail "$(cat "$work/log")"
    cat "$work/bounds" >> "$work/figures"
    # shellcheck disable=SC2046
    set -- "$1" $("$size" "$work/code.o" "$work/flight.elf" | awk 'NR > 1 { print $1, $2 + $3 }')
    memory "$1, code and constants" "$2"
    memory "$1, static data" "$3"
    memory "$1, code and constants with the C library" "$4"
    memory "$1, static data with the C library" "$5"
}

memory() {
    printf 'figure\tmemory: %s\t%s\tbytes\n' "$1" "$2" >> "$work/memory"
}

measure Cortex-M4F cortex-m4 fpv4-sp-d16 mps2-an386 0x21000000
measure Cortex-M7 cortex-m7 fpv5-d16 mps2-an500 0x60000000
cat "$work/memory" >> "$work/figures"
pass
