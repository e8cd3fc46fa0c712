"$cc" @flags@ -O1 -I.. trace/traced.c trace/recorder.c "../${name}_test.c" -lm -o "$work/traced" \
    2> "$work/log" || fail "$(sed -n '/error/{p;q;}' "$work/log")"
TRACE="$work/steps" "$work/traced" > "$work/printed"
cmp -s "$work/printed" ../expected.txt || fail "the run is not as in Python"
cp "$work/steps" results/trace.tsv
figure "groups of statements" "$(wc -l < "$work/steps" | tr -d ' ')"
figure "groups that no step executes" "$(grep -c '	0$' "$work/steps")"
pass
