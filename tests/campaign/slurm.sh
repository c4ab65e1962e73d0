#!/usr/bin/env bash
# slurm.sh LSS-CAMPAIGN [RUNS]: a campaign as an array job of Slurm (job.slurm) on a cluster of two nodes, both this
# machine, merged, is the campaign of one process. Needs root, for a network of its own; 77: cannot be tried here.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
campaign=$(readlink -f "$1") runs=${2:-4}
PATH=$PATH:/usr/sbin:/sbin
for program in slurmctld slurmd sbatch sinfo munged; do
  command -v "$program" > /dev/null || { echo "skipped: no $program (Debian: slurmctld, slurmd, slurm-client, munge)" && exit 77; }
done
[ "$(id -u)" -eq 0 ] || { echo "skipped: needs root, for a network of its own" && exit 77; }
if [ -z "${LSS_SLURM_INSIDE:-}" ]; then
  unshare --net --mount --pid --fork true || { echo "skipped: no network of its own here" && exit 77; }
  LSS_SLURM_INSIDE=1 exec unshare --net --mount --pid --fork --kill-child --mount-proc "$here/slurm.sh" "$campaign" "$runs"
fi

# The cluster. It ends with this process, whose process namespace it is in.
ip link set lo up
ip address add 192.0.2.1/32 dev lo  # with 127.0.0.1 alone Slurm resolves no address
folder=$(mktemp -d)
trap 'jobs -p | xargs -r kill; wait; rm -rf "$folder"' EXIT
chmod 755 "$folder"
mkdir "$folder"/{ctld,n1,n2}
install -d -o munge -g munge -m 711 "$folder/munge"
install -o munge -g munge -m 600 <(head -c 1024 /dev/urandom) "$folder/munge/key"
setpriv --reuid munge --regid munge --clear-groups munged --foreground --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
  --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" > "$folder/munge.log" 2>&1 &
cat > "$folder/slurm.conf" <<CONF
ClusterName=two
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CryptoType=crypto/munge
StateSaveLocation=$folder/ctld
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/ctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/ctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SchedulerParameters=batch_sched_delay=0
ReturnToService=2
NodeName=n1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=17001 CPUs=1
NodeName=n2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=17002 CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
within() {  # SECONDS CONDITION...
  local end=$((SECONDS + $1))
  shift
  until "$@" > /dev/null 2>&1; do
    [ "$SECONDS" -lt "$end" ] || { echo "not within the time limit: $*" && tail -n 20 "$folder"/*.log && exit 1; }
    sleep 0.2
  done
}
within 20 test -S "$folder/munge/socket"
slurmctld -D > /dev/null 2>&1 &
slurmd -D -N n1 > /dev/null 2>&1 &
slurmd -D -N n2 > /dev/null 2>&1 &
both_idle() { [ "$(sinfo --noheader --Node --states=idle --format=%N | sort -u | wc -l)" -eq 2 ]; }
within 60 both_idle

cd "$folder"
sbatch --wait --array=1-4 --output="$folder/job-%a.txt" "$here/job.slurm" "$campaign" "$runs" "$folder"
cat "$folder"/job-*.txt
[ "$(awk '$1 == "node" { print $2 }' "$folder"/job-*.txt | sort -u | wc -l)" -eq 2 ] || { echo "the shards ran on one node only" && exit 1; }
"$campaign" merge "$folder"/shard-*.json --out "$folder/merged.json" > /dev/null
"$campaign" --runs "$runs" --out "$folder/one.json" > /dev/null
cmp <(grep -v '"cpu_s"' "$folder/merged.json") <(grep -v '"cpu_s"' "$folder/one.json")
echo "$runs scenarios of each vehicle: four shards on two nodes give, merged, the results of one process"
