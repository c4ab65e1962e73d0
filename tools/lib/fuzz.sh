#!/usr/bin/env bash
# fuzz.sh SECONDS [NAME...]: runs the fuzzers of build/fuzz for so long each (docs/fuzzing.md), from the corpora in
# tests/fuzz/corpus, from files of this tree (config/, idl/) and from what earlier runs found (build/fuzz/corpus). A line for
# each: executions, edges and features of the code that were reached. Fails on a crash, a hang, growth or a violated
# condition, and says how to repeat it.
set -euo pipefail
cd "$(dirname "$0")/../.."

usage='Usage: tools/lib/fuzz.sh SECONDS [NAME...]'
if ! [[ ${1:-} =~ ^[1-9][0-9]*$ ]]; then
  echo "$usage" >&2
  exit 2
fi
seconds=$1
shift
fuzzers=build/fuzz/fuzzers found=build/fuzz/found seeds=build/fuzz/seeds
if [ $# -eq 0 ]; then
  mapfile -t names < <(find tests/fuzz -maxdepth 1 -name '*.cpp' ! -name make_corpus.cpp -printf '%f\n' | sort | cut -d. -f1)
  set -- "${names[@]}"
fi
for name in "$@"; do
  [ -x "$fuzzers/fuzz-$name" ] || { echo "fuzz.sh: no $fuzzers/fuzz-$name: cmake --preset fuzz && cmake --build --preset fuzz" >&2 && exit 2; }
done
mkdir -p "$found" "$seeds"/{config,description,idl}
for file in config/*.toml; do  # the fewer bytes, the more executions
  sed -E '/^(#|$)/d; s/  #.*//' "$file" > "$seeds/$file"
done
cp config/devices/*.dcf "$seeds/description/"
{ echo lss::ZebroTelemetry && cat idl/zebro/zebro.idl; } > "$seeds/idl/zebro"
{ echo lss::Status && head -c 4000 idl/lss.idl; } > "$seeds/idl/cut-off"
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1:allow_addr2line=1 ASAN_OPTIONS=allow_addr2line=1

run() {  # NAME
  local name=$1 log=build/fuzz/$1.log status=0 end corpora=("build/fuzz/corpus/$1") folder
  mkdir -p "build/fuzz/corpus/$name"
  for folder in tests/fuzz/corpus "$seeds"; do
    if [ -d "$folder/$name" ]; then corpora+=("$folder/$name"); fi
  done
  "$fuzzers/fuzz-$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -print_final_stats=1 \
    -artifact_prefix="$found/$name-" "${corpora[@]}" > "$log" 2>&1 || status=$?
  end=$(grep -E '^#[0-9]+[[:space:]]+DONE' "$log" | tail -n 1 || true)
  if [ "$status" -eq 0 ] && [[ $end =~ ^#([0-9]+).*cov:\ ([0-9]+)\ ft:\ ([0-9]+) ]]; then
    printf '    %-12s %9d executions, %5d edges, %6d features\n' "$name" "${BASH_REMATCH[@]:1}"
    return
  fi
  printf '    %-12s failed (exit code %d):\n' "$name" "$status"
  { grep -E 'does not hold|runtime error|ERROR: |SUMMARY: ' "$log" || tail -n 5 "$log"; } | head -n 4 | sed 's/^/      /'
  sed -n "s|.*written to \($found/.*\)|      repeat: $fuzzers/fuzz-$name \1|p" "$log"
  return 1
}
export -f run
export fuzzers found seeds seconds

# One for each processor; xargs fails when one does.
printf '%s\n' "$@" | xargs -P "$(nproc)" -I{} bash -c 'run {}'
