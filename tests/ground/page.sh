#!/usr/bin/env bash
# page.sh PAGE PLAYWRIGHT: page_test.mjs, if there are node, chromium and the page that was built. LSS_E2E_SHOTS: a folder for its pictures.
set -euo pipefail
for program in node chromium; do command -v $program > /dev/null || { echo "$program is missing"; exit 77; }; done
if [ ! -e "$1/index.html" ] || [ ! -d "$2" ]; then
  echo "the page was not built: target lss-ground-page"
  exit 77
fi
CHROMIUM=$(command -v chromium) PLAYWRIGHT=$2 exec node "$(dirname "$0")/page_test.mjs" "$1" ${LSS_E2E_SHOTS:+"$LSS_E2E_SHOTS"}
