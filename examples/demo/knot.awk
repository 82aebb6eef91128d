# Prints a trefoil knot as a Wavefront mesh with normals: smooth, concave, about one unit across, upright.
# awk -f knot.awk > knot.obj

# The axis of the rope at t.
function axis(t, p) {
	p[1] = SIZE*sin(3*t); p[2] = SIZE*(sin(t) + 2*sin(2*t)); p[3] = SIZE*(2*cos(2*t) - cos(t))
}

# Makes v a unit vector.
function unit(v,   l) {
	l = sqrt(v[1]^2 + v[2]^2 + v[3]^2); v[1] /= l; v[2] /= l; v[3] /= l
}

BEGIN {
	SIZE = .155; ROPE = .1		# A sixth of the width of the axis; the radius of the rope.
	RINGS = 400; POINTS = 64	# Along the rope, and around it.
	TURN = 8*atan2(1, 1)
	for (i = 0; i < RINGS; i++) {
		t = TURN*i/RINGS
		axis(t, p); axis(t - 1e-4, b); axis(t + 1e-4, f)
		# Forward, across, and what is square to both: a frame that closes on itself.
		f[1] -= b[1]; f[2] -= b[2]; f[3] -= b[3]; unit(f)
		a[1] = 0; a[2] = f[3]; a[3] = -f[2]; unit(a)
		u[1] = a[2]*f[3] - a[3]*f[2]; u[2] = a[3]*f[1] - a[1]*f[3]; u[3] = a[1]*f[2] - a[2]*f[1]
		for (j = 0; j < POINTS; j++) {
			c = cos(TURN*j/POINTS); s = sin(TURN*j/POINTS)
			for (k = 1; k <= 3; k++) n[k] = c*a[k] + s*u[k]
			printf "v %.6f %.6f %.6f\n", p[1] + ROPE*n[1], p[2] + ROPE*n[2], p[3] + ROPE*n[3]
			printf "vn %.6f %.6f %.6f\n", n[1], n[2], n[3]
		}
	}
	for (i = 0; i < RINGS; i++) for (j = 0; j < POINTS; j++) {
		print "f", corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
	}
}

# The vertex and normal that stand at a place on the rope.
function corner(i, j,   n) {
	n = i%RINGS*POINTS + j%POINTS + 1
	return n "//" n
}
