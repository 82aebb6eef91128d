"""Mitsuba's side of tradeoff.py: mitsuba_side.py VARIANT TASK. Prints [samples, seconds] of each rendering, whose picture it leaves as SAMPLES.npy."""

import json, math, sys, time
import numpy as np
import drjit as dr
import mitsuba as mi

variant, task = sys.argv[1], json.loads(sys.argv[2])
mi.set_variant(variant)
dr.set_thread_count(1)

kind, values = task["kind"], task["values"]
color = {"type": "rgb", "value": values[:3]}
medium = None
if kind == "dielectric":
    bsdf = {"type": "dielectric", "int_ior": values[3], "ext_ior": 1.0}
    # What is left of the light after a unit of length, as extinction.
    extinction = [-math.log(v) for v in values[:3]]
    medium = {"type": "homogeneous", "albedo": 0.0, "scale": 4.0, "sigma_t": {"type": "rgb", "value": [e / 4 for e in extinction]}}
else:
    bsdf = {"type": "diffuse", "reflectance": color}
    if values[3] > 0:
        rough = {"type": "roughconductor", "distribution": "beckmann", "alpha": values[4], "material": "none"}
        if kind == "metal":
            rough["specular_reflectance"] = color
        bsdf = {"type": "blendbsdf", "weight": values[3], "a": bsdf, "b": rough}

vp, vd = np.array(task["vp"]), np.array(task["vd"])
up = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
shape = {"type": "obj", "filename": task["mesh"], "bsdf": bsdf}
if medium:
    shape["interior"] = medium
scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "volpath", "max_depth": 32} if medium else {"type": "path", "max_depth": 4},
    "light": {"type": "envmap", "bitmap": mi.Bitmap(np.load(task["scratch"] + "/light.npy")), "to_world": up},
    "shape": shape,
    "sensor": {"type": "perspective", "fov": task["vh"], "to_world": mi.ScalarTransform4f().look_at(list(vp), list(vp + vd), task["vu"]),
               "film": {"type": "hdrfilm", "width": task["size"], "height": task["size"], "rfilter": {"type": "box"}, "pixel_format": "rgb"},
               "sampler": {"type": "independent"}},
})


def render(samples, seed):
    """A picture, and the processor time it took."""
    start = time.process_time()
    light = np.array(mi.render(scene, spp=samples, seed=seed))
    return light, time.process_time() - start


done = []
for samples in task["samples"]:
    # The first time, code is generated.
    light, seconds = render(samples, 1)
    if "llvm" in variant:
        light, seconds = render(samples, 2)
    np.save(f"{task['scratch']}/{samples}.npy", light)
    done.append([samples, seconds])
    if 4 * seconds > task["longest"]:
        break
# Two independent pictures of the most samples there is time for.
most = max(1, int(done[-1][0] * task["longest"] / done[-1][1]))
np.save(task["scratch"] + "/reference.npy", render(most, 99)[0])
print(json.dumps(done))
