#!/usr/bin/env bash
# A sharded sweep as a Slurm job array on a one-node Slurm of its own, against the same sweep in one piece: a task is
# requeued midway, another's program is killed, a third one's time is up, and the bytes must be the same.
#
#     tests/slurm.sh [MAPGEN]        (default target/release/mapgen)
#
# Needs root and Debian's packages slurm-wlm and munge, which it installs if it can; where it cannot, it says so and passes.
set -euo pipefail
cd "$(dirname "$0")/.."
MAPGEN=$(realpath "${1:-target/release/mapgen}")
export MAPGEN

skip() {
    echo "slurm: not tested here: $1"
    exit 0
}
[ "$(id -u)" -eq 0 ] || skip "it takes root to start a scheduler"
if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null || ! command -v munged >/dev/null; then
    command -v apt-get >/dev/null || skip "no apt-get to install slurm-wlm and munge with"
    { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y slurm-wlm munge; } >/dev/null 2>&1 ||
        skip "the packages slurm-wlm and munge cannot be had"
fi
if pgrep -x slurmctld >/dev/null || pgrep -x slurmd >/dev/null; then
    skip "a Slurm is running on this machine already"
fi

here=$(mktemp -d)
own_munge=no
finish() {
    for daemon in slurmd slurmctld; do
        [ -f "$here/$daemon.pid" ] && kill "$(cat "$here/$daemon.pid")" 2>/dev/null || true
    done
    [ "$own_munge" = yes ] && [ -f /run/munge/munged.pid ] && kill "$(cat /run/munge/munged.pid)" 2>/dev/null || true
    sleep 1
    rm -rf "$here"
}
trap finish EXIT
failed() {
    echo "slurm: $1" >&2
    tail -n 20 "$here"/*.log "$here"/*.out >&2 2>/dev/null || true
    exit 1
}

if ! munge -n >/dev/null 2>&1; then
    mkdir -p /run/munge
    chown munge:munge /run/munge
    runuser -u munge -- munged || skip "munged does not start"
    own_munge=yes
fi
host=$(hostname -s)
mkdir "$here/state" "$here/spool"
cat > "$here/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
StateSaveLocation=$here/state
SlurmdSpoolDir=$here/spool
SlurmctldPidFile=$here/slurmctld.pid
SlurmdPidFile=$here/slurmd.pid
SlurmctldLogFile=$here/slurmctld.log
SlurmdLogFile=$here/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SchedulerType=sched/builtin
ReturnToService=2
MpiDefault=none
KillWait=5
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$here/slurm.conf
slurmctld || skip "slurmctld does not start"
slurmd || skip "slurmd does not start"
for _ in $(seq 60); do
    [ "$(sinfo -h -o %t)" = idle ] && break
    sleep 0.5
done
[ "$(sinfo -h -o %t)" = idle ] || failed "the node does not come up: $(sinfo)"

# Long enough to be caught midway: some seconds a task.
cat > "$here/scene.toml" <<SCENE
[model]
sites = 101
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.6, to = 2.6, points = 800 }
y = { parameter = "gamma2", from = 0.01, to = 0.3, points = 500 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
SCENE
cd "$here"
"$MAPGEN" sweep scene.toml --out whole.csv --quiet

# Waits for the program of task $1 and prints its process id.
process_of() {
    for _ in $(seq 600); do
        for candidate in $(pgrep -f -- "sweep scene.toml --out map.csv.chunks --shard slurm" || true); do
            # The batch script's children alone carry the task's number and are not the script.
            if tr '\0' '\n' < "/proc/$candidate/environ" 2>/dev/null | grep -qx "SLURM_ARRAY_TASK_ID=$1"; then
                echo "$candidate"
                return 0
            fi
        done
        sleep 0.1
    done
    failed "task $1 was never seen running"
}
submitted=$("$OLDPWD/scripts/slurm-sweep.sbatch" scene.toml map.csv 3 --cpus-per-task=1)
echo "$submitted" | tail -n 1
array=$(echo "$submitted" | sed -n 's/^array \([0-9]*\) .*/\1/p')
merge=$(echo "$submitted" | sed -n 's/.*merge \([0-9]*\)$/\1/p')

process_of 0 > /dev/null
scontrol requeue "${array}_0"
victim=$(process_of 1)
kill -KILL "$victim"
process_of 2 > /dev/null
# The signal that a task gets a minute before its time is up.
scancel --batch --signal=USR1 "${array}_2"
echo "slurm: task 0 requeued, the program of task 1 killed, task 2 told that its time is up"

for _ in $(seq 150); do
    # A requeued job may wait for its turn for a time it has to be let off; not at once: within a second or so of a job's end its
    # node refuses to start it again.
    waiting=$(squeue -h -t PD -o '%i %r' | awk '$2 == "BeginTime" { print $1 }')
    sleep 2
    for job in $waiting; do scontrol update JobId="$job" StartTime=now >/dev/null 2>&1 || true; done
    [ -z "$(squeue -h -j "$array,$merge" 2>/dev/null)" ] && break
done
[ -f map.csv ] || failed "no merged table: $(scontrol show job "$merge" 2>&1 | head -n 20)"
cmp whole.csv map.csv || failed "the merged table differs from the one made in one piece"
for reason in killed "out of time"; do
    grep -q "^$reason: starting again" ./*.out || failed "no task was started again that was $reason"
done
echo "slurm: $(wc -l < map.csv) lines, the same bytes as in one piece"
