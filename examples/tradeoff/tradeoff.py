"""Error against time: rtrace-rs over its dial, beside RADIANCE's rpict and Mitsuba 3 where they are installed; anneal beside its own clock.

Usage: tradeoff.py [EXPERIMENT...]   (run by make; rtrace-rs and anneal on the PATH)
An EXPERIMENT is a directory with scene.rad, true.mat (one material), view.vf, and, for Mitsuba, NAME.obj; its light is ../room/env.rad.
Without any, the knot of examples/demo in four materials. Writes table.txt and one NAME.svg for each scene.

The error is the root mean square over the pixels that show a surface of luminance minus reference, over the mean reference. rtrace-rs is held to
the best picture of its own in half of LONGEST (30) seconds on all processors with another seed; rpict, which samples centres of pixels, to the
same with -pj 0; Mitsuba, whose materials are a little different, to itself. Time is processor time on one thread: of the whole program for
rtrace-rs and rpict (not oconv), of rendering alone, a second time, for Mitsuba. A curve ends where its next point would take longer than LONGEST;
240 goes down to one per cent.
"""

import json, os, platform, re, shutil, subprocess, sys, tempfile, time
import numpy as np
from plot import plot

HERE = os.path.dirname(os.path.abspath(__file__))
DEMO = os.path.join(HERE, "..", "demo")
SIZE = 64
LONGEST = float(os.environ.get("LONGEST", 30))
ERRORS = [".4", ".2", ".1", ".05", ".03", ".02", ".01"]
SAMPLES = ["4", "16", "64", "256", "1024", "4096"]
# Exhaustive, and cached: first what rpict does by itself.
RPICT = {
    "rpict -aa 0": [f"-ab 2 -aa 0 -ad {ad} -as 0 -ss {ss} -st 0 -lr 8 -lw {lw}" for ad, ss, lw in
                    [(16, 1, 1e-4), (64, 2, 1e-4), (256, 4, 1e-4), (1024, 16, 1e-4), (4096, 64, 1e-4), (16384, 256, 1e-5)]],
    "rpict, cached": ["-ab 2"] + [f"-ab 2 -aa {aa} -ar {ar} -ad {ad} -as {ad // 4} -ss {ss} -st 0 -lr 8" for aa, ar, ad, ss in
                                  [(.2, 64, 256, 4), (.1, 128, 512, 8), (.05, 256, 2048, 64)]],
}
MITSUBA_SAMPLES = [4, 16, 64, 256, 1024, 4096, 16384]
TIMES = [".5", "1", "2", "4", "8"]


def run(command, cwd, **options):
    """Runs a command; the processor time of it and its children, and its output."""
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
    before = os.times()
    out, said = process.communicate()
    after = os.times()
    if process.returncode != 0:
        raise RuntimeError(f"{command}: {said.decode(errors='replace')}")
    return after.children_user + after.children_system - before.children_user - before.children_system, out


def hdr(data):
    """Luminance of a RADIANCE picture."""
    size = re.search(rb"-Y +(\d+) +\+X +(\d+)\n", data)
    body, height, width = data[size.end():], int(size[1]), int(size[2])
    out, at = np.zeros((height, width, 4), np.uint8), 0
    for y in range(height):
        if body[at:at + 2] != b"\2\2":
            out[y] = np.frombuffer(body, np.uint8, 4 * width, at).reshape(width, 4)
            at += 4 * width
            continue
        at += 4
        for channel in range(4):
            x = 0
            while x < width:
                n = body[at]
                if n > 128:
                    out[y, x:x + n - 128, channel] = body[at + 1]
                    at, x = at + 2, x + n - 128
                else:
                    out[y, x:x + n, channel] = np.frombuffer(body, np.uint8, n, at + 1)
                    at, x = at + 1 + n, x + n
    rgb = (out[..., :3] + 0.5) * np.exp2(out[..., 3:].astype(float) - 136)
    return (rgb * (out[..., 3:] > 0)).reshape(-1, 3) @ [0.265, 0.670, 0.065]


def relative(light, reference, mask):
    """The RMS error within a mask, in terms of the mean of the reference there."""
    return float(np.sqrt(np.mean((light - reference)[mask] ** 2)) / np.mean(reference[mask]))


