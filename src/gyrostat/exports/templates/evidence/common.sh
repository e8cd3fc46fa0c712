# Functions of the scripts beside this file. The result of NAME.sh is results/NAME.txt: lines of a
# key and its values, with tabs between them.
LC_ALL=C
export LC_ALL
name=@module@
work=$(mktemp -d) || exit 2
outcome=failed
reason="the script did not come to its end"
trap 'finish' EXIT
trap 'exit 1' HUP INT TERM

# begin NAME: what the result is called
begin() {
    kind=$1
    mkdir -p results
    : > "$work/tools"
    : > "$work/figures"
}

# need VARIABLE PROGRAM...: the first program that is installed
need() {
    variable=$1
    shift
    for program in "$@"; do
        if command -v "$program" > /dev/null 2>&1; then
            eval "$variable=\$program"
            printf 'tool\t%s\n' "$(version "$program")" >> "$work/tools"
            return
        fi
    done
    skip "$(echo "$*" | sed 's/ / or /g') is not installed"
}

# version PROGRAM: first line of its version text
version() {
    "$1" --version 2> /dev/null | sed -n '1{s/\t/ /g;p;q;}' | sed "/$1/!s/^/$1 /"
}

# figure NAME VALUE [UNIT]
figure() {
    printf 'figure\t%s\t%s\t%s\n' "$1" "$2" "${3-}" >> "$work/figures"
}

pass() {
    outcome=passed
    reason=""
    exit 0
}

fail() {
    outcome=failed
    reason=$*
    exit 1
}

skip() {
    outcome="not run"
    reason=$*
    exit 0
}

# SHA-256 digest of the input; empty if there is no program for it
digest() {
    if command -v sha256sum > /dev/null 2>&1; then
        sha256sum | sed 's/ .*//'
    elif command -v shasum > /dev/null 2>&1; then
        shasum -a 256 | sed 's/ .*//'
    fi
}

finish() {
    {
        printf 'outcome\t%s\n' "$outcome"
        if [ -n "$reason" ]; then printf 'reason\t%s\n' "$reason"; fi
        printf 'code\t%s\n' "$(cat "../$name.h" "../$name.c" | digest)"
        cat "$work/tools" "$work/figures"
    } > "results/$kind.txt"
    rm -rf "$work"
    printf '%s: %s%s\n' "$kind" "$outcome" "${reason:+: $reason}"
}
