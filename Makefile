# make demo    builds the programs and recovers three materials from pictures of them (examples/demo)
# make faults  kills, soaks and starves the programs (tests/faults.rs)
# make raycast casts rays beside Embree (examples/raycast)
# make tradeoff  measures error against time (examples/tradeoff)
# make test    runs all tests

.PHONY: demo faults raycast test tradeoff

demo:
	cargo build --locked --release --bin rtrace-rs --bin imgdiff --bin anneal
	$(MAKE) -C examples/demo

faults:
	FAULTS=200 cargo test --locked --test faults -- --nocapture

raycast:
	$(MAKE) -C examples/raycast

tradeoff:
	cargo build --locked --release --bins
	$(MAKE) -C examples/tradeoff

test:
	cargo test --locked
