#!/bin/sh
# configure.sh ROOT HERE: the settings that an installer and its owner would make on a bare OBC.
set -e
root=$1 here=$2
cd "$root"
mkdir -p etc/systemd/system etc/systemd/network etc/systemd/journald.conf.d etc/modules-load.d etc/sudoers.d \
  usr/local/sbin mnt/host var/lib/systemd
echo obc > etc/hostname
echo '127.0.0.1 localhost obc' > etc/hosts
: > etc/resolv.conf
echo 0123456789abcdef0123456789abcdef > etc/machine-id
cat > etc/fstab << 'X'
/dev/vda / ext4 rw,noatime 0 0
host /mnt/host 9p trans=virtio,version=9p2000.L,msize=262144,nofail 0 0
X

# The CAN bus of the box: virtual, under the name of a real one.
printf 'vcan\ncan-raw\n' > etc/modules-load.d/can.conf
printf '[NetDev]\nName=can0\nKind=vcan\n' > etc/systemd/network/10-can0.netdev
printf '[Match]\nName=can0\n[Network]\nLinkLocalAddressing=no\n' > etc/systemd/network/99-can0.network

# An ordinary user who may use sudo.
for file in passwd shadow group gshadow; do [ -e etc/$file ] || : > etc/$file; done
echo 'operator:x:1000:1000::/home/operator:/bin/bash' >> etc/passwd
echo 'operator:*:19000:0:99999:7:::' >> etc/shadow
echo 'operator:x:1000:' >> etc/group
echo 'operator ALL=(ALL) NOPASSWD: ALL' > etc/sudoers.d/operator
chmod 440 etc/sudoers.d/operator
mkdir -p home/operator
chown 1000:1000 home/operator
for kind in auth account session session-noninteractive password; do
  echo "${kind%-*} required pam_permit.so" > etc/pam.d/common-$kind
done

# The journal in memory, all of it; and nothing that an OBC does not need, each costs time without KVM.
printf '[Journal]\nStorage=volatile\nRateLimitIntervalSec=0\nForwardToConsole=no\n' > etc/systemd/journald.conf.d/obc.conf
install -m 755 "$here/obc-agent" usr/local/sbin/obc-agent
install -m 644 "$here/obc-agent.service" etc/systemd/system/obc-agent.service
port='dev-virtio\x2dports-obc.device'
mkdir -p "etc/systemd/system/$port.wants"
ln -s ../obc-agent.service "etc/systemd/system/$port.wants/obc-agent.service"
mkdir -p etc/systemd/system/multi-user.target.wants
ln -s /lib/systemd/system/systemd-networkd.service etc/systemd/system/multi-user.target.wants/
ln -sf /lib/systemd/system/multi-user.target etc/systemd/system/default.target
for unit in apt-daily.timer apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service \
  fstrim.timer systemd-timesyncd.service systemd-resolved.service getty@tty1.service serial-getty@ttyS0.service serial-getty@ttyAMA0.service systemd-logind.service \
  systemd-sysusers.service systemd-update-utmp.service systemd-update-utmp-runlevel.service systemd-hwdb-update.service \
  systemd-pstore.service ldconfig.service dev-hugepages.mount dev-mqueue.mount sys-kernel-debug.mount \
  sys-kernel-tracing.mount systemd-networkd-wait-online.service; do
  ln -sf /dev/null "etc/systemd/system/$unit"
done
