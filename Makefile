# make demo    builds the programs and recovers three materials from pictures of them (examples/demo)
# make extremes  shows the model at the ends of its parameters, beside closed forms (tests/extremes.rs)
# make faults  kills, soaks and starves the programs (tests/faults.rs)
# make raycast casts rays beside Embree (examples/raycast)
# make tradeoff  measures error against time (examples/tradeoff)
# make trials  recovers materials that are known, and counts how often the errors are right (examples/trials)
# make test    runs all tests

.PHONY: demo extremes faults raycast test tradeoff trials

demo:
	cargo build --locked --release --bins
	$(MAKE) -C examples/demo

extremes:
	cargo test --locked --release --test suite extremes:: -- --nocapture

faults:
	FAULTS=200 cargo test --locked --test suite faults:: -- --nocapture

raycast:
	$(MAKE) -C examples/raycast

tradeoff:
	cargo build --locked --release --bins
	$(MAKE) -C examples/tradeoff

test:
	cargo test --locked

trials:
	cargo build --locked --release --bin rtrace-rs --bin anneal
	$(MAKE) -C examples/trials
