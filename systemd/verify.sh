#!/usr/bin/env bash
# verify.sh BUILD_DIR BINDIR: installs the units into a temporary root and lets systemd verify them there, and sysusers
# make their users. Empty files stand in for the programs that they start.
set -euo pipefail
build=$1 bindir=$2
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

DESTDIR=$root cmake --install "$build" --component systemd > /dev/null
install -D -m 644 -t "$root/usr/lib/systemd/system" "$build/systemd/lss-ground.service" \
  "$build/systemd/lss-ros@.service"
for program in "$bindir/lssd" "$bindir/lss-cli" "$bindir/lss-ground" "$bindir/lss-ros" /usr/bin/iox-roudi /bin/sh /bin/rm; do
  install -D -m 755 /dev/null "$root$program"
done
# The targets, slices and sockets that units refer to by default.
find /usr/lib/systemd/system -maxdepth 1 -regex '.*\.\(target\|slice\|mount\|socket\)' \
  -exec cp -P -t "$root/usr/lib/systemd/system" {} +

units=("$root"/usr/lib/systemd/system/iox-roudi.service "$root"/usr/lib/systemd/system/lssd@.service)
[ -f "${units[0]}" ] && [ -f "${units[1]}" ]
complaints=$(systemd-analyze verify --root="$root" --man=no iox-roudi.service lssd@zebro.service lssd-obc@zebro.service lss-ground.service lss-ros@zebro-1.service 2>&1) ||
  { echo "$complaints"; exit 1; }
# A misspelled key is only a warning, not a failure.
if [ -n "$complaints" ]; then
  echo "$complaints"
  exit 1
fi

# By default systemd gives up after five starts in 10 s.
for unit in iox-roudi lssd@ lssd-obc@ lss-ground lss-ros@; do
  grep -q '^StartLimitIntervalSec=0$' "$root/usr/lib/systemd/system/$unit.service" ||
    { echo "$unit.service is not started again for as long as it takes"; exit 1; }
done

mkdir -p "$root/etc"
systemd-sysusers --root="$root" "$root/usr/lib/sysusers.d/lss.conf" > /dev/null
for user in lss iox; do
  grep -q "^$user:" "$root/etc/passwd" || { echo "sysusers makes no user $user"; exit 1; }
done
echo "units and users are clean"
