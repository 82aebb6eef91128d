#!/bin/sh
#SBATCH --job-name=rtrace-rs
#SBATCH --array=0-63
#SBATCH --cpus-per-task=4
# One picture on a cluster, with a Slurm array: every task takes some of the samples of all pixels; a last job joins the parts to the very
# bytes that one machine would give.
#
#   job=$(sbatch --parsable slurm.sh 4096 horse.exr -vf view.vf -x 800 -y 800 scene.rad)
#   sbatch --dependency=afterok:"$job" --wrap 'rtrace-rs --merge -o horse.exr horse.exr.parts/*.exr'
#
# A task that failed is run again alone: sbatch --array=17 slurm.sh … with TASKS=64 in the environment, which keeps the shares.
set -eu
samples=$1 out=$2
shift 2
tasks=${TASKS:-$SLURM_ARRAY_TASK_COUNT} i=$SLURM_ARRAY_TASK_ID
from=$((samples * i / tasks)) to=$((samples * (i + 1) / tasks))
mkdir -p "$out.parts"
exec rtrace-rs -q -n "${SLURM_CPUS_PER_TASK:-1}" "$@" --samples "$from..$to" -o "$out.parts/$from..$to.exr"
