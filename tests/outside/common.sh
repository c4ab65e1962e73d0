# Sourced by the scripts of this folder that are called with CMAKE BUILD FOLDER.
# shellcheck shell=bash
set -euo pipefail
cmake=$1 build=$2 folder=$3

# install_fresh COMPONENT: it alone, in FOLDER/usr.
install_fresh() {
  rm -rf "$folder"
  mkdir -p "$folder"
  "$cmake" --install "$build" --component "$1" --prefix "$folder/usr" > /dev/null
}
