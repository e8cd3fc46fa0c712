flags="@flags@ -O1 -fsanitize=address,undefined -fno-sanitize-recover=all"
echo 'int main(void) { return 0; }' > "$work/empty.c"
# shellcheck disable=SC2086
"$cc" $flags "$work/empty.c" -o "$work/empty" > "$work/log" 2>&1 && "$work/empty" ||
    skip "the sanitizers of $cc are not installed"
# shellcheck disable=SC2086
"$cc" $flags -I.. "../$name.c" "../${name}_test.c" -lm -o "$work/test" 2> "$work/log" ||
    fail "$(sed -n '/error/{p;q;}' "$work/log")"
"$work/test" > "$work/printed" 2> "$work/log" ||
    fail "$(sed -n '/runtime error\|ERROR/{p;q;}' "$work/log")"
cmp -s "$work/printed" ../expected.txt || fail "the run is not as in Python"
figure "findings" 0
pass
