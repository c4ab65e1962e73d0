#!/usr/bin/env bash
# check.sh PAGE PROGRAM [WORD...]: the manual page formats without a complaint and has every option and every verb of
# `PROGRAM WORD... --help`.
set -euo pipefail
page=$1
shift
if command -v man > /dev/null; then
  complaints=$(MANROFFSEQ='' LC_ALL=C.UTF-8 man --warnings -E UTF-8 -l -Tutf8 -Z "$page" 2>&1 > /dev/null)
  [ -z "$complaints" ] || { echo "$complaints"; exit 1; }
fi
text=$(sed 's/\\-/-/g' "$page")
help=$("$@" --help)
options=$(grep -oE '^  +(-[a-z],)?--[a-z][a-z-]*' <<< "$help" | grep -oE -- '--[a-z-]+')
verbs=$(awk '/^Subcommands:/ { inside = 1; next } /^[^ ]|^$/ { inside = 0 } inside && /^  [a-z]/ { print $1 }' <<< "$help")
[ -n "$options" ]
missing=0
for word in $options $verbs; do
  grep -qE -- "(^|[^a-z-])$word([^a-z-]|\$)" <<< "$text" || { echo "$page: does not have $word"; missing=1; }
done
exit "$missing"