class Scene:
    """A scene, its view, what covers its pixels, and references."""

    def __init__(self, name, cwd, material, files, light, view, mesh):
        self.name, self.cwd, self.material, self.files, self.light, self.view, self.mesh = name, cwd, material, files, light, view, mesh
        words = open(material).read().split()
        self.modifier, self.kind, self.values = words[2], words[1], [float(w) for w in words[6:]]
        self.mask = {pj: self.ours("--coverage", self.modifier, "-pj", pj)[1] > 0.5 for pj in "10"}
        self.reference = {pj: self.ours("--time", str(LONGEST / 2), "--seed", "99", "-pj", pj, "-n", str(os.cpu_count()))[1] for pj in "10"}

    def ours(self, *options):
        command = ["rtrace-rs", "-q", "-vf", self.view, "-x", str(SIZE), "-y", str(SIZE), "-ab", "2", "-n", "1", *options]
        seconds, out = run(command + [self.material] + self.files, self.cwd)
        return seconds, hdr(out)

    def error(self, light, pj="1", reference=None):
        return relative(light, self.reference[pj] if reference is None else reference, self.mask[pj])


def of_rtrace(scene):
    for option, values in [("--spp", SAMPLES), ("--error", ERRORS)]:
        for value in values:
            seconds, light = scene.ours(option, value)
            yield f"rtrace-rs {option}", f"{option} {value}", seconds, scene.error(light)
            if 4 * seconds > LONGEST:
                break


def of_rpict(scene):
    if not shutil.which("rpict") or not shutil.which("oconv"):
        print("SKIPPED: rpict or oconv is not on the PATH", file=sys.stderr)
        return
    # oconv reads RADIANCE's own meshes only.
    with tempfile.TemporaryDirectory() as scratch:
        files = scene.files
        if scene.mesh and not scene.mesh.endswith(".rtm") and scene.cwd == DEMO:
            rtm = scratch + "/knot.rtm"
            run(["obj2mesh", "-a", "/dev/null", scene.mesh, rtm], scene.cwd)
            description = open(os.path.join(scene.cwd, scene.files[-1])).read().replace("knot.obj", rtm)
            open(scratch + "/object.rad", "w").write(description)
            files = scene.files[:-1] + [scratch + "/object.rad"]
        _, octree = run(["oconv", scene.material] + files, scene.cwd)
        open(scratch + "/scene.oct", "wb").write(octree)
        for curve, settings in RPICT.items():
            for options in settings:
                command = ["rpict", "-vf", scene.view, "-x", str(SIZE), "-y", str(SIZE), "-ps", "1", "-pj", "0", *options.split()]
                seconds, out = run(command + [scratch + "/scene.oct"], scene.cwd)
                yield curve, options, seconds, scene.error(hdr(out), "0")
                if 4 * seconds > LONGEST:
                    break


def of_mitsuba(scene):
    """Each variant in a process of its own: one that lacks what it needs ends there."""
    if not scene.mesh or not scene.mesh.endswith(".obj"):
        return
    with tempfile.TemporaryDirectory() as scratch:
        width, height = 1024, 512
        u, v = np.meshgrid((np.arange(width) + 0.5) / width * 2 * np.pi, (np.arange(height) + 0.5) / height * np.pi)
        # Mitsuba's panorama, turned so that z is up.
        directions = np.stack([np.sin(v) * np.sin(u), np.sin(v) * np.cos(u), np.cos(v)], -1).reshape(-1, 3)
        rays = np.hstack([np.zeros_like(directions), directions]).astype("<f8")
        open(scratch + "/rays", "wb").write(rays.tobytes())
        _, out = run(["rtrace-rs", "-h-", "-fdf", "--spp", "1", scene.light], scene.cwd, stdin=open(scratch + "/rays", "rb"))
        np.save(scratch + "/light.npy", np.frombuffer(out, "<f4").reshape(height, width, 3))
        view = open(os.path.join(scene.cwd, scene.view)).read().split()
        number = lambda name, n: [float(w) for w in view[view.index(name) + 1:view.index(name) + 1 + n]]
        task = {"mesh": os.path.join(scene.cwd, scene.mesh), "kind": scene.kind, "values": scene.values, "size": SIZE,
                "vp": number("-vp", 3), "vd": number("-vd", 3), "vu": number("-vu", 3), "vh": number("-vh", 1)[0],
                "samples": MITSUBA_SAMPLES, "scratch": scratch, "longest": LONGEST}
        for variant in ["scalar_rgb", "llvm_ad_rgb"]:
            done = subprocess.run([sys.executable, os.path.join(HERE, "mitsuba_side.py"), variant, json.dumps(task)], capture_output=True, text=True)
            if done.returncode != 0:
                print(f"# SKIPPED: Mitsuba {variant}: {(done.stderr.strip().splitlines() or ['it ended without a word'])[-1][:100]}", flush=True)
                continue
            reference = np.load(scratch + "/reference.npy").reshape(-1, 3) @ [0.265, 0.670, 0.065]
            same = scene.error(reference)
            print(f"# {scene.name}: Mitsuba's reference and ours differ by {same:.3f} of the mean", flush=True)
            for samples, seconds in json.loads(done.stdout):
                light = np.load(f"{scratch}/{samples}.npy").reshape(-1, 3) @ [0.265, 0.670, 0.065]
                yield f"mitsuba {variant}", f"{samples} samples", seconds, scene.error(light, reference=reference)


