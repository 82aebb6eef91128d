#!/bin/sh
# One picture on several machines, with GNU parallel: every job takes some of the samples of all pixels, and the parts are joined to the
# very bytes that one machine would give.
#
#   parallel.sh SAMPLES JOBS OUT [OPTIONS AND SCENE OF rtrace-rs...]
#   parallel.sh 4096 64 horse.exr -vf view.vf -x 800 -y 800 scene.rad
#
# The bytes are those of: rtrace-rs -vf view.vf -x 800 -y 800 scene.rad --spp 4096 -o horse.exr
#
# HOSTS lists the machines, as parallel's --sshlogin does (HOSTS=node1,node2,:). The default, ":", is this machine without ssh. All must see
# this directory under the same name, and have rtrace-rs on their PATH and the same kind of processor. A job that fails is tried again, and
# parts that are there already are not made anew: the same command goes on where it was broken off.
set -eu
samples=$1 jobs=$2 out=$3
shift 3
parts=$out.parts
mkdir -p "$parts"
i=0
while [ "$i" -lt "$jobs" ]; do
    from=$((samples * i / jobs)) to=$((samples * (i + 1) / jobs))
    i=$((i + 1))
    [ "$from" -lt "$to" ] && [ ! -e "$parts/$from..$to.exr" ] && echo "$from..$to"
done |
    parallel --no-notice --sshlogin "${HOSTS:-:}" --workdir . --jobs "${PER_HOST:-1}" --retries 3 --quote \
        rtrace-rs -q "$@" --samples {} -o "$parts/{}.exr"
rtrace-rs --merge -o "$out" "$parts"/*.exr
rm -r "$parts"
