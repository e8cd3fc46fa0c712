# SECONDS_LIMIT ends a check that takes too long.
limit=${SECONDS_LIMIT:-3600}
bounded=""
if command -v timeout > /dev/null 2>&1; then bounded="timeout $limit"; fi
# Almost all time goes into the analysis of values, of which the rules use those of constants: the
# passes for loops are left out.
once="--valueflow-max-iterations=0"
$bounded "$cppcheck" -q --addon=misra --std=c99 $once "../$name.c" > "$work/log" 2>&1
case $? in
    0) ;;
    124) skip "cppcheck takes more than $limit s (SECONDS_LIMIT)" ;;
    *) fail "cppcheck: $(sed q "$work/log")" ;;
esac

# Rule and place of each finding
sed -n 's/^\.\.\/\([^:]*:[0-9]*\):.*\[misra-\(c2012-\)*\([^]]*\)\]$/\3	\1/p' "$work/log" > "$work/findings"
awk -F'\t' 'NR == FNR { if (FNR > 1) reason[$1] = $2; next }
    { count[$1]++; if (!($1 in reason)) print $2 ": rule " $1 }
    END { for (rule in reason) if (!(rule in count)) print "rule " rule ": deviation without a finding" }
' misra/deviations.tsv "$work/findings" > "$work/wrong"
figure "findings" "$(wc -l < "$work/findings" | tr -d ' ')"
figure "findings without a recorded deviation" "$(grep -c '^[^ ]*:[0-9]*: rule' "$work/wrong")"
if [ -s "$work/wrong" ]; then fail "$(sed q "$work/wrong")"; fi
pass
