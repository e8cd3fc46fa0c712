if "$cc" -std=c99 -Wall -Wextra -pedantic -Wconversion -Wshadow -Werror -c "../$name.c" -o "$work/object.o" 2> "$work/log"; then
    figure "warnings" 0
    pass
fi
fail "$(sed -n '/warning:\|error:/{p;q;}' "$work/log")"
