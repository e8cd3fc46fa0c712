"$cc" @flags@ -O1 -I.. trace/traced.c trace/recorder.c "../${name}_test.c" -lm -o "$work/traced" \
    2> "$work/log" || fail "$(sed -n '/error/{p;q;}' "$work/log")"
TRACE="$work/steps" "$work/traced" > "$work/printed"
cmp -s "$work/printed" ../expected.txt || fail "the run is not as in Python"
cp "$work/steps" results/trace.tsv
figure "groups of statements" "$(wc -l < "$work/steps" | tr -d ' ')"
missed=$(grep -n '	0$' "$work/steps" | sed 's/:.*//')
count=$(echo "$missed" | wc -w | tr -d ' ')
figure "groups that no step executes" "$count"
if [ "$count" -eq 0 ]; then pass; fi
row=$(($(echo "$missed" | sed 1q) + 1))
line=$(sed -n "${row}p" trace/groups.csv | sed 's/.*,\([0-9]*\),[0-9]*,[0-9]*$/\1/')
fail "no step executes the statements at line $line, or those of $((count - 1)) other groups"
