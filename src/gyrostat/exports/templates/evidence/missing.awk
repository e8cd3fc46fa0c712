# What a report of llvm-cov show says is not covered: "line LINE", "branch LINE:COLUMN true" or "false",
# "condition LINE:COLUMN" for a condition that does not decide alone.
/^ *[0-9]+\| *0\|/ { split($0, part, "|"); print "line " part[1] + 0 }
/Branch \([0-9:]+\): \[True: / {
    at = $0
    sub(/.*Branch \(/, "", at)
    sub(/\).*/, "", at)
    if ($0 ~ /True: 0,/) { print "branch " at " true" }
    if ($0 ~ /False: 0\]/) { print "branch " at " false" }
}
/Condition C[0-9]+ --> / {
    at = $NF
    gsub(/[()]/, "", at)
    place[$3] = at
}
/C[0-9]+-Pair: not covered/ {
    name = $2
    sub(/-Pair:/, "", name)
    print "condition " place[name]
}
