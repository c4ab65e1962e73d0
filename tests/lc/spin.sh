#!/bin/sh
# SPIN explores the same system through the same step(): it must count the same states and transitions, and find no
# state that violates a property. One vehicle at each commit, all with LSS_EVERYTHING.
# spin.sh LSS-LC VEHICLE SPIN-VERIFIER NUMBER
set -eu
if [ -z "${LSS_EVERYTHING:-}" ] && [ $(((${LSS_SAMPLE:-0} + $4) % 3)) -ne 0 ]; then
  echo "skipped: not in the sample of one in 3; LSS_EVERYTHING=1 runs all"
  exit 77
fi
number() { sed -n "s/^ *\"$1\": \([0-9]*\).*/\1/p"; }
ours=$("$1" explore "$2" --json)
states=$(echo "$ours" | number states)
transitions=$(echo "$ours" | number transitions)
theirs=$("$3" -w24 -m10000000)
echo "$theirs"
echo "$theirs" | grep -q "errors: 0" || { echo "SPIN found an error"; exit 1; }
echo "$theirs" | grep -q "^ *$states states, stored" || { echo "ours: $states states"; exit 1; }
# SPIN counts the way to the first state, too, and prints eight digits.
counted=$(printf '%.8g' $((transitions + 1)))
echo "$theirs" | grep -q "^ *$counted transitions" || { echo "ours: $transitions transitions"; exit 1; }
echo "the same: $states states, $transitions transitions"
