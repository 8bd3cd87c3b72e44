#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The lines of docs/batch.md for GNU parallel and for Slurm, and those of docs/cohorts.md for Slurm and Snakemake, run
# as they stand there: with small scenes in the place of mouths, and for Slurm on a cluster of one node (munged,
# slurmctld and slurmd of our own) that lives in a temporary folder. The trees must be those of one run.
# Usage: job_arrays.sh slurm|parallel|snakemake PROGRAM PAGE      Exit code 77, skipped, where the scheduler is not
# installed.
set -u
kind=$1
program=$(realpath "$2")
page=$(realpath "$3")

skip() {
  echo "skipped: $*"
  exit 77
}
folder=$(mktemp -d)
started=()
finish() {
  [[ ${#started[@]} -gt 0 ]] && kill "${started[@]}" 2>/dev/null
  wait
  rm -rf "$folder"
}
trap finish EXIT
fail() {
  echo "FAILED: $*" >&2
  tail -n 5 "$folder"/*.log "$folder"/work/*.out >&2 2>/dev/null
  exit 1
}

# The block of indented lines in the page that holds the word.
lines_with() { awk -v word="$1" '/^    /{block = block substr($0, 5) "\n"; next} {if (index(block, word)) printf "%s", block; block = ""}' "$page"; }

start_cluster() {
  local host port
  host=$(hostname -s)
  port=$((20000 + $$ % 20000))
  mkdir "$folder/state" "$folder/spool"
  chmod 711 "$folder"
  (umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
  cat >"$folder/slurm.conf" <<END
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
END
  export SLURM_CONF=$folder/slurm.conf
  munged --foreground --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
    --seed-file="$folder/munge.seed" --log-file="$folder/munged.log" >"$folder/munged.out.log" 2>&1 &
  started+=($!)
  for _ in $(seq 50); do [[ -S $folder/munge.socket ]] && break; sleep 0.1; done
  slurmctld -D >"$folder/slurmctld.log" 2>&1 &
  started+=($!)
  slurmd -D >"$folder/slurmd.log" 2>&1 &
  started+=($!)
  for _ in $(seq 100); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && return
    sleep 0.2
  done
  fail "the cluster does not start"
}

case $kind in
  parallel)
    parallel --version 2>/dev/null | grep -q "GNU parallel" || skip "GNU parallel is not installed"
    ;;
  snakemake)
    command -v snakemake >/dev/null || skip "snakemake is not installed"
    ;;
  slurm)
    for needed in munged slurmctld slurmd sbatch squeue sinfo; do
      PATH=$PATH:/usr/sbin:/sbin command -v $needed >/dev/null || skip "$needed is not installed"
    done
    [[ $EUID -eq 0 ]] || skip "a cluster of our own needs root"
    PATH=$PATH:/usr/sbin:/sbin
    start_cluster
    ;;
esac
word=$kind
[[ $kind == slurm ]] && word=sbatch
[[ $kind == parallel ]] && word="parallel -j"
lines=$(lines_with "$word")
[[ $lines == *shard* ]] || fail "the page has no lines for $kind"

# A torus and scaled copies of it: small, and each another mesh.
mkdir "$folder/work" "$folder/bin"
ln -s "$program" "$folder/bin/spheretree"
PATH=$folder/bin:$PATH
cd "$folder/work" || exit 1
objects=""
for i in 0 1 2 3 4 5; do
  awk -v n=16 -v size=$((10 + i)) 'BEGIN {
    pi = atan2(0, -1)
    for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) {
      u = 2 * pi * i / n; v = 2 * pi * j / n; r = size + 3 * cos(v)
      printf "v %.9f %.9f %.9f\n", r * cos(u), r * sin(u), 3 * sin(v)
    }
    for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) {
      a = i * n + j + 1; b = (i + 1) % n * n + j + 1; c = (i + 1) % n * n + (j + 1) % n + 1; d = i * n + (j + 1) % n + 1
      printf "f %d %d %d\nf %d %d %d\n", a, b, c, a, c, d
    }
  }' >ring$i.obj
  [[ $i -gt 0 ]] && objects+="${objects:+, }{\"name\": \"ring$i\", \"mesh\": \"ring$i.obj\"}"
done
cat >mouth.scene.json <<END
{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 3},
 "tool": {"name": "tool", "mesh": "ring0.obj"}, "objects": [$objects]}
END
if [[ $page == *cohorts.md ]]; then
  cp "$(dirname "$page")/Snakefile" .
  for i in 1 2 3 4 5; do
    mkdir P$i
    sed "s|\"ring0|\"../ring0|; s|\"objects\": .*|\"objects\": [{\"name\": \"ring\", \"mesh\": \"../ring$i.obj\"}]}|" mouth.scene.json >P$i/mouth.scene.json
    echo "{\"patient\": \"P$i\", \"scene\": \"P$i/mouth.scene.json\"}" >>list.jsonl
  done
  spheretree batch --cohort list.jsonl -o whole >../whole.log 2>&1 || fail "the run without shards"
else
  spheretree batch mouth.scene.json -o whole >../whole.log 2>&1 || fail "the run without shards"
fi

echo "$lines"
bash -euc "$lines" >../lines.log 2>&1 || fail "a line of the page"
if [[ $kind == slurm ]]; then
  for _ in $(seq 600); do
    [[ -z $(squeue -h) ]] && break
    sleep 0.2
  done
  [[ -z $(squeue -h) ]] || fail "jobs do not end: $(squeue)"
fi
if [[ $page == *cohorts.md ]]; then
  [[ -s cohort.html || -s trees/cohort.html ]] || fail "no page was written"
  [[ $(cat trees/cohort.*-of-8.jsonl | wc -l) == 5 ]] || fail "not each patient has a line"
  for file in whole/P*/*.stree whole/P*/scene.json; do cmp "$file" "trees/${file#*/}" || fail "${file#*/} differs"; done
  echo "$kind: the same bytes as one run"
  exit 0
fi
[[ -f mouth/report.json ]] || fail "no report was written"
grep -q '"built": 0,' mouth/report.json || fail "the last run built what the shards should have built"
for file in whole/*.stree whole/scene.json; do cmp "$file" "mouth/${file#*/}" || fail "${file#*/} differs"; done
echo "$kind: the same bytes as one run"
