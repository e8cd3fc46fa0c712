"$clang" @flags@ -O0 -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc -c "../$name.c" \
    -o "$work/code.o" 2> "$work/log" || fail "$(sed -n 1p "$work/log")"
"$clang" @flags@ -fprofile-instr-generate "$work/code.o" "../${name}_test.c" -lm -o "$work/test" \
    2> "$work/log" || fail "$(sed -n 1p "$work/log")"
LLVM_PROFILE_FILE="$work/raw" "$work/test" > "$work/outputs" || fail "an output is not as in Python"
"$profdata" merge "$work/raw" -o "$work/profile" || fail "$profdata"
"$cov" report -show-mcdc-summary "$work/test" -instr-profile="$work/profile" "../$name.c" \
    > "$work/report" || fail "$cov report"
"$cov" show -show-branches=count -show-mcdc "$work/test" -instr-profile="$work/profile" "../$name.c" \
    > "$work/show" || fail "$cov show"

awk -f coverage/missing.awk "$work/show" | sort -u > "$work/missing"
for list in justified confirm; do cut -f 1 "coverage/$list.txt" | sort -u > "$work/$list"; done
set -- $(tail -n 1 "$work/report")
figure "lines" "$8" && figure "lines not shown" "$9"
figure "branches" "${11}" && figure "branches not shown" "${12}"
figure "conditions (MC/DC)" "${14:-0}" && figure "conditions not shown (MC/DC)" "${15:-0}"
[ "${14:-0}" = @conditions@ ] || fail "$clang counts ${14:-0} conditions (MC/DC), expected @conditions@"
figure "justified" "$(grep -c . "$work/justified")"
comm -23 "$work/missing" "$work/justified" > "$work/open"
figure "justified, to be confirmed by a review" "$(comm -12 "$work/open" "$work/confirm" | grep -c .)"
open=$(comm -23 "$work/open" "$work/confirm" | sed -n '1p')
[ -z "$open" ] || fail "not shown: $open"
shown=$(comm -13 "$work/missing" "$work/justified" | sed -n '1p')
[ -z "$shown" ] || fail "justified, but shown: $shown"
pass
