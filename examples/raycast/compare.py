"""Ray casting beside Embree 4: the same rays at the same triangles, one thread each, in turn.

Usage: compare.py RAYCAST SCENE... (SCENE: a .obj file, or knots:TRIANGLES). Needs a C compiler and `pip install embreex`, whose Embree it uses.
Prints for each scene and set of rays the median over the rounds of millions of rays a second, and of the ratio to Embree within a round.
"""

import glob, os, statistics, subprocess, sys, tempfile
import embreex

ROUNDS, RAYS = 9, 1 << 19
SETS = ["primary", "bounced", "shadow"]

here = os.path.dirname(os.path.abspath(__file__))
(library,) = glob.glob(os.path.dirname(embreex.__file__) + "/../embreex.libs/libembree4*")


def start(*command):
    # One processor for all, so that no thread of another moves them about.
    caster = subprocess.Popen(["taskset", "-c", "1", *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return caster, caster.stdout.readline().strip()


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
        ours, said = start(sys.argv[1], scene, str(RAYS), twin)
        robust, robust_said = start(driver, library, twin, "4")
        default, _ = start(driver, library, twin, "0")
        casters = [ours, robust, default]
        print(f"# {os.path.basename(scene)}: {said}; Embree (robust) {robust_said}")
        for rays in SETS:
            [cast(c, rays) for c in casters]
            rounds = [[cast(c, rays) for c in casters] for _ in range(ROUNDS)]
            speed = [statistics.median(1e3 / r[i][0] for r in rounds) for i in range(3)]
            ratio = [statistics.median(r[i][0] / r[0][0] for r in rounds) for i in (1, 2)]
            hits = " ".join(str(h) for _, h in rounds[0])
            name = os.path.basename(scene)
            print(f"{name:24} {rays:8} {speed[0]:7.2f} {speed[1]:7.2f} {speed[2]:7.2f}         {ratio[0]:9.2f} {ratio[1]:9.2f}   {hits}", flush=True)
        for c in casters:
            c.stdin.close()
            c.wait()
