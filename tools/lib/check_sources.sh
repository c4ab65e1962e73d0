#!/usr/bin/env bash
# check_sources.sh [ROOT]: checks what each folder may include and name, and some words. Prints FILE:LINE for each
# violation and fails when there is one. Rules for linking: cmake/link_rules.cmake.
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"
faults=0

# Sources below the given folders. No source is not an error.
sources() {
  local folder
  for folder in "$@"; do
    [ -d "$folder" ] && find "$folder" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.c' \)
  done | sort
}

report() {  # RULE; FILE:LINE:TEXT lines on stdin
  local line
  while IFS= read -r line; do
    printf '%s\n    %s\n' "$line" "$1"
    faults=$((faults + 1))
  done
}

# includes FOLDER... : FILE:LINE:TARGET of every #include, as "x" or <x>
includes() {
  sources "$@" | xargs -r grep -HnE '^[[:space:]]*#[[:space:]]*include' |
    sed -E 's/^([^:]*:[0-9]+:)[[:space:]]*#[[:space:]]*include[[:space:]]*/\1/' || true
}

# code FOLDER... : FILE:LINE:TEXT without comments and text in quotes
code() {
  sources "$@" | xargs -r grep -Hn '' | sed -E 's/"([^"\\]|\\.)*"/""/g; s@//.*@@' || true
}

report 'gnc includes Eigen, the standard library, idl/angles.h and gnc only' \
  < <(includes gnc | grep -vE ':("gnc/|"idl/angles\.h"|<Eigen/|<[a-z_]+>)' || true)

banned='\bnew\b|\b(malloc|calloc|realloc|free)\b|std::(vector|string|deque|list|map|unordered_map|function|mutex|thread|shared_ptr|unique_ptr|cout|cerr|chrono)\b|\bspdlog|printf\b|\bdds_|\bclock_gettime\b'
report 'gnc allocates nothing, locks nothing, logs nothing and knows no clock' \
  < <(code gnc | grep -E "$banned" || true)

# Their last bit depends on processor and libc, of the others it does not: docs/recording.md.
inexact='std::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erf|erfc|tgamma|lgamma)\b|\bAngleAxis'
report 'code of the cycle takes such functions from gnc/math.h' \
  < <(code gnc drivers daemon/cycle daemon/kit daemon/vehicles | grep -E "$inexact" || true)

report 'drivers include libc, the kernel, the standard library, idl/angles.h and drivers only' \
  < <(includes drivers | grep -E ':"' | grep -vE ':"(drivers/|idl/angles\.h")' || true)
report 'drivers include libc, the kernel, the standard library and drivers only' \
  < <(includes drivers | grep -E ':<(Eigen|dds|spdlog|fmt|boost|toml|nlohmann|dart)' || true)

vehicle_headers=$(find idl -name '*.idl' -printf '%f\n' 2>/dev/null | sed 's@\.idl$@@' | paste -sd'|')
report 'DDS types stay in daemon/publish, idl, tools and tests; a vehicle includes <NAME_fields.h>' \
  < <(includes gnc drivers daemon | grep -v '^daemon/publish/' |
        grep -E ":[<\"](dds/|ddsc/|idl/topics\.h|(${vehicle_headers:-lss})(_fields)?\.h)" |
        grep -vE '^daemon/vehicles/[^:]*:[0-9]+:<[a-z]+_fields\.h>' || true)

report 'a program ends with 2 for wrong usage (lssd with 78), not with the codes of CLI11_PARSE' \
  < <(code daemon tools tests | grep -E '\bCLI11_PARSE\b' || true)

# Words that docs/glossary.md avoids. Not identifiers, and "octet" only in names: IDL has it.
report 'a comment without is told, tells, anew, mend: docs/glossary.md' \
  < <(sources idl gnc drivers daemon tools tests examples |
        xargs -r grep -HnE '//.*\b((is|are|be|was|were) told|tells|anew|mend(s|ed)?)\b' || true)
report 'a name of a test without Told, Tell, Anew, Mend, Octet, Whatever: docs/glossary.md' \
  < <(sources tests examples |
        xargs -r grep -HnE '^(TYPED_TEST|TEST|RC_GTEST)[A-Z_]*\(.*(Told|Tells?|Anew|Mend(s|ed)?|Octets?|Whatever)([A-Z0-9_,)]|$)' || true)
report 'a name of a test without told, tell, anew, mend, octet, whatever: docs/glossary.md' \
  < <(find tests -name 'test_*.py' 2>/dev/null | sort |
        xargs -r grep -HnE 'def test_(\w*_)?(told|tells?|anew|mend(s|ed)?|octets?|whatever)(_|\()' || true)

e2e=tests/e2e/CMakeLists.txt
[[ -r $e2e ]] || e2e=/dev/null
report 'a test of tests/e2e is in its CMakeLists.txt, else it never runs' \
  < <(awk 'list { gsub(/[()]/, " "); for (i = 1; i <= NF; ++i) known[$i]; next }
             /^ +def test_/ {
               name = $2; sub(/^test_/, "", name); sub(/\(.*/, "", name)
               if (!(name in known)) print FILENAME ":" FNR ":" $2
             }' list=1 "$e2e" list= tests/e2e/test_*.py 2> /dev/null || true)

report 'nothing but tools and tests includes tools' \
  < <(includes idl gnc drivers daemon | grep -E ':["<]tools/' || true)
report 'nothing includes tests' \
  < <(includes idl gnc drivers daemon tools | grep -E ':["<]tests/' || true)

# in_order FOLDER ROOM... : a room includes itself and the rooms named before it, so rooms form no circles.
in_order() {
  local folder=$1 room later
  shift
  while [ $# -gt 0 ]; do
    room=$1
    shift
    later=$(printf '%s|' "$@")
    [ -z "${later%|}" ] || report "$folder/$room includes no room that comes after it ($*)" \
      < <(includes "$folder/$room" | grep -E ":\"$folder/(${later%|})/" || true)
  done
}
in_order daemon cycle config runtime record parameters replay publish app kit vehicles
in_order tools/lss-cli show recording session obc report doctor verbs
in_order tools/lss-sim frame canopen

# A vehicle is the name of a folder in gnc; its files are NAME/* and NAME.* and NAME_* in every folder.
vehicles=$(find gnc -mindepth 1 -maxdepth 1 -type d -printf '%f\n' 2>/dev/null || true)
for own in $vehicles; do
  for other in $vehicles; do
    [ "$own" = "$other" ] && continue
    report "vehicle $own includes vehicle $other" \
      < <(includes idl gnc drivers daemon tools tests | grep -E "^[^:]*/$own(/|\.|_)" |
            grep -E ":[<\"]([^>\"]*/)?$other(/|\.|_)" || true)
  done
done

if [ "$faults" -gt 0 ]; then
  echo "$faults violations of the source rules"
  exit 1
fi
echo "source rules hold"
