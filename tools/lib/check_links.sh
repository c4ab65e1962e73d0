#!/usr/bin/env bash
# check_links.sh [ROOT]: every relative link in a Markdown file points to an existing file. Blocks of code have no links.
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"

# FILE:LINE:LINK for each link
links() {
  # shellcheck disable=SC2016  # $0 is awk's
  find . -name build -prune -o -name .git -prune -o -name '*.md' -print | sort |
    xargs awk 'FNR == 1 { code = 0 } $0 ~ "^ *\x60\x60\x60" { code = !code }
               !code { text = $0
                       while (match(text, /\]\([^)#: ]+/)) {
                         print FILENAME ":" FNR ":" substr(text, RSTART + 2, RLENGTH - 2)
                         text = substr(text, RSTART + RLENGTH)
                       } }'
}

broken=0
while IFS=: read -r file line link; do
  case $link in http | https | mailto) continue ;; esac
  target=${file%/*}/${link%%#*}
  [ -e "$target" ] && continue
  printf '%s:%s: link to %s leads nowhere\n' "$file" "$line" "$link"
  broken=1
done < <(links)
exit "$broken"
