#!/usr/bin/env bash
# image.sh FOLDER PACKAGES : the OBC in a box, for PACKAGES/*.deb that will be installed in it: FOLDER/image becomes a
# link to a folder with vmlinuz, initrd.gz, root.ext4 and arch, the name of its processor: amd64, or LSS_OBC_ARCH=arm64.
# Debian as on this machine (or LSS_OBC_SUITE=bookworm, trixie) with systemd and the PREEMPT_RT kernel; what those packages
# depend on is there, they themselves are not. cyclictest is there for lss-bench --machine.
# Needs no root: packages are unpacked under fakeroot, and what their scripts would do is done by hand. Kept in
# ${LSS_OBC_CACHE:-${XDG_CACHE_HOME:-~/.cache}/lss-obc}; built again when its inputs changed. Status 77: cannot be built
# here, and it says why.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1
ours=("$2"/*.deb)
arch=${LSS_OBC_ARCH:-amd64}
here_is=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
suite=${LSS_OBC_SUITE:-$here_is}
cache=${LSS_OBC_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/lss-obc}

cannot() {
  rm -f "$out/image"
  echo "the OBC in a box is skipped: $*"
  exit 77
}
need() {  # GROUP PROGRAM...
  local program
  for program in "${@:2}"; do
    PATH=$PATH:/sbin:/usr/sbin command -v "$program" > /dev/null ||
      cannot "no $program; install the packages of group $1 in tools/packages.txt"
  done
}
need obc fakeroot busybox cpio mke2fs dpkg-deb apt-get
# emulator: how a program of the image is executed here.
case $arch in
  amd64)
    need obc qemu-system-x86_64
    triplet=x86_64-linux-gnu loader=ld-linux-x86-64.so.2 emulator=()
    ;;
  arm64)
    need arm64 qemu-system-aarch64 qemu-aarch64-static
    triplet=aarch64-linux-gnu loader=ld-linux-aarch64.so.1 emulator=(qemu-aarch64-static)
    ;;
  *) echo "image.sh: LSS_OBC_ARCH is amd64 or arm64, not $arch" >&2 && exit 2 ;;
esac
[ -z "${LSS_OBC_SUITE:-}" ] || case $suite in
  bookworm | trixie) ;;
  *) echo "image.sh: LSS_OBC_SUITE is bookworm or trixie, not $suite" >&2 && exit 2 ;;
esac
[ "$(dpkg --print-architecture)" = amd64 ] || cannot "it is built on amd64, and this machine is not"
[ -e "${ours[0]}" ] || cannot "no packages in $2; tools/package --arch $arch --suite $suite makes them"

packages=(base-files base-passwd bash dash coreutils util-linux mount login passwd grep sed mawk findutils hostname
  diffutils libc-bin procps dpkg apt sudo kmod udev systemd systemd-sysv dbus iproute2 can-utils tar gzip usr-is-merged
  busybox-static init-system-helpers libnuma1 "linux-image-rt-$arch")
# Of the first alternative each.
mapfile -t depends < <(for deb in "${ours[@]}"; do dpkg-deb -f "$deb" Depends; done |
  tr ',' '\n' | sed 's/|.*//; s/(.*//; s/ //g' | grep -vxE 'lssd.*|lss-ground|lss-ros' | sort -u)

key=$( (printf '%s\n' "$arch" "$suite" "${packages[@]}" "${depends[@]}"; cat "$here/image.sh" "$here"/guest/*) | sha256sum | cut -c 1-16)
if [ -z "${FAKEROOTKEY:-}" ]; then
  mkdir -p "$cache"/archives/partial "$cache/lists/$suite-$arch/partial" "$out"
  exec 9> "$cache/lock"
  flock 9
  ln -sfn "$cache/$key" "$out/image"
  if [ -e "$cache/$key/root.ext4" ]; then
    echo "cached: $cache/$key"
    exit 0
  fi
  # Everything below runs as a simulated root. fakeroot's server must not inherit the lock.
  status=0
  fakeroot "$here/image.sh" "$@" 9>&- || status=$?
  exit "$status"
fi

work=$cache/work
rm -rf "$work"
mkdir -p "$work/root" "$work/image" "$work/none/partial" "$work/ram/"{bin,modules,dev,new}
trap 'rm -rf "$work"' EXIT
: > "$work/status"
step() { printf '%4d s %s\n' "$SECONDS" "$1"; }

# The sources of this machine, or of another Debian its archive; nothing installed: apt lists and downloads all needed
# packages.
apt=(-q -y -o Dir::State::status="$work/status" -o Dir::Cache="$cache" -o Dir::Cache::archives="$cache/archives"
  -o Dir::Log="$work" -o APT::Sandbox::User=root -o APT::Install-Recommends=false -o Debug::NoLocking=1
  -o APT::Architecture="$arch" -o APT::Architectures="$arch")
if [ "$suite" != "$here_is" ]; then
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keys" ] || cannot "no $keys; install debian-archive-keyring"
  echo "deb [signed-by=$keys] ${LSS_DEBIAN_ARCHIVE:-http://deb.debian.org/debian} $suite main" > "$work/sources.list"
  apt+=(-o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$cache/lists/$suite-$arch")
fi
wanted=("${packages[@]}" "${depends[@]}")
fetch() {
  # apt lists the files not yet downloaded: all of them, with an empty archive.
  apt-get "${apt[@]}" "$@" -o Dir::Cache::archives="$work/none" --print-uris install "${wanted[@]}" \
    > "$work/uris" 2> "$work/apt.log" &&
    apt-get "${apt[@]}" "$@" --download-only install "${wanted[@]}" > "$work/apt.log" 2>&1 &&
    (cd "$work/none" && apt-get "${apt[@]}" "$@" download rt-tests >> "$work/apt.log" 2>&1)
}
if ! fetch; then  # no lists, or old ones that name files that are gone
  own=(-o Dir::State::lists="$cache/lists/$suite-$arch")
  if ! { apt-get "${apt[@]}" "${own[@]}" update > "$work/apt.log" 2>&1 && fetch "${own[@]}"; }; then
    tail -n 5 "$work/apt.log"
    cannot "the packages of the image ($suite, $arch) cannot be downloaded"
  fi
fi
mapfile -t files < <(sed -n "s/^'[^']*' \([^ ]*\.deb\) .*/\1/p" "$work/uris")
step "${#files[@]} packages"
root=$work/root
for folder in bin sbin lib lib64; do
  mkdir -p "$root/usr/$folder"
  ln -s "usr/$folder" "$root/$folder"
done
mkdir -p "$work/kernel/usr/lib"
ln -s usr/lib "$work/kernel/lib"
info=$root/var/lib/dpkg/info
mkdir -p "$info" "$root"/var/lib/dpkg/{updates,triggers,alternatives,parts}
printf '1\n' > "$info/format"
for file in "${files[@]}"; do
  deb=$cache/archives/$file
  case $file in
    linux-image-6*) dpkg-deb --fsys-tarfile "$deb" | tar -x --keep-directory-symlink -C "$work/kernel" ;;
    *) dpkg-deb --fsys-tarfile "$deb" | tar -x --keep-directory-symlink -C "$root" --exclude='./usr/share/doc/*' \
         --exclude='./usr/share/man/*' --exclude='./usr/share/locale/*' --exclude='./usr/share/info/*' ;;
  esac
  # The database of dpkg, as if it had been installed.
  dpkg-deb -f "$deb" > "$work/control"
  package=$(sed -n 's/^Package: //p' "$work/control")
  grep -qx 'Multi-Arch: same' "$work/control" && package+=:$arch
  { sed 's/^Package: .*/&\nStatus: install ok installed/' "$work/control"; echo; } >> "$root/var/lib/dpkg/status"
  dpkg-deb --fsys-tarfile "$deb" | tar -t | sed 's@^\./@/@; s@/$@@; s@^$@/.@' > "$info/$package.list"
done
: > "$root/var/lib/dpkg/available"
# Without Python, which other programs of rt-tests need.
dpkg-deb --fsys-tarfile "$work"/none/rt-tests_*.deb | tar -xC "$root" ./usr/bin/cyclictest
step unpacked

# guest NAME PROGRAM ... : runs a program of the image under a name, before it can boot.
guest() {
  local name=$1 program=$2 libraries=$root/usr/lib/$triplet
  shift 2
  env -u LD_PRELOAD "${emulator[@]}" "$libraries/$loader" --argv0 "$name" \
    --library-path "$libraries:$libraries/systemd:$root/usr/lib/systemd" "$root/$program" "$@"
}
release=$(ls "$work/kernel/lib/modules")
cp "$work/kernel/boot/vmlinuz-$release" "$work/image/vmlinuz"
guest depmod usr/bin/kmod -b "$work/kernel" "$release"
modules=$work/kernel/lib/modules/$release
mkdir -p "$root/usr/lib/modules/$release"
cp "$modules"/modules.{builtin,order,builtin.modinfo} "$root/usr/lib/modules/$release"
for name in virtio_pci virtio_blk virtio_console virtio-rng ext4 crc32c_generic 9p 9pnet_virtio can can-raw can-dev vcan \
  autofs4 i6300esb; do
  # Its line in modules.dep: the module and its dependencies.
  line=$(grep -E "/${name//[-_]/[-_]}\.ko(\.xz)?:" "$modules/modules.dep") || continue
  for module in ${line/:/}; do
    install -D -m 644 "$modules/$module" "$root/usr/lib/modules/$release/$module"
  done
done
find "$root/usr/lib/modules" -name '*.ko.xz' -exec xz -d {} +  # Debian 13; the initial RAM disk cannot
guest depmod usr/bin/kmod -b "$root" "$release"
step modules

cp "$root/usr/share/base-passwd/passwd.master" "$root/etc/passwd"
cp "$root/usr/share/base-passwd/group.master" "$root/etc/group"
sed 's/:.*/:*:19000:0:99999:7:::/' "$root/etc/passwd" > "$root/etc/shadow"
sed 's/:.*/:*::/' "$root/etc/group" > "$root/etc/gshadow"
chmod 640 "$root/etc/shadow" "$root/etc/gshadow"
echo 'messagebus:x:105:105::/nonexistent:/usr/sbin/nologin' >> "$root/etc/passwd"
echo 'messagebus:x:105:' >> "$root/etc/group"
for group in input:106 kvm:107 render:108 sgx:109; do
  echo "${group%:*}:x:${group#*:}:" >> "$root/etc/group"
done
[ -e "$root/usr/bin/sh" ] || ln -s dash "$root/usr/bin/sh"
[ -e "$root/usr/bin/awk" ] || ln -s mawk "$root/usr/bin/awk"
mkdir -p "$root"/{proc,sys,dev,run,tmp,root,var/tmp}
chmod 1777 "$root/tmp" "$root/var/tmp"
guest systemd-sysusers usr/bin/systemd-sysusers --root="$root" > /dev/null 2>&1
sh "$here/guest/configure.sh" "$root" "$here/guest"
env -u LD_PRELOAD "${emulator[@]}" "$root/usr/sbin/ldconfig" -r "$root"

order="virtio_ring virtio virtio_pci_modern_dev virtio_pci_legacy_dev virtio_pci virtio_blk crc16 mbcache jbd2
crc32c_generic ext4"
cp "$root/usr/bin/busybox" "$work/ram/bin/"
for module in $order; do  # others are built in
  find "$root/usr/lib/modules" -name "$module.ko" -exec cp {} "$work/ram/modules/" \; -printf "$module\n"
done > "$work/ram/MODULES"
install -m 755 "$here/guest/init" "$work/ram/init"
(cd "$work/ram" && find . | cpio -o -H newc -R 0:0 --quiet | gzip -1) > "$work/image/initrd.gz"
truncate -s 1G "$work/image/root.ext4"
PATH=$PATH:/sbin:/usr/sbin mke2fs -q -t ext4 -d "$root" -E lazy_itable_init=1,lazy_journal_init=1 -m 0 -J size=8 -L obc \
  "$work/image/root.ext4"
echo "$arch" > "$work/image/arch"
rm -rf "${cache:?}/$key"
mv "$work/image" "$cache/$key"
# Images unused for a long time.
find "$cache" -maxdepth 1 -type d -regex '.*/[0-9a-f]*' -mtime +30 -exec rm -rf {} +
step "image: $cache/$key, $(du -h "$cache/$key/root.ext4" | cut -f 1)"
