# Options, fixed: infinite numbers and NaN are values as others; EVA follows relations of variables
# (equality) and merges states, except where annotations in the code keep them apart.
"$frama_c" run_time_errors.c "../$name.c" -main main -machdep gcc_x86_64 \
    -warn-special-float none -keep-logical-operators \
    -eva -eva-domains equality -eva-slevel 0@options@ -eva-split-return full \
    -eva-min-loop-unroll 1 -eva-no-show-progress -eva-msg-key=-initial-state,-final-states \
    -then -report-csv "$work/properties.csv" > "$work/log" 2>&1 ||
    fail "frama-c: $(sed -n '/ Error: /{s/^\[[^]]*\] //;p;q;}' "$work/log")"

# Columns: folder, file, line, function, kind, status, property. What is "Considered valid" are
# Frama-C's specifications of the C library.
awk -F'\t' '$6 == "Unknown" || $6 ~ /^Invalid/ { print $2 ":" $3 ": " $5 " " $7 }' \
    "$work/properties.csv" > "$work/unproven"
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