def of_anneal(scene):
    """The largest error of a parameter against the time that anneal is given."""
    starts = {"metal": "red=.5:0:1 green=.5:0:1 blue=.5:0:1 spec=.5:.4:1 rough=.1:0:.3",
              "plastic": "red=.5:0:1 green=.5:0:1 blue=.5:0:1 spec=.2:0:.3 rough=.2:0:.3",
              "dielectric": "red=.5:0:1 green=.5:0:1 blue=.5:0:1 ior=1:0:2"}.get(scene.kind)
    if not starts or "diffuse" in scene.name:
        return
    with tempfile.TemporaryDirectory() as scratch:
        target, start = scratch + "/target.hdr", scratch + "/start.rad"
        first = [w.split("=")[1].split(":")[0] for w in starts.split()] + (["0"] if scene.kind == "dielectric" else [])
        open(start, "w").write(f"void {scene.kind} {scene.modifier}\n0\n0\n5 {' '.join(first)}\n")
        big = ["-x", "128", "-y", "128", "-ab", "2"]
        run(["rtrace-rs", "-q", "-vf", scene.view, *big, "--spp", "256", "--seed", "1", "-o", target, scene.material, *scene.files], scene.cwd)
        parameters = sum((["--param", w] for w in starts.split()), [])
        scenes = sum((["--scene", f] for f in scene.files), [])
        for limit in TIMES:
            command = ["anneal", "-q", "-n", "1", "-ab", "2", *scenes, "-vf", scene.view, "--target", target, *parameters, "--time", limit, start]
            seconds, out = run(command, scene.cwd)
            found = [float(w) for w in re.sub(rb"#.*", b"", out).split()[6:11]]
            off = max(abs(a - b) for a, b in zip(found, scene.values))
            yield "anneal", f"--time {limit}", seconds, off


def demo_scenes(scratch):
    run(["make", "-C", DEMO, "panorama.hdr", "knot.obj"], DEMO)
    open(scratch + "/diffuse.rad", "w").write("void plastic finish\n0\n0\n5 .7 .7 .7 0 0\n")
    for name in ["metal", "plastic", "dielectric", "diffuse"]:
        material = f"{scratch}/diffuse.rad" if name == "diffuse" else f"{DEMO}/{name}.true.rad"
        yield Scene(f"knot-{name}", DEMO, material, ["light.rad", "object.rad"], "light.rad", "camera.vf", "knot.obj")


def experiment(directory):
    name = os.path.basename(os.path.normpath(directory))
    mesh = next((p for p in [f"{directory}/{name}.obj", f"{directory}/../../data/mesh/{name}.obj"] if os.path.exists(p)), None)
    return Scene(name, directory, f"{directory}/true.mat", ["scene.rad"], "../room/env.rad", "view.vf", mesh and os.path.abspath(mesh))


def main():
    processor = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.processor())
    print(f"# {processor}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}; {time.strftime('%Y-%m-%d')}")
    print(f"# {SIZE} x {SIZE} pixels, one thread, processor time")
    with tempfile.TemporaryDirectory() as scratch:
        for scene in [experiment(os.path.abspath(d)) for d in sys.argv[1:]] if sys.argv[1:] else demo_scenes(scratch):
            curves = {}
            print(f"\n{scene.name:15} {'seconds':>8} {'error':>7}", flush=True)
            for side in [of_rtrace, of_rpict, of_mitsuba]:
                for curve, setting, seconds, error in side(scene):
                    curves.setdefault(curve, []).append((seconds, error))
                    print(f"{'':15} {seconds:8.3f} {error:7.4f}  {curve.split(' --')[0].split(',')[0].split(' -aa')[0]} {setting}", flush=True)
            plot(f"{scene.name}.svg", f"{scene.name}: error against time", curves, "processor time (s)", "relative RMS error")
            recovery = list(of_anneal(scene))
            for _, setting, seconds, off in recovery:
                print(f"{'':15} {seconds:8.3f} {off:7.4f}  anneal {setting}: largest error of a parameter", flush=True)
            if recovery:
                plot(f"{scene.name}-anneal.svg", f"{scene.name}: what is recovered", {"anneal": [r[2:] for r in recovery]}, "processor time (s)",
                     "largest error of a parameter")


if __name__ == "__main__":
    main()
