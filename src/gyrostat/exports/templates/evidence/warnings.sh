flags="-Wall -Wextra -pedantic -Wconversion -Wshadow -Wcast-qual -Wundef -Wformat=2 -Werror"
printf "#include \"%s.h\"\n" "$name" > "$work/header.cpp"

# check NAME PROGRAM OPTIONS...: counts the warnings of a program, or says that it is not installed
check() {
    label=$1
    program=$2
    shift 2
    if ! command -v "$program" > /dev/null 2>&1; then
        figure "$label" "not run" "($program is not installed)"
    elif "$program" "$@" -c -o "$work/object.o" > "$work/log" 2>&1; then
        figure "$label" 0 warnings
    else
        fail "$label: $(sed -n '/warning:\|error:/{p;q;}' "$work/log")"
    fi
}

# first PROGRAM...: the first that is installed, or the first
first() {
    for each in "$@"; do
        if command -v "$each" > /dev/null 2>&1; then
            echo "$each"
            return
        fi
    done
    echo "$1"
}

# shellcheck disable=SC2086
{
    check "gcc, C99" gcc -std=c99 $flags -Wstrict-prototypes "../$name.c"
    check "gcc, static analysis" gcc -std=c99 -O1 -fanalyzer -Werror "../$name.c"
    check "clang, C99" "$(first clang clang-19)" -std=c99 $flags -Wstrict-prototypes "../$name.c"
    check "g++, header in C++17" g++ -std=c++17 $flags -Wold-style-cast -I.. "$work/header.cpp"
    check "clang++, header in C++17" "$(first clang++ clang++-19)" -std=c++17 $flags -Wold-style-cast -I.. "$work/header.cpp"
}
figure "options" "$flags"
pass
