# Options, fixed: infinite numbers and NaN are values as others; EVA follows relations of variables
# (equality) and merges states, except where annotations in the code keep them apart.
# SECONDS_LIMIT ends an analysis that takes too long.
limit=${SECONDS_LIMIT:-3600}
bounded=""
if command -v timeout > /dev/null 2>&1; then bounded="timeout $limit"; fi
$bounded "$frama_c" run_time_errors.c "../$name.c" -main main -machdep gcc_x86_64 \
    -warn-special-float none -keep-logical-operators \
    -eva -eva-domains equality -eva-slevel 0@options@ -eva-split-return full \
    -eva-min-loop-unroll 1 -eva-no-show-progress -eva-msg-key=-initial-state,-final-states \
    -then -report-csv "$work/properties.csv" > "$work/log" 2>&1
case $? in
    0) ;;
    124) skip "not proven: the analysis takes more than $limit s (SECONDS_LIMIT)" ;;
    *) fail "frama-c: $(sed -n '/ Error: /{s/^\[[^]]*\] //;p;q;}' "$work/log")" ;;
esac

# Columns: folder, file, line, function, kind, status, property. What is "Considered valid" are
# Frama-C's specifications of the C library. Of a function without one Frama-C assumes that it has
# no effect but its result, which may be any number.
awk -F'\t' '$6 == "Unknown" || $6 ~ /^Invalid/ {
    if ($2 == "math.h" && $5 ~ /^(assigns|from) clause$/) { print $4 > without }
    else { print $2 ":" $3 ": " $5 " " $7 }
}' without="$work/without" "$work/properties.csv" > "$work/unproven"
if [ -f "$work/without" ]; then
    figure "functions without a specification in Frama-C" \
        "$(sort -u "$work/without" | tr '\n' ' ' | sed 's/ $//')"
fi
proven=$(awk -F'\t' '$5 == "postcondition" && $6 == "Valid"' "$work/properties.csv" | wc -l)
sed -n 's/^  In these functions, \([0-9]*\) statements reached (out of \([0-9]*\)).*/\1 \2/p' \
    "$work/log" > "$work/reached"
read -r reached statements < "$work/reached" || fail "frama-c analysed nothing"
figure "alarms" "$(grep -c -v ': postcondition ' "$work/unproven")"
figure "results proven to be finite" "$proven"
figure "results not proven to be finite" "$(grep -c ': postcondition ' "$work/unproven")"
figure "statements reached" "$reached" "of $statements"
if [ -s "$work/unproven" ]; then fail "$(sed q "$work/unproven")"; fi
pass
