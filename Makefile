# make demo    builds the programs and recovers three materials from pictures of them (examples/demo)
# make test    runs all tests

.PHONY: demo test

demo:
	cargo build --locked --release --bin rtrace-rs --bin imgdiff --bin anneal
	$(MAKE) -C examples/demo

test:
	cargo test --locked
