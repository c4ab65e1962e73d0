#!/bin/sh
# SPIN explores the same system through the same step(): it must count the same states and transitions, and find no
# state that violates a property. spin.sh LSS-LC VEHICLE SPIN-VERIFIER
set -eu
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
