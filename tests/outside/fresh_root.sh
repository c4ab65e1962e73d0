#!/usr/bin/env bash
# fresh_root.sh CPACK CONFIG FOLDER [SUITE]: docs/tutorial-vehicle.md word by word in a new Debian root: the packages of this
# build, what apt installs with them, and nothing else. With a network of its own after the installation, so that domain and
# port are those of the tutorial. Skipped (77) without mmdebstrap, root or Debian's archive.
set -euo pipefail
cpack=$1 config=$2 folder=$3
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v mmdebstrap > /dev/null || { echo "Skipped: mmdebstrap is not installed"; exit 77; }
[ "$(id -u)" -eq 0 ] || { echo "Skipped: needs root for a chroot"; exit 77; }
suite=${4:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
# shellcheck disable=SC2016
archive=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE)' | awk '$2 !~ /-/ { print $1; exit }')
rm -rf "$folder"
mkdir -p "$folder/packages"
trap 'rm -rf "$folder/debian"' EXIT

"$cpack" --config "$config" -B "$folder/packages" -D "CPACK_COMPONENTS_ALL=lssd;systemd;dev" > "$folder/cpack.log" ||
  { cat "$folder/cpack.log" && exit 1; }
# What a user begins with: sudo, no compiler.
mmdebstrap --quiet --variant=apt --include=sudo "$suite" "$folder/debian" "deb $archive $suite main" \
  > "$folder/debian.log" 2>&1 || { tail -n 3 "$folder/debian.log" && echo "Skipped: no root of $suite can be made" && exit 77; }
cp -L /etc/resolv.conf /etc/hosts "$folder/debian/etc/"  # apt in it reaches what apt here reaches
mkdir -p "$folder/debian/home/reader"
cp "$folder"/packages/*.deb "$folder/debian/home/reader"

# The blocks of commands: those with apt, then all others.
steps() {
  awk -v apt="$1" '/^```sh$/ { code = 1; block = ""; next }
    /^```$/ { if (code && (block ~ /apt-get/) == apt) printf "%s", block; code = 0 }
    code { block = block $0 "\n" }' "$root/docs/tutorial-vehicle.md"
}
{
  echo 'set -e; export DEBIAN_FRONTEND=noninteractive; cd /home/reader; apt-get update'
  steps 1
} > "$folder/debian/home/reader/first.sh"
{
  echo 'set -em; cd /home/reader/scout; ip link set lo up 2> /dev/null || python3 - << END'
  # The root has no ip: SIOCSIFFLAGS with IFF_UP.
  echo 'import fcntl, socket, struct'
  echo 'fcntl.ioctl(socket.socket(socket.AF_INET, socket.SOCK_DGRAM), 0x8914, struct.pack("16sh", b"lo", 1))'
  echo 'END'
  echo "trap 'kill \$(jobs -p) 2> /dev/null || true' EXIT"
  steps 0
} > "$folder/debian/home/reader/then.sh"

inside() {  # UNSHARE-OPTION... SCRIPT
  # shellcheck disable=SC2016
  unshare --mount --pid --fork "${@:1:$#-1}" bash -c 'mount --make-rprivate / && mount -t proc proc "$1/proc" &&
    mount --rbind /dev "$1/dev" && exec chroot "$1" bash "/home/reader/$2"' - "$folder/debian" "${!#}" < /dev/null
}
begin=$SECONDS
inside first.sh > "$folder/first.log" 2>&1 || { tail -n 40 "$folder/first.log" && exit 1; }
installed=$((SECONDS - begin))
inside --net then.sh > "$folder/then.log" 2>&1 || { tail -n 60 "$folder/then.log" && exit 1; }
for word in 'tests passed' drive '^equal'; do
  grep -q "$word" "$folder/then.log" || { tail -n 60 "$folder/then.log" && echo "nothing says: $word" && exit 1; }
done
echo "the tutorial gives a scout that drives in a new root of $suite: $installed s for the packages, $((SECONDS - begin - installed)) s for the rest"
