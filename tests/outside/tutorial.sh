#!/usr/bin/env bash
# tutorial.sh CMAKE BUILD FOLDER: the commands of docs/tutorial-vehicle.md, word by word but for the installation of packages,
# the folder of what they install, the port and the domain. The component dev of BUILD stands for liblssd-dev.
# shellcheck source=tests/outside/common.sh
. "$(dirname "$0")/common.sh"
page=$(cd "$(dirname "$0")/../.." && pwd)/docs/tutorial-vehicle.md
install_fresh dev
programs=$(dirname "$cmake"):$build/bin
export CMAKE_PREFIX_PATH=$folder/usr PATH=$programs:$PATH NO_COLOR=1
command -v ccache > /dev/null && export CMAKE_CXX_COMPILER_LAUNCHER=ccache

domain=$LSS_DOMAIN port=$((20000 + LSS_DOMAIN))
{
  echo 'set -em'
  echo "trap 'kill \$(jobs -p) 2> /dev/null || true' EXIT"
  awk '/^```sh$/ { code = 1; next } /^```$/ { code = 0 } code' "$page" | grep -v apt-get |
    sed "s|/usr/share/lssd|$folder/usr/share/lssd|; s/20000/$port/; s/LSS_DOMAIN=77/LSS_DOMAIN=$domain/
         s/^cd scout\$/&; sed -i s,20000,$port, *.toml/"
} > "$folder/steps.sh"

cd "$folder"
if ! bash steps.sh > log 2>&1 < /dev/null; then
  cat steps.sh log
  exit 1
fi
grep -q 'tests passed' log
grep -q 'drive' log
grep -q '^equal' log || { cat log && echo 'no recording was replayed' && exit 1; }
echo 'the tutorial gives a scout that drives, and whose recording executes again'
