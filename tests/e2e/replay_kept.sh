#!/usr/bin/env bash
# replay_kept.sh LSSD FOLDER [EMULATOR...]: replays the recordings that a build of another preset left there, also by a
# program of another processor. Skipped (77) when there are none, or none of this layout, or no such program.
set -u
[ -x "$1" ] || { echo "Skipped: there is no $1; tools/package --arch arm64 makes it" && exit 77; }
FOREIGN=4  # exit code of lssd --replay: another layout, format or vehicle
replayed=0
for file in "$2"/*.lssrec; do
  [ -e "$file" ] || break
  "${@:3}" "$1" --replay "$file"
  code=$?
  [ "$code" -eq "$FOREIGN" ] && continue
  [ "$code" -eq 0 ] || exit 1
  replayed=$((replayed + 1))
done
echo "$replayed recordings are equal"
[ "$replayed" -gt 0 ] || exit 77
