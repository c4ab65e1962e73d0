#!/usr/bin/env bash
# check_links.sh [ROOT]: every relative link in a Markdown file points to an existing file.
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"
broken=0
while IFS=: read -r file line link; do
  case $link in http | https | mailto) continue ;; esac
  target=$(dirname "$file")/${link%%#*}
  [ -e "$target" ] && continue
  printf '%s:%s: link to %s leads nowhere\n' "$file" "$line" "$link"
  broken=1
done < <(find . -name build -prune -o -name .git -prune -o -name '*.md' -print | sort |
  xargs grep -HnoE '\]\([^)#: ]+' | sed 's/:\](/:/')
exit "$broken"
