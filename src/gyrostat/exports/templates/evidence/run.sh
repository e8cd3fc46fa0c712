# Runs the scripts that are named, or all, and prints the outcome of each. Status 1: one has failed.
cd "$(dirname "$0")" || exit 2
status=0
for kind in ${*:-@kinds@}; do
    sh "./$kind.sh" || status=1
done
exit $status
