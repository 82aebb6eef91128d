"""Does --error keep what it promises? The knot of examples/demo in eight materials, at five errors each.

Usage: promise.py   (run by make; rtrace-rs on the PATH)
The true error is that against a picture of 24 seconds with another seed, whose own error is subtracted. Prints a line for each picture: what
was asked for, what the picture says of itself (NOISE= in its header), what is true; then how many keep to it.
"""

import os, re, tempfile
from tradeoff import DEMO, SIZE, hdr, relative, run

MATERIALS = {
    "metal": "metal .8 .6 .3 .9 .01", "rough metal": "metal .8 .6 .3 .9 .2", "plastic": "plastic .7 .7 .7 .12 .125",
    "sharp plastic": "plastic .3 .4 .5 .05 .02", "diffuse": "plastic .7 .7 .7 0 0", "trans": "trans .6 .6 .5 .05 .1 .5 .6",
    "dark glass": "dielectric .7 .2 .1 1.5 0", "clear glass": "dielectric .95 .95 .95 1.5 0",
}
ERRORS = [".2", ".1", ".05", ".03", ".02"]
FACTOR = 1.33


def picture(material, *options):
    """Luminances, and the error that the header tells."""
    command = ["rtrace-rs", "-q", "-vf", "camera.vf", "-x", str(SIZE), "-y", str(SIZE), "-ab", "2", *options, material, "light.rad", "object.rad"]
    _, out = run(command, DEMO)
    noise = re.search(rb"NOISE= ?([\d.e-]+)", out)
    return hdr(out), float(noise[1]) if noise else 0.0


def main():
    run(["make", "-C", DEMO, "panorama.hdr", "knot.obj"], DEMO)
    kept = honest = count = 0
    with tempfile.TemporaryDirectory() as scratch:
        for name, numbers in MATERIALS.items():
            material = scratch + "/material.rad"
            kind, values = numbers.split(" ", 1)
            open(material, "w").write(f"void {kind} finish\n0\n0\n{len(values.split())} {values}\n")
            shown = picture(material, "--coverage", "finish")[0] > 0
            best, rest = picture(material, "--time", "24", "--seed", "99")
            for asked in ERRORS:
                light, said = picture(material, "--error", asked, "--seed", "7")
                true = max(relative(light, best, shown) ** 2 - rest**2, 0.0) ** 0.5
                print(f"{name:15} asked {asked:>4}  said {said:.4f}  true {true:.4f}  said/true {said / true:.2f}", flush=True)
                kept += true <= float(asked)
                honest += 1 / FACTOR <= said / true <= FACTOR
                count += 1
    print(f"{kept} of {count} as good as asked, {honest} within a factor {FACTOR} of what they say")


main()
