# Shared by tools/demo and tools/test: messages, missing packages, commands with bounded output.
# Sourced by bash with `set -euo pipefail`, from the top of the tree. Sets the EXIT trap; a script that starts
# processes of its own defines at_exit.
# shellcheck shell=bash

export LC_NUMERIC=C
logs=build/logs
child=''  # the process of `quietly`; the terminal's Ctrl-C does not reach it directly
at_exit() { :; }
trap 'if [ -n "$child" ]; then kill "$child" 2> /dev/null || true; fi; at_exit' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

if [ -t 1 ] && [ -z "${NO_COLOR:-}" ] && [ "${TERM:-dumb}" != dumb ]; then
  bold=$'\e[1m' red=$'\e[31m' green=$'\e[32m' plain=$'\e[0m'
else
  bold='' red='' green='' plain=''
fi

say() { printf '%s==>%s %s\n' "$bold" "$plain" "$*"; }
good() { printf '%s%s%s\n' "$green" "$*" "$plain"; }
die() {
  printf '%s%s%s\n' "$red" "$*" "$plain" >&2
  exit 1
}

# An unused DDS domain in LSS_DOMAIN, for this script and its programs until they end; tests/support/own_domain.py has
# the same locks.
take_domain() {
  for LSS_DOMAIN in {60..99}; do
    { exec {domain_lock}> "/tmp/lss-e2e-domain-$LSS_DOMAIN.lock"; } 2> /dev/null || continue
    flock --nonblock "$domain_lock" && export LSS_DOMAIN && return
    exec {domain_lock}>&-
  done
  die "No DDS domain from 60 to 99 is free. LSS_DOMAIN=N takes another."
}

jobs_to_run() { echo "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"; }

is_debian() {
  command -v dpkg-query > /dev/null && grep -qx 'ID="\?debian"\?' "${LSS_OS_RELEASE:-/etc/os-release}" 2> /dev/null
}

# Whether a program, or a header (it has a dot or a slash), can be used.
is_there() {  # PROBE
  case $1 in
    -) ;;
    *[./]*) echo "#include <$1>" | "${CXX:-c++}" -std=c++20 -fsyntax-only -I/usr/include/eigen3 -x c++ - > /dev/null 2>&1 ;;
    *) PATH=$PATH:/usr/sbin:/sbin command -v "$1" > /dev/null ;;
  esac
}

# Packages of the given groups of tools/packages.txt that are not installed, one per line; on another system than Debian,
# those whose probe fails.
missing_packages() {
  local package probe
  while read -r package probe; do
    if is_debian; then
      dpkg-query -W -f='${db:Status-Status}\n' "$package" 2> /dev/null | grep -qx installed || echo "$package"
    else
      is_there "$probe" || echo "$package"
    fi
  done < <(awk -v groups=" $* " '/^[a-z]/ && index(groups, " " $1 " ") { print $2, $3 }' tools/packages.txt)
}

# install_missing GROUP... : does nothing when all are installed; otherwise runs apt as root or through sudo, or prints
# the list and exits.
install_missing() {
  local missing sudo=()
  mapfile -t missing < <(missing_packages "$@")
  [ "${#missing[@]}" -eq 0 ] && return
  if ! is_debian; then
    printf 'This is not Debian, and these are missing (Debian package: purpose):\n' >&2
    awk -v missing=" ${missing[*]} " '/^[a-z]/ && index(missing, " " $2 " ") {
      purpose = $0; sub(/^[^ ]+ [^ ]+ [^ ]+ /, "", purpose); printf "  %s: %s\n", $2, purpose }' tools/packages.txt >&2
    die "Install them, then try again."
  fi
  say "Installing ${#missing[@]} missing Debian packages: ${missing[*]}"
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo > /dev/null || ! { sudo -n true 2> /dev/null || [ -t 0 ]; }; then
      die "Installing needs root. Run as root, then try again:
  apt-get install --no-install-recommends ${missing[*]}"
    fi
    sudo -v  # the password, if any, before the output goes to a log
    sudo=(sudo)
  fi
  local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
  # A new system has no package lists; old lists name files that no longer exist.
  if ! apt-cache show "${missing[@]}" > /dev/null 2>&1; then
    quietly "$logs/apt.log" "apt-get update" "${apt[@]}" update || fail_with "$logs/apt.log"
  fi
  local install=("${apt[@]}" install --no-install-recommends "${missing[@]}")
  quietly "$logs/apt.log" "apt-get install" "${install[@]}" && return
  quietly "$logs/apt.log" "apt-get update" "${apt[@]}" update || fail_with "$logs/apt.log"
  quietly "$logs/apt.log" "apt-get install, again" "${install[@]}" || fail_with "$logs/apt.log"
}

# The page needs npm and esbuild. An npm from any source is accepted, because a foreign one conflicts with Debian's package.
# Prints a message and fails when they cannot be installed.
have_npm() {
  { command -v npm > /dev/null || (install_missing web); } && (install_missing page) && return
  say "npm or esbuild cannot be installed: the page of lss-ground is not built, recordings are not read by others"
  return 1
}

fail_with() {  # LOG
  printf '\n--- end of %s\n' "$1" >&2
  tail -n "${2:-40}" "$1" >&2 || true
  die "Failed; the whole output is in $1"
}

quietly_s=0  # that it took in all
# quietly LOG TITLE COMMAND... : output goes to LOG. Progress: on a terminal the last line, otherwise one line a minute.
quietly() {
  local log=$1 title=$2 start=$SECONDS status=0 ticks=0
  shift 2
  mkdir -p "$(dirname "$log")"
  "$@" > "$log" 2>&1 < /dev/null &
  child=$!
  while kill -0 "$child" 2> /dev/null; do
    if [ -n "$bold" ]; then
      printf '\r\e[K    %s: %s' "$title" "$(tail -n 1 "$log" | tr -d '\r' | cut -c -60)"
    elif [ $((++ticks % 300)) -eq 0 ]; then
      printf '    %s: %d s, %s\n' "$title" $((SECONDS - start)) "$(tail -n 1 "$log" | cut -c -60)"
    fi
    sleep 0.2
  done
  wait "$child" || status=$?
  child=''
  quietly_s=$((quietly_s + SECONDS - start))
  [ -n "$bold" ] && printf '\r\e[K'
  if [ "$status" -eq 0 ]; then
    printf '    %s: done in %d s\n' "$title" $((SECONDS - start))
  else
    printf '    %s: %sfailed%s after %d s\n' "$title" "$red" "$plain" $((SECONDS - start))
  fi
  return "$status"
}

# A second clone finds the objects of the first in the cache.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1

# configure PRESET|alone-VEHICLE : the first time; later the build does so when needed. alone-VEHICLE: as release, without
# the other vehicles.
configure() {
  local folder=build/$1 how=(--preset "$1")
  [[ $1 != alone-* ]] || how=(--preset release -B "$folder" -DLSS_VEHICLES="${1#alone-}")
  [ -f "$folder/build.ninja" ] ||
    quietly "$folder/configure.log" "configure ${folder#build/}" cmake "${how[@]}" || fail_with "$folder/configure.log"
}

# build PRESET|alone-VEHICLE [TARGET...]
build() {
  local folder=build/$1 log=build/$1/build.log
  configure "$1"
  shift
  quietly "$log" "build ${folder#build/}" ninja -C "$folder" -j "$(jobs_to_run)" "$@" && return
  grep -E 'error:|FAILED' "$log" | head -n 20 >&2 || true
  fail_with "$log"
}
