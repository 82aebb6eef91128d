"""Ray casting beside Embree 4: the same rays at the same triangles, one thread each, in turn.

Usage: compare.py RAYCAST SCENE... (SCENE: a .obj file, or knots:TRIANGLES). Needs a C compiler and `pip install embreex`, whose Embree it uses.
Prints for each scene and set of rays the median over the rounds of millions of rays a second, and of the ratio to Embree within a round.
"""

import glob, os, statistics, subprocess, sys, tempfile
import embreex

ROUNDS, RAYS = 5, 1 << 19
SETS = ["primary", "bounced", "shadow"]

# The rays of both lie in huge pages, as both casters' trees do: what is timed is not how a list of rays is read from memory.
os.environ["GLIBC_TUNABLES"] = "glibc.malloc.hugetlb=1"

here = os.path.dirname(os.path.abspath(__file__))
(library,) = glob.glob(os.path.dirname(embreex.__file__) + "/../embreex.libs/libembree4*")


def start(*command):
    # One processor for all, so that no thread of another moves them about.
    caster = subprocess.Popen(["taskset", "-c", "1", *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return caster, caster.stdout.readline().strip()


def finish(caster):
    caster.stdin.close()
    caster.wait()


def cast(caster, rays):
    caster.stdin.write(rays + "\n")
    caster.stdin.flush()
    time, hits = caster.stdout.readline().split()
    return float(time), int(hits)


with tempfile.TemporaryDirectory() as scratch:
    driver, twin = scratch + "/embree", scratch + "/twin"
    subprocess.run(["cc", "-O3", "-o", driver, here + "/embree.c", "-ldl"], check=True)
    print(f"{'scene':24} {'rays':8} {'ours':>7} {'robust':>7} {'default':>7} Mrays/s {'x robust':>9} {'x default':>9}   hits")
    for scene in sys.argv[2:]:
        name, rounds = os.path.basename(scene), {rays: [] for rays in SETS}
        # Who starts first is given what memory is left over, in small pieces far apart: among 10^6 triangles that alone costs it a fifth. So each
        # starts first once. The twin is written by a start of ours that casts nothing.
        finish(start(sys.argv[1], scene, str(RAYS), twin)[0])
        for first in range(3):
            casters, said = [None] * 3, [None] * 3
            for i in [first, (first + 1) % 3, (first + 2) % 3]:
                command = (driver, library, twin, {1: "4", 2: "0"}[i]) if i else (sys.argv[1], scene, str(RAYS))
                casters[i], said[i] = start(*command)
            for rays in SETS:
                [cast(c, rays) for c in casters]
                rounds[rays] += [[cast(c, rays) for c in casters] for _ in range(ROUNDS)]
            for c in casters:
                finish(c)
        print(f"# {name}: {said[0]}; Embree (robust) {said[1]}")
        for rays in SETS:
            speed = [statistics.median(1e3 / r[i][0] for r in rounds[rays]) for i in range(3)]
            ratio = [statistics.median(r[i][0] / r[0][0] for r in rounds[rays]) for i in (1, 2)]
            hits = " ".join(str(h) for _, h in rounds[rays][0])
            print(f"{name:24} {rays:8} {speed[0]:7.2f} {speed[1]:7.2f} {speed[2]:7.2f}         {ratio[0]:9.2f} {ratio[1]:9.2f}   {hits}", flush=True)
