#!/usr/bin/env bash
# example.sh CMAKE BUILD EXAMPLE FOLDER: installs the component dev of BUILD below FOLDER, moves it, copies the project
# EXAMPLE beside it, builds it there, and runs its programs and its tests. Everything is a file below FOLDER.
set -euo pipefail
cmake=$1 build=$2 example=$3 folder=$4
fail() { echo "$*" && exit 1; }
quietly() { "$@" > "$folder/log" 2>&1 || { cat "$folder/log" && fail "failed: $*"; }; }

name=$(sed -nE 's/^ *lss_add_vehicle\(([a-z0-9]+).*/\1/p' "$example/CMakeLists.txt")
[ -n "$name" ] || fail "$example/CMakeLists.txt calls no lss_add_vehicle()"
rm -rf "$folder"
mkdir -p "$folder"
quietly "$cmake" --install "$build" --component dev --prefix "$folder/made"
mv "$folder/made" "$folder/usr"
cp -r "$example" "$folder/$name"
rm -rf "$folder/$name/build"

options=(-S "$folder/$name" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/usr")
ninja --version > /dev/null 2>&1 && options+=(-G Ninja)
command -v ccache > /dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
quietly "$cmake" "${options[@]}"
quietly "$cmake" --build "$folder/build" -j2

bin=$folder/build/bin
for program in lssd lss-sim; do
  [ "$program" = lssd ] || [ -x "$bin/$program-$name" ] || continue
  version=$("$bin/$program-$name" --version)
  [[ $version == "$program "*" ($name)" ]] || fail "$program-$name says: $version"
done
quietly "$(dirname "$cmake")/ctest" --test-dir "$folder/build" --output-on-failure --no-tests=error
grep 'tests passed' "$folder/log"

quietly env DESTDIR="$folder/root" "$cmake" --install "$folder/build"
find "$folder/root" -name "lssd-$name" | grep -q . || fail "lssd-$name is not installed"
