# make demo    builds the programs and recovers three materials from pictures of them (examples/demo)
# make raycast casts rays beside Embree (examples/raycast)
# make test    runs all tests

.PHONY: demo raycast test

demo:
	cargo build --locked --release --bin rtrace-rs --bin imgdiff --bin anneal
	$(MAKE) -C examples/demo

raycast:
	$(MAKE) -C examples/raycast

test:
	cargo test --locked
