# Prints what was found beside the truth. Files: paper.txt, then TYPE.true.rad TYPE.found.rad TYPE.time of each material.

FNR == 1 { files++; i = 0 }

# The paper's errors, by type.
FILENAME == "paper.txt" { if (!/^#/) paper[$1] = $0; next }

# The truth: the type, and the real arguments.
FILENAME ~ /true/ { if (FNR == 1) type = $2; if (/^5 /) truth = $0; next }

# The time at the beginning and at the end.
FILENAME ~ /time$/ {
	if (FNR == 1) { began = $1; next }
	time = $1 - began
	printf "\n%s, %.*f s%s\n", type, time < 10, time, lines
	lines = ""
	next
}

# What was found: `# NAME VALUE ± ERROR`, in the order of the arguments.
/^# warning: / { lines = lines "\n  " substr($0, 3) }
/^# [a-z0-9]+ [-+.0-9e]+ / && $2 != "chi2" {
	i++
	split(truth, t); split(paper[type], p)
	off = $3 - t[i + 1]; if (off < 0) off = -off
	lines = lines sprintf("\n  %-6s %6s   %9.5f ± %-9s %8.5f %12.4f", $2, t[i + 1], $3, $5, off, p[i + 1])
	all++; if (off <= p[i + 1]) near++
}

BEGIN { print "            true   recovered ± error      off by   paper off by" }
END { printf "\n%d of %d are as near to the truth as the paper's, or nearer.\n", near, all }
