#!/usr/bin/env bash
# client.sh CMAKE BUILD FOLDER: the commands of docs/tutorial-client.md, word by word but for the installation of packages,
# the folder of what they install, and the domain.
# shellcheck source=tests/outside/common.sh
. "$(dirname "$0")/common.sh"
root=$(cd "$(dirname "$0")/../.." && pwd)
install_fresh lssd
export PATH=$build/bin:$PATH NO_COLOR=1
export CYCLONEDDS_URI=''  # as on a machine of a reader
{
  echo 'set -em'
  echo "trap 'kill \$(jobs -p) 2> /dev/null || true; wait' EXIT"
  awk '/^```sh$/ { code = 1; next } /^```$/ { code = 0 } code' "$root/docs/tutorial-client.md" |
    grep -v apt-get |
    sed "s|/usr/share/lss|$folder/usr/share/lss|g; s|/etc/lss/|$root/config/|; s/LSS_DOMAIN=78/LSS_DOMAIN=$LSS_DOMAIN/"
} > "$folder/steps.sh"

cd "$folder"
begun=$SECONDS
if ! bash steps.sh > log 2>&1 < /dev/null; then
  cat steps.sh log client/lssd.log
  exit 1
fi
for wanted in '^zebro-1 Idle 0.000 m' '^frame [0-9]*: 0.000 m' 'start.*completed\|completed' '^zebro-1 Idle 0\.[0-9]*[1-9][0-9]* m'; do
  grep -q "$wanted" log || { cat log && echo "not printed: $wanted" && exit 1; }
done
echo "the programs of the tutorial show and command a walk; it took $((SECONDS - begun)) s"
