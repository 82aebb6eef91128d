/* How many rays a second Embree 4 casts, one at a time: the other half of compare.py.
 *
 * embree LIBRARY TWIN 0|4: builds a scene (with that flag of RTCSceneFlags; 4 is ROBUST) of the triangles in TWIN, which raycast wrote; then
 * for each line with the name of a set of rays casts that set and prints nanoseconds a ray and how many rays hit. Build: cc -O3 embree.c -ldl
 * The declarations below are those of Embree's public interface that are used here. */
#include <dlfcn.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct ray { float org[3], tnear, dir[3], time, tfar; unsigned mask, id, flags; };
struct hit { float normal[3], u, v; unsigned primitive, geometry, instance[2]; };
struct rayhit { _Alignas(16) struct ray ray; struct hit hit; };
typedef void *object;

static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + t.tv_nsec * 1e-9; }

static void *read_all(FILE *file, size_t size)
{
	void *data = malloc(size + 64);
	if (!data || fread(data, 1, size, file) != size) exit(2);
	return data;
}

int main(int argc, char **argv)
{
	if (argc != 4) return fprintf(stderr, "usage: embree LIBRARY TWIN 0|4\n"), 2;
	void *library = dlopen(argv[1], RTLD_NOW);
	FILE *file = fopen(argv[2], "rb");
	if (!library || !file) return fprintf(stderr, "embree: cannot open %s\n", library ? argv[2] : argv[1]), 2;
#define GET(result, name, ...) result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))dlsym(library, #name)
	GET(object, rtcNewDevice, const char *);
	GET(object, rtcNewScene, object);
	GET(object, rtcNewGeometry, object, int);
	GET(void, rtcSetSceneFlags, object, int);
	GET(void, rtcSetSharedGeometryBuffer, object, int, unsigned, int, const void *, size_t, size_t, size_t);
	GET(void, rtcCommitGeometry, object);
	GET(unsigned, rtcAttachGeometry, object, object);
	GET(void, rtcCommitScene, object);
	GET(void, rtcIntersect1, object, struct rayhit *, void *);
	GET(void, rtcOccluded1, object, struct ray *, void *);

	uint32_t *count = read_all(file, 5 * 4);
	float *vertices = read_all(file, count[0] * 12ul);
	uint32_t *triangles = read_all(file, count[1] * 12ul);
	float *sets[3];
	for (int set = 0; set < 3; set++) sets[set] = read_all(file, count[2 + set] * 32ul);

	double start = now();
	object device = rtcNewDevice("threads=1"), scene = rtcNewScene(device), mesh = rtcNewGeometry(device, 0);
	rtcSetSceneFlags(scene, atoi(argv[3]));
	rtcSetSharedGeometryBuffer(mesh, 1, 0, 0x9003, vertices, 0, 12, count[0]);	/* Vertices, three floats. */
	rtcSetSharedGeometryBuffer(mesh, 0, 0, 0x5003, triangles, 0, 12, count[1]);	/* Indices, three unsigned. */
	rtcCommitGeometry(mesh);
	rtcAttachGeometry(scene, mesh);
	rtcCommitScene(scene);
	printf("built in %.3f s\n", now() - start);
	fflush(stdout);

	char line[32];
	while (fgets(line, sizeof line, stdin)) {
		int set = line[0] == 'p' ? 0 : line[0] == 'b' ? 1 : 2;
		uint32_t n = count[2 + set], hits = 0;
		start = now();
		for (uint32_t i = 0; i < n; i++) {
			const float *r = sets[set] + 8ul * i;
			struct rayhit x = {.ray = {.org = {r[0], r[1], r[2]}, .dir = {r[3], r[4], r[5]}, .tnear = r[6], .tfar = r[7], .mask = -1}};
			if (set == 2) {
				rtcOccluded1(scene, &x.ray, NULL);
				hits += x.ray.tfar < 0;
			} else {
				x.hit.geometry = -1;
				rtcIntersect1(scene, &x, NULL);
				hits += x.hit.geometry != -1u;
			}
		}
		printf("%.3f %u\n", (now() - start) * 1e9 / n, hits);
		fflush(stdout);
	}
	return 0;
}
