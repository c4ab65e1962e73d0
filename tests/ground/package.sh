#!/usr/bin/env bash
# package.sh CPACK CONFIG PAGE: the package lss-ground has the program, its unit, its man page, layouts and the page with all
# that it names. Skipped (77) where the page was not built.
set -euo pipefail
[ -e "$3/index.html" ] || { echo "the page was not built"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" --config "$2" -B "$folder" -D CPACK_COMPONENTS_ALL=ground
dpkg-deb -x "$folder"/lss-ground_*.deb "$folder/tree"
cd "$folder/tree/usr"
for file in bin/lss-ground share/lssd/foxglove/zebro.json lib/systemd/system/lss-ground.service share/man/man8/lss-ground.8 share/lssd/ground/index.html; do
  [ -s "$file" ] || { echo "the package has no $file"; exit 1; }
done
named=$(grep -oE '(src|href)="\./[^"]+' share/lssd/ground/index.html | sed 's/.*"\.\///')
[ -n "$named" ]
for file in $named; do
  [ -s "share/lssd/ground/$file" ] || { echo "the package has no $file, which the page names"; exit 1; }
done
if grep -lE '(src|href)="(https?:)?//' share/lssd/ground/index.html; then
  echo "the page loads from elsewhere"
  exit 1
fi
