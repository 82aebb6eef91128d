"""Synthetic trials: trials.py COUNT [FIRST]. Run by make; rtrace-rs and anneal on the PATH.

Each trial draws a type, its numbers, a light and how noisy the picture is; renders the picture; recovers the numbers, the type being known; and
lets anneal find the type. Prints how far each value is off in terms of its standard error, how many lie within two, and how often the type was found.
"""

import os, random, re, subprocess, sys, tempfile

DEMO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "demo")
SKY = """void glow sky 0 0 4 .5 .6 .9 0
sky source above 0 0 4 0 0 1 180
void glow ground 0 0 4 .3 .2 .1 0
ground source below 0 0 4 0 0 -1 180
void light bulb 0 0 3 6 5 4
bulb sphere lamp1 0 0 4 -3 2 2.5 1
bulb sphere lamp2 0 0 4 3 2 1.5 .7
"""
PANORAMA = """void colorpict panorama 9 red green blue panorama.hdr angular.cal ang_u ang_v -rz TURN 0 0
panorama glow panorama_glow 0 0 4 1 1 1 0
panorama_glow source around 0 0 4 0 0 1 360
"""
KNOT = "finish mesh knot 1 knot.obj 0 0\n"
PANE = """void plastic red 0 0 5 .6 .1 .1 0 0
void plastic blue 0 0 5 .1 .2 .6 0 0
red polygon behind1 0 0 12 2 -1.5 -1.5 2 0 -1.5 2 0 1.5 2 -1.5 1.5
blue polygon behind2 0 0 12 2 0 -1.5 2 1.5 -1.5 2 1.5 1.5 2 0 1.5
finish polygon pane 0 0 12 0 -.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5
"""
SECONDS = "6"
VIEW = "VIEW= -vtv -vp -3.1 -.9 .7 -vd 3.1 .9 -.66 -vu 0 0 1 -vh 21 -vv 21\n"
NAMES = {"plastic": "red green blue spec rough", "metal": "red green blue spec rough", "trans": "red green blue spec rough trans tspec",
         "dielectric": "red green blue ior", "glass": "red green blue"}
START = {"plastic": ".5 .5 .5 .1 .1", "metal": ".5 .5 .5 .5 .1", "trans": ".5 .5 .5 .05 .1 .5 .5", "dielectric": ".5 .5 .5 1.3 0", "glass": ".5 .5 .5"}


def material(kind, draw):
    color = [draw.uniform(0.1, 0.9) for _ in range(3)]
    rough = draw.choice([0.02, 0.05, 0.1, 0.15, 0.2]) * draw.uniform(0.8, 1.2)
    return color + {"plastic": [draw.uniform(0.03, 0.15), rough], "metal": [draw.uniform(0.5, 0.95), rough],
                    "trans": [draw.uniform(0.03, 0.1), rough, draw.uniform(0.3, 0.7), draw.uniform(0.2, 0.8)],
                    "dielectric": [draw.uniform(1.2, 1.8), 0.0], "glass": []}[kind]


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode > 1:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    return done.stdout


def trial(number):
    draw = random.Random(number)
    kind = sorted(NAMES)[number % len(NAMES)]
    numbers = [float(f"{v:.4g}") for v in material(kind, draw)]
    light = draw.choice([SKY, PANORAMA.replace("TURN", str(draw.randrange(360)))])
    noise = draw.choice(["64", "256", "1024"])
    body = PANE if kind in ("trans", "glass") else KNOT
    with tempfile.TemporaryDirectory() as scratch:
        write = lambda name, text: open(os.path.join(scratch, name), "w").write(text)
        for name in ["panorama.hdr", "knot.obj"]:
            os.symlink(os.path.abspath(os.path.join(DEMO, name)), os.path.join(scratch, name))
        write("scene.rad", light + body)
        write("view.vf", VIEW)
        arguments = " ".join(str(v) for v in numbers)
        write("true.rad", f"void {kind} finish 0 0 {len(numbers)} {arguments}\n")
        write("start.rad", f"void {kind} finish 0 0 {len(numbers)} {START[kind]}\n")
        write("plastic.rad", f"void plastic finish 0 0 5 {START['plastic']}\n")
        os.chdir(scratch)
        run("rtrace-rs", "-q", "-vf", "view.vf", "-x", "64", "-y", "64", "-ab", "2", "--spp", noise, "--seed", str(number), "-o", "target.hdr",
            "true.rad", "scene.rad")
        look = ["anneal", "-q", "-ab", "2", "--scene", "scene.rad", "-vf", "view.vf", "--target", "target.hdr", "--time", SECONDS]
        found = run(*look, "start.rad")
        typed = run(*look, "--type", "auto", "plastic.rad")
    said = {m[1]: (float(m[2]), float(m[3])) for m in re.finditer(r"^# (\w+) (\S+) ± ([0-9.e-]+)", found, re.M)}
    off = {name: (said[name][0] - true) / said[name][1] for name, true in zip(NAMES[kind].split(), numbers) if name in said}
    title = re.search(r"^# type (.*)", typed, re.M)[1]
    right = re.split("[ ;]", title)[0] == kind or f"{kind}, the same" in title
    stated = right or "does not tell" in typed or f"{kind}, another" in title
    return kind, arguments, noise, off, title, right, stated


def main():
    count, first = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    within = values = found = doubted = 0
    for number in range(first, first + count):
        kind, arguments, noise, off, title, right, stated = trial(number)
        values += len(off)
        within += sum(abs(z) <= 2 for z in off.values())
        found += right
        doubted += stated and not right
        print(f"{number:3} {kind} {arguments}, {noise} samples: " + " ".join(f"{n} {z:+.1f}" for n, z in off.items()), flush=True)
        print(f"      {'' if right else 'NOT ' }found: {title}", flush=True)
    print(f"{within} of {values} values within two standard errors of the truth ({100 * within / values:.0f} %); "
          f"{found} of {count} types found, doubt stated in {doubted} of the others")


main()
