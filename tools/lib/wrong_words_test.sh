#!/usr/bin/env bash
# Wrong words are refused by the tools before they install or build anything.
set -euo pipefail
cd "$(dirname "$0")/../.."

refused() {  # WHAT-IT-SAYS COMMAND...
  local says=$1 status=0 output
  shift
  output=$(timeout 10 "$@" 2>&1 < /dev/null) || status=$?
  if [ "$status" -ne 2 ] || [[ $output != *"$says"* ]]; then
    printf '%s: exit %d, expected 2 and "%s"\n%s\n' "$*" "$status" "$says" "$output"
    exit 1
  fi
}

refused "no such vehicle: lander; there are" tools/demo lander
refused "one vehicle at a time, not zebro ardito" tools/demo zebro ardito
refused "whole number above 0, not 'x'" tools/demo --seconds x
refused "whole number above 0, not ''" tools/demo --seconds
refused "whole number above 0, not '0'" tools/demo --seconds 0
refused "no such option: --slow" tools/demo --slow
refused "not both" tools/demo --fast --realtime
refused "not 'mips' and 'bookworm'" tools/package --arch mips
refused "not '' and 'bookworm'" tools/package --arch
refused "not 'arm64' and ''" tools/package --suite
refused "no such option: --all" tools/package --all
refused "no such part: releas" tools/test releas
refused "Arguments of ctest follow --" tools/test release --
refused "an exclusion needs a part" tools/test -- -E Gait
